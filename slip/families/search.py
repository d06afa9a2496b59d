"""Branches found so far, those still to follow, and how one leads to the next."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from slip.families.branch import Branch, Junction
from slip.families.continuation import MERGES, Point, StepConfig, Trace, speed_limit, trace
from slip.families.junction import Crossing, crossings, turning_point
from slip.model.naming import family_of
from slip.model.parameters import SlipParameters
from slip.model.unknowns import COUNT, DX, pair_swap
from slip.orbits.floquet import multipliers_of
from slip.orbits.independent_simulation import disagreement
from slip.orbits.newton import NoConvergence, correct
from slip.orbits.orbit import Orbit
from slip.orbits.stride import integrate_stride
from slip.orbits.subspace import Subspace, subspace
from slip.orbits.validity import objection
from symdyn.errors import InvalidValue

Vector = NDArray[np.float64]
Report = Callable[[str, int], None]
"""Called with what is being done and with the orbits found so far."""

LEAST_ORBITS = 3
"""A trace of fewer orbits is no branch."""
CONFIRMED = 1e-7
"""Largest difference between an orbit and its independent simulation, states, event times and period."""
SAME = 0.02
"""Orbits whose unknowns differ by less are the same junction, or lie on the same branch."""


@dataclass(frozen=True)
class ExploreConfig:
    """What to look for, and how far.

    Attributes:
        steps: of the continuation.
        trot: whether to look for trot and pace, too.
        highest_hop: apex height above the rest length up to which hopping in place is searched [rest length].
        most_branches: after so many the search ends.
        homotopy: steps from one set of parameters to another, at least.
        seeds: orbits of the reference parameters to carry over for every family that no junction leads to.
    """

    steps: StepConfig = field(default_factory=StepConfig)
    trot: bool = True
    highest_hop: float = 1.0
    most_branches: int = 30
    homotopy: int = 8
    seeds: int = 3

    def __post_init__(self) -> None:
        if not self.highest_hop > 0.0:
            raise InvalidValue("highest_hop", self.highest_hop, "> 0")
        if self.seeds < 0:
            raise InvalidValue("seeds", self.seeds, "at least 0")
        for name in ("most_branches", "homotopy"):
            if getattr(self, name) < 1:
                raise InvalidValue(name, getattr(self, name), "at least 1")


@dataclass(frozen=True)
class Start:
    """Somewhere to begin a branch.

    Attributes:
        space: that the branch lies in.
        unknowns: of the orbit or junction, (22,).
        direction: to walk in first, (22,).
        crossing: the junction, or None for an orbit in the middle of a branch, which is walked both ways.
        on: name of the branch that the junction lies on.
        pair: that parts there, as in slip.families.branch.Junction.
    """

    space: Subspace
    unknowns: Vector
    direction: Vector
    crossing: Crossing | None = None
    on: str = ""
    pair: str = ""


class Search:
    """Branches and junctions found so far, and a queue of places where more begin.

    Attributes:
        branches: in the order in which they were found.
        spaces: of each branch.
        junctions: between them.
        missing: families that were not found, with the reason.
        refused: of those, solutions that are no gaits, (22,).
        queue: where branches begin that are not traced yet.
    """

    def __init__(self, parameters: SlipParameters, config: ExploreConfig, report: Report) -> None:
        self.parameters, self.config, self.report = parameters, config, report
        self.vector = parameters.vector()
        self.branches: list[Branch] = []
        self.junctions: list[Junction] = []
        self.spaces: list[Subspace] = []
        self.missing: dict[str, str] = {}
        self.refused: dict[str, Vector] = {}
        self.queue: deque[Start] = deque()

    @property
    def orbits(self) -> int:
        """How many there are on all branches."""
        return sum(len(branch) for branch in self.branches)

    def run(self) -> None:
        """Follow everything in the queue, and what is found on the way."""
        while self.queue and len(self.branches) < self.config.most_branches:
            self.follow(self.queue.popleft())

    def walk(self, space: Subspace, unknowns: Vector, direction: Vector) -> Trace:
        """The branch from an orbit or junction in a direction, as far as its orbits are confirmed."""
        count = self.orbits

        def tell(point: Point) -> None:
            nonlocal count
            count += 1
            self.report(family_of(point.unknowns, space.pairs), count)

        walked = trace(space, unknowns, space.coordinates(direction), self.vector, self.config.steps, tell)
        return self.confirmed(space, walked)

    def confirmed(self, space: Subspace, walked: Trace) -> Trace:
        """The trace up to the first orbit that the independent simulation does not confirm, with its turning points."""
        points: list[Point] = []
        for at in self.with_turning_points(space, walked.points):
            difference = disagreement(Orbit(at.unknowns, self.parameters))
            if not difference < CONFIRMED:
                return Trace(tuple(points), "a simulation that detects its events meets others", at.unknowns)
            points.append(replace(at, confirmed=difference))
        return replace(walked, points=tuple(points))

    def within_limit(self, points: tuple[Point, ...]) -> tuple[Point, ...]:
        """The points of a branch without those at its ends that are beyond the speed limit."""
        slow = [i for i, at in enumerate(points) if at.unknowns[DX] <= self.config.steps.max_speed]
        return points[slow[0] : slow[-1] + 1] if slow else ()

    def with_turning_points(self, space: Subspace, points: tuple[Point, ...]) -> list[Point]:
        """Points and between them, exactly, those where the apex speed is largest or smallest."""
        result = list(points[:1])
        for before, after in pairwise(points):
            turning = turning_point(space, before, after, self.vector)
            if turning is not None and objection(integrate_stride(turning.unknowns, self.vector), self.vector) is None:
                result.append(turning)
            result.append(after)
        return result

    def name_at(self, space: Subspace, unknowns: Vector) -> str | None:
        """Name of the branch that an orbit lies on, if it was traced already."""
        for branch, where in zip(self.branches, self.spaces, strict=True):
            if where is space and _distance(branch, unknowns) < SAME:
                return branch.name
        return None

    def follow(self, start: Start) -> None:
        """Trace the branch that begins somewhere, unless it is known."""
        if start.crossing is None:
            self.follow_orbit(start)
            return
        walked = self.walk(start.space, start.unknowns, start.direction)
        if len(walked.points) < LEAST_ORBITS:
            return
        probe = walked.points[min(len(walked.points) - 1, 6)].unknowns
        if self.name_at(start.space, probe) is not None:
            return
        names = self.add(start.space, walked.points, (f"leaves {start.on}", walked.end))
        self.junctions.append(Junction.at(start.unknowns, start.on, names[0], start.pair))
        self.join_at_end(start.space, walked, names[-1])

    def follow_orbit(self, start: Start) -> None:
        """Trace the branch through an orbit, both ways, unless it is known."""
        if self.name_at(start.space, start.unknowns) is not None:
            return
        forwards = self.walk(start.space, start.unknowns, start.direction)
        backwards = self.walk(start.space, start.unknowns, -start.direction)
        # tangents must point one way, and with them the signs of the tests of the block
        flipped = tuple(
            replace(p, tangent=-p.tangent, tests=p.tests | {"even": -p.tests["even"]})
            for p in reversed(backwards.points)
        )
        points = (*flipped, *forwards.points)
        kept = self.within_limit(points)
        if len(kept) < LEAST_ORBITS:
            return
        limit = speed_limit(self.config.steps)
        ends = (
            backwards.end if kept[0] is points[0] else limit,
            forwards.end if kept[-1] is points[-1] else limit,
        )
        names = self.add(start.space, kept, ends)
        for walked, end, name in ((backwards, ends[0], names[0]), (forwards, ends[1], names[-1])):
            if end == walked.end and walked.points:
                self.join_at_end(start.space, walked, name)

    def add(self, space: Subspace, points: tuple[Point, ...], ends: tuple[str, str]) -> list[str]:
        """Store a trace, cut where the family changes, and queue what leaves it. Returns the names, in order."""
        families = [family_of(p.unknowns, space.pairs) for p in points]
        cuts = [0, *(i for i in range(1, len(points)) if families[i] != families[i - 1]), len(points)]
        names: list[str] = []
        name_at: list[str] = []
        for a, b in pairwise(cuts):
            name = self.numbered(families[a], names)
            names.append(name)
            name_at += [name] * (b - a)
        for i, (a, b) in enumerate(pairwise(cuts)):
            unknowns = np.array([p.unknowns for p in points[a:b]])
            orbits = [Orbit(u, self.parameters) for u in unknowns]
            here = (
                ends[0] if i == 0 else f"goes over into {names[i - 1]}",
                ends[1] if b == len(points) else f"goes over into {names[i + 1]}",
            )
            floquet = np.array([multipliers_of(o, p.jacobian) for o, p in zip(orbits, points[a:b], strict=True)])
            confirmed = np.array([p.confirmed for p in points[a:b]])
            self.branches.append(Branch(names[i], self.parameters, unknowns, floquet, confirmed, here))
            self.spaces.append(space)
        if space.pairs:
            for i, (before, after) in enumerate(pairwise(points)):
                for crossing in crossings(space, before, after, self.vector):
                    self.branch_off(space, crossing, name_at[i])
        return names

    def refuse(self, family: str, walked: Trace) -> None:
        """Note that a family begins with solutions that are no gaits."""
        reason = f"the equations have a solution, but {walked.end}"
        if reason not in self.missing.get(family, ""):
            self.missing[family] = "; ".join(filter(None, (self.missing.get(family), reason)))
        if walked.refused is not None:
            self.refused.setdefault(family, walked.refused)

    def numbered(self, family: str, new: list[str]) -> str:
        """The name of a family's next branch: BG, BG2, BG3 ..."""
        taken = [branch.name for branch in self.branches] + new
        count = sum(1 for name in taken if name.rstrip("0123456789") == family)
        return family if count == 0 else f"{family}{count + 1}"

    def branch_off(self, space: Subspace, crossing: Crossing, on: str) -> None:
        """Queue the branches that leave at a junction."""
        if "even" in crossing.kinds:
            # where pairs part as well (the pronk's end), half-bounds are reached from the bounds
            pair = "none" if len(crossing.kinds) == 1 else "both"
            for sign in (1.0, -1.0):
                direction = sign * crossing.directions["even"]
                self.queue.append(Start(space, crossing.unknowns, direction, crossing, on, pair))
            return
        for pair in crossing.kinds:
            child = crossing.space_after(pair, space)
            self.queue.append(Start(child, crossing.unknowns, crossing.directions[pair], crossing, on, pair))

    def join_at_end(self, space: Subspace, walked: Trace, name: str) -> None:
        """A branch whose parted feet come together again ends on another: say where."""
        pair = next((p for p, end in MERGES.items() if walked.end == end), None)
        if pair is None:
            return
        parent = subspace(*space.pairs, pair)
        coordinates = parent.coordinates(walked.points[-1].unknowns)
        try:
            landed = correct(parent, coordinates, np.eye(COUNT)[DX] @ parent.basis, self.vector).coordinates
        except NoConvergence:
            return
        if np.abs(landed - coordinates).max() > SAME:
            return
        unknowns = parent.unknowns(landed)
        for junction in self.junctions:
            if np.abs(np.array(junction.unknowns) - unknowns).max() < SAME:
                # known from the other branch, and more exactly
                self.junctions.append(replace(junction, to=name))
                return
        on = self.name_at(parent, unknowns) or family_of(unknowns, parent.pairs)
        self.junctions.append(Junction.at(unknowns, on, name, pair))


def _distance(branch: Branch, unknowns: Vector) -> float:
    """Largest difference of an orbit, or one of its left-right images, to the nearest place on a branch."""
    if len(branch) < 2:
        return np.inf
    starts, along = branch.unknowns[:-1], np.diff(branch.unknowns, axis=0)
    result = np.inf
    for image in _images(unknowns):
        share = np.einsum("ij,ij->i", image - starts, along) / np.einsum("ij,ij->i", along, along)
        nearest = starts + np.clip(share, 0.0, 1.0)[:, None] * along
        result = min(result, float(np.abs(nearest - image).max(axis=1).min()))
    return result


def _images(unknowns: Vector) -> list[Vector]:
    """An orbit with left and right exchanged in the hind pair, the front pair, both."""
    hind, front = list(pair_swap("hind")), list(pair_swap("front"))
    return [unknowns, unknowns[hind], unknowns[front], unknowns[hind][front]]
