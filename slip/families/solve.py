"""Single orbits: from a guess, or of a family at a speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from slip.families.branch import Branch, Diagram
from slip.model.parameters import SlipParameters
from slip.model.unknowns import COUNT, PAIRS, UNKNOWN_NAMES, checked
from slip.orbits.newton import NoConvergence, correct
from slip.orbits.orbit import Orbit
from slip.orbits.subspace import subspace
from slip.orbits.validity import objection
from symdyn.errors import SymdynError, UnknownName

Vector = NDArray[np.float64]


class NoOrbit(SymdynError):
    """No periodic gait was found; says why, and what to try.

    Attributes:
        reason: ``no convergence``, ``no gait`` or ``speed``.
    """

    def __init__(self, reason: Literal["no convergence", "no gait", "speed"], message: str) -> None:
        super().__init__(message)
        self.reason = reason


@dataclass(frozen=True)
class Held:
    """The unknown that is held fixed while an orbit is solved for: orbits come in one-parameter branches.

    Attributes:
        name: of slip.model.unknowns.UNKNOWN_NAMES.
        value: at which it is held; that of the guess if None.
    """

    name: str = "dx"
    value: float | None = None

    def __post_init__(self) -> None:
        if self.name not in UNKNOWN_NAMES:
            raise UnknownName("unknown", self.name, UNKNOWN_NAMES)


def solve_orbit(
    guess: Vector, parameters: SlipParameters, held: Held | None = None, pairs: tuple[str, ...] = ()
) -> Orbit:
    """The orbit near a guess.

    Args:
        guess: (22,), see slip.model.unknowns.
        parameters: of the model.
        held: which unknown is kept; the apex speed if None.
        pairs: of ``hind``, ``front``: pairs of legs that are made to move together.

    Returns:
        An orbit whose residuals are all below 1e-10 and that is a gait: legs push, feet touch down from above.

    Raises:
        NoOrbit: with the reason and what to try.
        InvalidValue: for a guess of the wrong shape or a value that is not finite.
        UnknownName: for a pair that is neither ``hind`` nor ``front``.
    """
    held = held or Held()
    start = checked(guess)
    for pair in pairs:
        if pair not in PAIRS:
            raise UnknownName("pair of legs", pair, PAIRS)
    if held.value is not None:
        start[UNKNOWN_NAMES.index(held.name)] = held.value
        start = checked(start)
    space = subspace(*pairs)
    normal = np.eye(COUNT)[UNKNOWN_NAMES.index(held.name)] @ space.basis
    try:
        corrected = correct(space, space.coordinates(start), normal, parameters.vector())
    except NoConvergence as failure:
        raise NoOrbit(
            "no convergence",
            f"No orbit near the guess: {failure}. Try a closer guess, for instance a neighbour on a branch "
            f"(symdyn families), or hold another unknown than {held.name}, which may have a turning point here.",
        ) from None
    problem = objection(corrected.stride, parameters.vector())
    if problem is not None:
        raise NoOrbit(
            "no gait",
            f"The equations have a solution near the guess, but {problem}. Try another speed, family or stiffness.",
        )
    return Orbit(space.unknowns(corrected.coordinates), parameters)


def orbits_at(source: Diagram | Branch, speed: float, family: str | None = None) -> list[Orbit]:
    """All orbits of a family with an apex speed; a branch with turning points has several.

    Args:
        source: a branch, or a diagram with the name of a family or branch.
        speed: dx at the apex [sqrt(g torso length)].
        family: needed with a diagram.

    Raises:
        UnknownName: if the diagram has no such family.
        NoOrbit: if no branch of the family reaches that speed; says which speeds there are.
    """
    branches = (source,) if isinstance(source, Branch) else source.family(family or "")
    found: list[Orbit] = []
    for branch in branches:
        ahead = branch.speeds >= speed
        for i in np.flatnonzero(ahead[1:] != ahead[:-1]):
            share = (speed - branch.speeds[i]) / (branch.speeds[i + 1] - branch.speeds[i])
            guess = (1.0 - share) * branch.unknowns[i] + share * branch.unknowns[i + 1]
            found.append(solve_orbit(guess, branch.parameters, Held("dx", speed), branch.pairs))
    if not found:
        ranges = ", ".join(f"{b.name} {b.speeds.min():.4f} to {b.speeds.max():.4f}" for b in branches)
        raise NoOrbit("speed", f"No orbit with apex speed {speed:g}. Speeds of this family: {ranges}.")
    return found
