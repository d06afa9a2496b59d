"""Pseudo-arclength continuation of a branch of orbits, with adaptive steps."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slip.model.unknowns import COUNT, DALPHA, DX, PAIRS, pair_difference
from slip.orbits.newton import NoConvergence, correct
from slip.orbits.stride import Stride, turns_of
from slip.orbits.subspace import Subspace
from slip.orbits.validity import objection
from symdyn.errors import InvalidValue

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

_AT_REST = 1e-9
_CLOSE_TO_END = 1e-3
MERGES = {pair: f"the {pair} feet come together" for pair in PAIRS}
"""Ends of branches that run into one of higher symmetry."""


@dataclass(frozen=True)
class StepConfig:
    """How a branch is walked.

    Attributes:
        first: length of the first step, in the Euclidean norm of the 22 unknowns.
        largest: of all steps.
        smallest: below it the tracing gives up.
        sharpest: largest angle between tangents of neighbouring orbits [rad].
        most: orbits of a branch.
        max_speed: apex speed at which the tracing ends [sqrt(g torso length)]; a branch that begins above is followed
            down.
    """

    first: float = 0.005
    largest: float = 0.2
    smallest: float = 1e-6
    sharpest: float = 0.3
    most: int = 600
    max_speed: float = 15.0

    def __post_init__(self) -> None:
        if not 0.0 < self.smallest <= self.first <= self.largest:
            raise InvalidValue(
                "step lengths", (self.smallest, self.first, self.largest), "0 < smallest <= first <= largest"
            )
        if self.most < 2:
            raise InvalidValue("most", self.most, "at least 2 orbits")
        if not 0.0 < self.sharpest < math.pi:
            raise InvalidValue("sharpest", self.sharpest, "in (0, pi), rad")
        if not self.largest < math.inf:
            raise InvalidValue("largest", self.largest, "a finite number")
        if not self.max_speed > 0.0:
            raise InvalidValue("max_speed", self.max_speed, "> 0")


@dataclass(frozen=True)
class Point:
    """An orbit on a branch.

    Attributes:
        unknowns: (22,).
        tangent: of the branch, in the coordinates of its subspace, (m,).
        jacobian: of the residual by the unknowns, (22, 22).
        tests: test functions; each changes sign at a junction. ``even``: a branch of the same symmetry crosses.
            ``hind``, ``front``: one leaves whose pair of that name has parted.
        confirmed: difference to the independent simulation, NaN where that was not asked or met other events.
    """

    unknowns: Vector
    tangent: Vector
    jacobian: Matrix
    tests: dict[str, float]
    confirmed: float = np.nan


def point(space: Subspace, stride: Stride, unknowns: Vector, along: Vector) -> Point:
    """The point of an orbit; its tangent points the way ``along`` does."""
    block = space.jacobian(stride.jacobian)
    tangent = np.linalg.svd(block)[2][-1]
    tangent = tangent if tangent @ along >= 0.0 else -tangent
    tests = {pair: float(np.linalg.det(space.odd_block(stride.jacobian, pair))) for pair in space.pairs}
    tests["even"] = float(np.linalg.det(np.vstack((block, tangent))))
    return Point(unknowns, tangent, stride.jacobian, tests)


def smooth_part(space: Subspace) -> Vector:
    """1 for every coordinate but those of dalpha, (m,).

    Where an event crosses the apex, the dalpha of its leg has a kink along the branch, and tangents on the two sides
    may point against each other in it; the other coordinates go straight on.
    """
    weights = np.ones(COUNT)
    weights[list(DALPHA)] = 0.0
    return (space.basis != 0.0).T @ weights > 0.0


@dataclass(frozen=True)
class Trace:
    """A branch as walked.

    Attributes:
        points: in order.
        end: why it ended.
        refused: the solution of the equations at which it ended because that is no gait, (22,), if so.
    """

    points: tuple[Point, ...]
    end: str
    refused: Vector | None = None


def trace(
    space: Subspace,
    start: Vector,
    along: Vector,
    parameters: Vector,
    config: StepConfig,
    report: Callable[[Point], None] = lambda _: None,
) -> Trace:
    """Walk a branch.

    Args:
        space: subspace that the branch lies in.
        start: an orbit of it or the junction where it begins, (22,); itself not part of the result.
        along: direction of the first step, in the coordinates of the subspace, (m,).
        parameters: (7,).
        config: step lengths and limits.
        report: called with every point.
    """
    points: list[Point] = []
    coordinates, tangent = space.coordinates(start), along / np.linalg.norm(along)
    smooth = smooth_part(space)
    length, trouble = config.first, ""
    while len(points) < config.most:
        if length < config.smallest:
            return Trace(tuple(points), trouble)
        predicted = coordinates + length * tangent
        try:
            corrected = correct(space, predicted, smooth * tangent, parameters)
        except NoConvergence as failure:
            trouble, length = f"no orbit further on: {failure}", 0.5 * length
            continue
        unknowns = space.unknowns(corrected.coordinates)
        new = point(space, corrected.stride, unknowns, smooth * (corrected.coordinates - coordinates))
        # where an event crosses the apex the branch has a kink
        kink = not np.array_equal(corrected.stride.turns, turns_of(space.unknowns(coordinates)))
        if kink and length > config.first:
            trouble, length = "an event crosses the apex", 0.5 * length
            continue
        if points and not kink and new.tangent @ tangent < np.cos(config.sharpest):
            trouble, length = "the branch turns too sharply", 0.5 * length
            continue
        no_gait = objection(corrected.stride, parameters)
        end = no_gait or _end(space, points[-1].unknowns if points else start, unknowns, config)
        if end is not None:
            # come close to where the branch ends, then stop
            trouble, length = end, 0.5 * length
            if length < _CLOSE_TO_END * config.largest or not points:
                return Trace(tuple(points), end, unknowns if no_gait else None)
            continue
        points.append(new)
        report(new)
        coordinates, tangent = corrected.coordinates, new.tangent
        if corrected.iterations <= 5:
            length = min(config.largest, 1.5 * length)
        elif corrected.iterations > 8:
            length *= 0.7
        if _closed(space, points, start):
            return Trace(tuple(points), "the branch closes on itself")
    return Trace(tuple(points), f"the limit of {config.most} orbits")


def speed_limit(config: StepConfig) -> str:
    """The end of a branch that goes on beyond the speed limit."""
    return f"the speed limit of {config.max_speed:g}"


def _end(space: Subspace, before: Vector, now: Vector, config: StepConfig) -> str | None:
    if now[DX] > config.max_speed and now[DX] > before[DX]:
        return speed_limit(config)
    if now[DX] < -_AT_REST:
        return "comes to rest"
    for pair in PAIRS:
        if pair in space.pairs:
            continue
        # the difference between the two legs of a pair turns round: it went through zero
        difference = pair_difference(pair)
        a, b = before @ difference, now @ difference
        if a @ b < -0.5 * np.linalg.norm(a) * np.linalg.norm(b):
            return MERGES[pair]
    return None


def _closed(space: Subspace, points: list[Point], start: Vector) -> bool:
    if len(points) < 20:
        return False
    gap = np.linalg.norm(space.coordinates(points[-1].unknowns - start))
    return bool(gap < 0.5 * np.linalg.norm(points[-1].unknowns - points[-2].unknowns))
