"""All families of passive gaits, found from hopping in place alone.

The pronk in place is known in closed form. Walking along it in height, the tracer meets the junction where the moving
pronk begins; along the pronk, the one where bounds begin; along bounds, half-bounds; along half-bounds, gallops. Trot and
pace begin at hopping on two legs. A torso that is not symmetric has no pronk: its families are reached by changing the
parameters of a symmetric one step by step.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from slip.branch import FAMILIES, Branch, Diagram, Junction
from slip.continuation import MERGES, Point, StepConfig, Trace, trace
from slip.floquet import multipliers_of
from slip.junction import Crossing, crossings, turning_point
from slip.naming import family_of
from slip.newton import NoConvergence, correct
from slip.orbit import Orbit
from slip.parameters import SlipParameters
from slip.rest import pronk_in_place, trot_in_place
from slip.simulate import disagreement
from slip.stride import integrate_stride
from slip.subspace import Subspace, subspace
from slip.unknowns import COUNT, DX, Y, pair_swap
from slip.validity import objection
from symdyn.errors import InvalidValue

Vector = NDArray[np.float64]
Report = Callable[[str, int], None]
"""Called with what is being done and with the orbits found so far."""

LEAST_ORBITS = 3
"""A trace of fewer orbits is no branch."""
CONFIRMED = 1e-7
"""Largest difference between an orbit and its independent simulation, states, event times and period."""
_SAME = 0.02
"""Orbits whose unknowns differ by less are the same junction, or lie on the same branch."""
_MOVES = 0.02
"""Share of dx in the direction of a junction from which on the new branch counts as moving."""


@dataclass(frozen=True)
class ExploreConfig:
    """What to look for, and how far.

    Attributes:
        steps: of the continuation.
        trot: whether to look for trot and pace, too.
        highest_hop: apex height above the rest length up to which hopping in place is searched [torso length].
        most_branches: after so many the search ends.
        homotopy: steps from a symmetric torso to one that is not.
    """

    steps: StepConfig = field(default_factory=StepConfig)
    trot: bool = True
    highest_hop: float = 1.0
    most_branches: int = 30
    homotopy: int = 8

    def __post_init__(self) -> None:
        if not self.highest_hop > 0.0:
            raise InvalidValue("highest_hop", self.highest_hop, "> 0")
        for name in ("most_branches", "homotopy"):
            if getattr(self, name) < 1:
                raise InvalidValue(name, getattr(self, name), "at least 1")


@dataclass(frozen=True)
class _Start:
    """Somewhere to begin a branch."""

    space: Subspace
    unknowns: Vector
    direction: Vector
    crossing: Crossing | None = None
    on: str = ""
    pair: str = ""


class _Search:
    def __init__(self, parameters: SlipParameters, config: ExploreConfig, report: Report) -> None:
        self.parameters, self.config, self.report = parameters, config, report
        self.vector = parameters.vector()
        self.branches: list[Branch] = []
        self.junctions: list[Junction] = []
        self.spaces: list[Subspace] = []
        self.missing: dict[str, str] = {}
        self.refused: dict[str, Vector] = {}
        self.queue: deque[_Start] = deque()

    @property
    def orbits(self) -> int:
        return sum(len(branch) for branch in self.branches)

    def run(self) -> None:
        while self.queue and len(self.branches) < self.config.most_branches:
            self.follow(self.queue.popleft())

    def walk(self, space: Subspace, unknowns: Vector, direction: Vector, steps: StepConfig | None = None) -> Trace:
        count = self.orbits

        def tell(point: Point) -> None:
            nonlocal count
            count += 1
            self.report(family_of(point.unknowns, space.pairs), count)

        walked = trace(space, unknowns, space.coordinates(direction), self.vector, steps or self.config.steps, tell)
        return walked if steps else self.confirmed(space, walked)

    def confirmed(self, space: Subspace, walked: Trace) -> Trace:
        """The trace up to the first orbit that the independent simulation does not confirm, with its turning points."""
        points: list[Point] = []
        for at in self.with_turning_points(space, walked.points):
            difference = disagreement(Orbit(at.unknowns, self.parameters))
            if not difference < CONFIRMED:
                return Trace(tuple(points), "a simulation that detects its events meets others", at.unknowns)
            points.append(replace(at, confirmed=difference))
        return replace(walked, points=tuple(points))

    def with_turning_points(self, space: Subspace, points: tuple[Point, ...]) -> list[Point]:
        """Points and between them, exactly, those where the apex speed is largest or smallest."""
        result = list(points[:1])
        for before, after in zip(points, points[1:], strict=False):
            turning = turning_point(space, before, after, self.vector)
            if turning is not None and objection(integrate_stride(turning.unknowns, self.vector), self.vector) is None:
                result.append(turning)
            result.append(after)
        return result

    def name_at(self, space: Subspace, unknowns: Vector) -> str | None:
        """Name of the branch that an orbit lies on."""
        for branch, where in zip(self.branches, self.spaces, strict=True):
            if where is space and _distance(branch, unknowns) < _SAME:
                return branch.name
        return None

    def known(self, space: Subspace, unknowns: Vector) -> bool:
        """Whether an orbit lies on a branch that was traced already."""
        return self.name_at(space, unknowns) is not None

    def follow(self, start: _Start) -> None:
        if start.crossing is None:
            self.follow_orbit(start)
            return
        walked = self.walk(start.space, start.unknowns, start.direction)
        if len(walked.points) < LEAST_ORBITS:
            return
        probe = walked.points[min(len(walked.points) - 1, 6)].unknowns
        if self.known(start.space, probe):
            return
        names = self.add(start.space, walked.points, (f"leaves {start.on}", walked.end))
        self.junctions.append(Junction.at(start.unknowns, start.on, names[0], start.pair))
        self.join_at_end(start.space, walked, names[-1])

    def follow_orbit(self, start: _Start) -> None:
        if self.known(start.space, start.unknowns):
            return
        forwards = self.walk(start.space, start.unknowns, start.direction)
        backwards = self.walk(start.space, start.unknowns, -start.direction)
        points = (*reversed(backwards.points), *forwards.points)
        if len(points) < LEAST_ORBITS:
            return
        # tangents must point one way, and with them the signs of the tests of the block
        flipped = tuple(
            replace(p, tangent=-p.tangent, tests=p.tests | {"even": -p.tests["even"]})
            for p in points[: len(backwards.points)]
        )
        names = self.add(start.space, (*flipped, *forwards.points), (backwards.end, forwards.end))
        self.join_at_end(start.space, backwards, names[0])
        self.join_at_end(start.space, forwards, names[-1])

    def add(self, space: Subspace, points: tuple[Point, ...], ends: tuple[str, str]) -> list[str]:
        """Store a trace, cut where the family changes, and queue what leaves it. Returns the names, in order."""
        families = [family_of(p.unknowns, space.pairs) for p in points]
        cuts = [0, *(i for i in range(1, len(points)) if families[i] != families[i - 1]), len(points)]
        names: list[str] = []
        name_at: list[str] = []
        for a, b in zip(cuts, cuts[1:], strict=False):
            name = self.numbered(families[a], names)
            names.append(name)
            name_at += [name] * (b - a)
        for i, (a, b) in enumerate(zip(cuts, cuts[1:], strict=False)):
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
            for i, (before, after) in enumerate(zip(points, points[1:], strict=False)):
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
        taken = [branch.name for branch in self.branches] + new
        count = sum(1 for name in taken if name.rstrip("0123456789") == family)
        return family if count == 0 else f"{family}{count + 1}"

    def branch_off(self, space: Subspace, crossing: Crossing, on: str) -> None:
        if "even" in crossing.kinds:
            # where pairs part as well (the pronk's end), half-bounds are reached from the bounds
            pair = "none" if len(crossing.kinds) == 1 else "both"
            for sign in (1.0, -1.0):
                direction = sign * crossing.directions["even"]
                self.queue.append(_Start(space, crossing.unknowns, direction, crossing, on, pair))
            return
        for pair in crossing.kinds:
            child = crossing.space_after(pair, space)
            self.queue.append(_Start(child, crossing.unknowns, crossing.directions[pair], crossing, on, pair))

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
        if np.abs(landed - coordinates).max() > _SAME:
            return
        unknowns = parent.unknowns(landed)
        for junction in self.junctions:
            if np.abs(np.array(junction.unknowns) - unknowns).max() < _SAME:
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


def explore(
    parameters: SlipParameters,
    config: ExploreConfig | None = None,
    report: Report = lambda _what, _count: None,
) -> Diagram:
    """Find the families of passive gaits of a model.

    Args:
        parameters: of the model.
        config: what to look for.
        report: told what is being done, for a progress display.

    Returns:
        All branches and junctions; families that do not exist are in ``missing``, with how that showed.
    """
    config = config or ExploreConfig()
    if not parameters.front_hind_symmetric:
        return _from_symmetric(parameters, config, report)
    search = _Search(parameters, config, report)
    _moving_pronk(search)
    search.run()
    if config.trot:
        _moving_trot(search)
        search.run()
    return _diagram(search)


def _diagram(search: _Search) -> Diagram:
    found = {branch.family for branch in search.branches}
    for family in EXPECTED if search.config.trot else EXPECTED[:-2]:
        if family not in found and family not in search.missing:
            search.missing[family] = "no junction on the branches that were traced leads to it"
    order = list(FAMILIES)
    # a branch that goes over into another family counts after those that run from junction to junction
    whole = [b.ends[0].startswith("leaves") or b.ends[1] in MERGES.values() for b in search.branches]
    ranked = sorted(range(len(whole)), key=lambda i: (order.index(search.branches[i].family), not whole[i], i))
    count: dict[str, int] = {}
    names: dict[str, str] = {}
    for i in ranked:
        family = search.branches[i].family
        count[family] = count.get(family, 0) + 1
        names[search.branches[i].name] = family if count[family] == 1 else f"{family}{count[family]}"

    def renamed(text: str) -> str:
        *words, last = text.split(" ")
        return " ".join((*words, names.get(last, last)))

    branches = [
        replace(branch, name=names[branch.name], ends=(renamed(branch.ends[0]), renamed(branch.ends[1])))
        for branch in (search.branches[i] for i in ranked)
    ]
    junctions = [replace(j, on=names.get(j.on, j.on), to=names.get(j.to, j.to)) for j in _unique(search.junctions)]
    return Diagram(search.parameters, tuple(branches), tuple(junctions), search.missing, search.refused)


EXPECTED = ("PK", "BG", "BE", "FG", "FE", "HG", "HE", "GG", "GE", "TR", "PC")
"""Families that are looked for."""


def _unique(junctions: list[Junction]) -> list[Junction]:
    result: list[Junction] = []
    for junction in junctions:
        here = np.array(junction.unknowns)
        twin = any(j.to == junction.to and np.abs(np.array(j.unknowns) - here).max() < _SAME for j in result)
        if not twin:
            result.append(junction)
    return result


def _in_place(search: _Search, space: Subspace, unknowns: Vector) -> list[Crossing]:
    """Junctions along hopping in place that lead to a branch that moves, the lowest hop first."""
    steps = replace(search.config.steps, largest=0.03, most=400)
    highest = search.parameters.rest_length + search.config.highest_hop
    found: list[Crossing] = []
    walked = search.walk(space, unknowns, np.eye(COUNT)[Y], steps)
    for before, after in zip(walked.points, walked.points[1:], strict=False):
        if after.unknowns[Y] > highest:
            break
        for crossing in crossings(space, before, after, search.vector):
            direction = crossing.directions.get("even")
            if direction is not None and abs(direction[DX]) > _MOVES:
                found.append(replace(crossing, directions={"even": direction * np.sign(direction[DX])}))
    return found


def _moving_pronk(search: _Search) -> None:
    space = subspace("hind", "front")
    search.report("hopping in place", 0)
    lowest = 0.02 * search.parameters.rest_length
    for crossing in _in_place(search, space, pronk_in_place(search.parameters, lowest)):
        walked = search.walk(space, crossing.unknowns, crossing.directions["even"])
        if len(walked.points) < LEAST_ORBITS:
            search.refuse("PK", walked)
            continue
        names = search.add(space, walked.points, ("leaves PK in place", walked.end))
        search.junctions.append(Junction.at(crossing.unknowns, "PK in place", names[0], "none"))
        search.missing.pop("PK", None)
        return
    search.missing.setdefault("PK", "hopping in place has no junction to a moving gait")


def _moving_trot(search: _Search) -> None:
    space = subspace()
    search.report("hopping in place on two legs", search.orbits)
    lowest = 0.001 * search.parameters.rest_length
    swap = list(pair_swap("front"))
    for crossing in _in_place(search, space, trot_in_place(search.parameters, lowest)):
        walked = search.walk(space, crossing.unknowns, crossing.directions["even"])
        if len(walked.points) < LEAST_ORBITS or family_of(walked.points[0].unknowns) != "TR":
            search.refuse("TR", walked)
            continue
        first = len(search.branches)
        names = search.add(space, walked.points, ("leaves TR in place", walked.end))
        search.junctions.append(Junction.at(crossing.unknowns, "TR in place", names[0], "none"))
        # the plane of the model does not tell left from right: exchange the front legs, and a trot is a pace
        trot = search.branches[first]
        unknowns = trot.unknowns[:, swap]
        confirmed = np.array([disagreement(Orbit(u, search.parameters)) for u in unknowns])
        ends = ("leaves PC in place", trot.ends[1].replace("TR", "PC"))
        search.branches.append(Branch("PC", search.parameters, unknowns, trot.multipliers, confirmed, ends))
        search.spaces.append(space)
        search.junctions.append(Junction.at(crossing.unknowns[swap], "PC in place", "PC", "none"))
        search.missing.pop("TR", None)
        return
    search.missing.setdefault("TR", "hopping in place on two legs has no junction to a moving gait")
    search.missing["PC"] = "it is the trot with the front legs exchanged: " + search.missing["TR"]
    if "TR" in search.refused:
        search.refused["PC"] = search.refused["TR"][swap]


def _from_symmetric(parameters: SlipParameters, config: ExploreConfig, report: Report) -> Diagram:
    twin = replace(parameters, hind_distance=0.5, stiffness_ratio=1.0, resting_angle=0.0)
    symmetric = _Search(twin, config, report)
    _moving_pronk(symmetric)
    symmetric.run()
    if config.trot:
        _moving_trot(symmetric)
    search = _Search(parameters, config, report)
    search.missing["PK"] = "a torso that is not symmetric cannot pronk: see B, whose feet part only a little there"
    for branch, space in zip(symmetric.branches, symmetric.spaces, strict=True):
        for index in np.unique(np.linspace(0, len(branch) - 1, 5).astype(int))[1:-1]:
            report(f"{branch.name} of the symmetric torso", search.orbits)
            moved = _changed(space, branch.unknowns[index], twin, parameters, config.homotopy)
            if moved is None:
                continue
            along = branch.unknowns[min(index + 1, len(branch) - 1)] - branch.unknowns[index - 1]
            search.queue.append(_Start(space, moved, along))
        search.run()
    return _diagram(search)


def _changed(
    space: Subspace, unknowns: Vector, before: SlipParameters, after: SlipParameters, steps: int
) -> Vector | None:
    """An orbit of the same apex speed with other parameters, or None."""
    coordinates, normal = space.coordinates(unknowns), np.eye(COUNT)[DX] @ space.basis
    for share in np.linspace(0.0, 1.0, steps + 1)[1:]:
        vector = (1.0 - share) * before.vector() + share * after.vector()
        try:
            coordinates = correct(space, coordinates, normal, vector).coordinates
        except NoConvergence:
            return None
    return space.unknowns(coordinates)
