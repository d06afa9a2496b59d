"""The 22 unknowns of a periodic gait and where each stands.

Order: dx, y, dy, phi, dphi of the torso at the apex; alpha, dalpha of each leg; touchdown and lift-off of each leg;
the stride period T. Horizontal position is left out: it is not periodic.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from symdyn.errors import InvalidValue
from symdyn.robot.legs import is_front

Vector = NDArray[np.float64]

SLIP_LEGS = ("LH", "LF", "RH", "RF")
"""Order of the legs in the unknowns, the literature's (left hind, left front, right hind, right front)."""

TORSO = ("dx", "y", "dy", "phi", "dphi")
STATE_NAMES = (*TORSO, *(f"{rate}alpha_{leg}" for leg in SLIP_LEGS for rate in ("", "d")))
"""The 13 periodic states."""

EVENT_NAMES = tuple(f"{event}_{leg}" for leg in SLIP_LEGS for event in ("touchdown", "liftoff"))
UNKNOWN_NAMES = (*STATE_NAMES, *EVENT_NAMES, "period")

STATES = slice(0, len(STATE_NAMES))
EVENTS = slice(len(STATE_NAMES), len(STATE_NAMES) + len(EVENT_NAMES))
PERIOD = len(UNKNOWN_NAMES) - 1
COUNT = len(UNKNOWN_NAMES)

DX, Y, DY, PHI, DPHI = (STATE_NAMES.index(name) for name in TORSO)
ALPHA = tuple(STATE_NAMES.index(f"alpha_{leg}") for leg in SLIP_LEGS)
DALPHA = tuple(STATE_NAMES.index(f"dalpha_{leg}") for leg in SLIP_LEGS)
TOUCHDOWN = tuple(UNKNOWN_NAMES.index(f"touchdown_{leg}") for leg in SLIP_LEGS)
LIFTOFF = tuple(UNKNOWN_NAMES.index(f"liftoff_{leg}") for leg in SLIP_LEGS)
HIND = tuple(i for i, leg in enumerate(SLIP_LEGS) if not is_front(leg))
FRONT = tuple(i for i, leg in enumerate(SLIP_LEGS) if is_front(leg))
PAIRS = {"hind": HIND, "front": FRONT}
"""Left and right leg (positions in :data:`SLIP_LEGS`) of each pair."""


def of_leg(leg: int) -> tuple[int, int, int, int]:
    """Where alpha, dalpha, touchdown and lift-off of a leg (position in :data:`SLIP_LEGS`) stand."""
    return ALPHA[leg], DALPHA[leg], TOUCHDOWN[leg], LIFTOFF[leg]


def checked(unknowns: object) -> Vector:
    """The unknowns as a fresh float vector.

    Raises:
        InvalidValue: if there are not 22, one is not finite, or the period is not positive.
    """
    vector = np.array(unknowns, dtype=np.float64)
    if vector.shape != (COUNT,):
        raise InvalidValue("unknowns", vector.shape, f"{COUNT} numbers: {', '.join(UNKNOWN_NAMES)}")
    if not np.all(np.isfinite(vector)):
        bad = [name for name, value in zip(UNKNOWN_NAMES, vector, strict=True) if not np.isfinite(value)]
        raise InvalidValue("unknowns", f"not finite in {', '.join(bad)}", "finite")
    if vector[PERIOD] <= 0.0:
        raise InvalidValue("period", vector[PERIOD], "> 0")
    return vector


def pair_swap(pair: str) -> tuple[int, ...]:
    """Permutation of the unknowns that exchanges left and right of the ``hind`` or the ``front`` pair."""
    index = list(range(COUNT))
    left, right = PAIRS[pair]
    for a, b in zip(of_leg(left), of_leg(right), strict=True):
        index[a], index[b] = b, a
    return tuple(index)


def pair_difference(pair: str) -> Vector:
    """Orthonormal left-minus-right directions of a pair: alpha, dalpha, touchdown, lift-off; (22, 4)."""
    left, right = PAIRS[pair]
    basis = np.zeros((COUNT, 4))
    for column, (a, b) in enumerate(zip(of_leg(left), of_leg(right), strict=True)):
        basis[a, column], basis[b, column] = np.sqrt(0.5), -np.sqrt(0.5)
    return basis


def wrapped(unknowns: Vector) -> Vector:
    """The same gait with every event time moved into [0, T)."""
    result = unknowns.copy()
    result[EVENTS] = np.mod(result[EVENTS], result[PERIOD])
    return result
