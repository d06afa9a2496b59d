"""Where every search begins: hopping in place, known in closed form."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from slip.model.parameters import SlipParameters
from slip.model.unknowns import COUNT, LIFTOFF, PERIOD, SLIP_LEGS, TOUCHDOWN, Y
from symdyn.errors import InvalidValue


def fall_and_stance(stiffness: float, height: float) -> tuple[float, float]:
    """Times of a unit mass that hops on springs.

    The stance is a harmonic oscillation about the static compression 1 / K, entered with the speed of a fall.

    Args:
        stiffness: K, of all legs on the ground together [M g / torso length].
        height: of the apex above the rest length [torso length].

    Returns:
        (from apex to touchdown, from touchdown to lift-off) [sqrt(torso length / g)].

    Raises:
        InvalidValue: if one is not positive.
    """
    if not stiffness > 0.0:
        raise InvalidValue("stiffness", stiffness, "> 0")
    if not height > 0.0:
        raise InvalidValue("height", height, "> 0")
    fall, speed, frequency = math.sqrt(2.0 * height), math.sqrt(2.0 * height), math.sqrt(stiffness)
    # above the equilibrium by 1 / K at touchdown, moving down
    stance = 2.0 * (math.pi - math.atan2(speed / frequency, 1.0 / stiffness)) / frequency
    return fall, stance


def pronk_in_place(parameters: SlipParameters, height: float) -> NDArray[np.float64]:
    """Unknowns of hopping in place on four legs, (22,); an orbit if the torso is symmetric.

    Args:
        parameters: of the model.
        height: of the apex above the rest length [torso length].
    """
    fall, stance = fall_and_stance(4.0 * parameters.stiffness, height)
    unknowns = np.zeros(COUNT)
    unknowns[Y] = parameters.rest_length + height
    unknowns[list(TOUCHDOWN)], unknowns[list(LIFTOFF)] = fall, fall + stance
    unknowns[PERIOD] = 2.0 * fall + stance
    return unknowns


def trot_in_place(parameters: SlipParameters, height: float) -> NDArray[np.float64]:
    """Unknowns of hopping in place on one diagonal pair, then on the other, (22,); an orbit if the torso is symmetric.

    Args:
        parameters: of the model.
        height: of the apex above the rest length [torso length].
    """
    fall, stance = fall_and_stance(2.0 * parameters.stiffness, height)
    half = 2.0 * fall + stance
    unknowns = np.zeros(COUNT)
    unknowns[Y] = parameters.rest_length + height
    for i, leg in enumerate(SLIP_LEGS):
        start = 0.0 if leg in ("LH", "RF") else half
        unknowns[TOUCHDOWN[i]], unknowns[LIFTOFF[i]] = start + fall, start + fall + stance
    unknowns[PERIOD] = 2.0 * half
    return unknowns
