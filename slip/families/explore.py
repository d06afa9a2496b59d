"""All families of passive gaits, found from hopping in place alone.

The pronk in place is known in closed form. Walking along it in height, the tracer meets the junction where the moving
pronk begins; along the pronk, the one where bounds begin; along bounds, half-bounds; along half-bounds, gallops. Trot
and pace begin at hopping on two legs. A torso that is not symmetric has no pronk: its families are reached by changing
the parameters of a symmetric one step by step. So are families that no junction leads to, from the reference set.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from slip.families.branch import Branch, Diagram, Junction, pairs_of
from slip.families.continuation import MERGES, point
from slip.families.junction import Crossing, crossings
from slip.families.rest import pronk_in_place, trot_in_place
from slip.families.search import LEAST_ORBITS, SAME, ExploreConfig, Report, Search, Start
from slip.families.seeds import seeds
from slip.model.naming import FAMILIES, family_of
from slip.model.parameters import REFERENCE, SlipParameters
from slip.model.unknowns import COUNT, DX, Y, pair_swap
from slip.orbits.independent_simulation import disagreement
from slip.orbits.newton import NoConvergence, correct
from slip.orbits.orbit import Orbit
from slip.orbits.stride import integrate_stride
from slip.orbits.subspace import Subspace, subspace

Vector = NDArray[np.float64]

EXPECTED = ("PK", "BG", "BE", "FG", "FE", "HG", "HE", "GG", "GE", "TR", "PC")
"""Families that are looked for."""

_HOPS = 200
"""Heights at which hopping in place is looked at."""
_LARGEST_CHANGE = 0.3
_SMALLEST_SHARE = 1e-3
_MOVES = 0.02
"""Share of dx in the direction of a junction from which on the new branch counts as moving."""


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
    return _diagram(_search_symmetric(parameters, config, report))


def _search_symmetric(parameters: SlipParameters, config: ExploreConfig, report: Report) -> Search:
    search = Search(parameters, config, report)
    _moving_pronk(search)
    search.run()
    _carried_over(search)
    if config.trot:
        _moving_trot(search)
    return search


def _diagram(search: Search) -> Diagram:
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
    missing = {family: why for family, why in search.missing.items() if family not in found}
    return Diagram(search.parameters, tuple(branches), tuple(junctions), missing, search.refused)


def _unique(junctions: list[Junction]) -> list[Junction]:
    result: list[Junction] = []
    for junction in junctions:
        here = np.array(junction.unknowns)
        twin = any(j.to == junction.to and np.abs(np.array(j.unknowns) - here).max() < SAME for j in result)
        if not twin:
            result.append(junction)
    return result


def _in_place(
    search: Search, space: Subspace, hop: Callable[[SlipParameters, float], Vector], lowest: float
) -> list[Crossing]:
    """Junctions along hopping in place, which is known in closed form, with a branch that moves; the lowest first."""
    upwards = space.coordinates(np.eye(COUNT)[Y])
    points = []
    for height in np.geomspace(lowest, search.config.highest_hop, _HOPS) * search.parameters.rest_length:
        unknowns = hop(search.parameters, height)
        points.append(point(space, integrate_stride(unknowns, search.vector), unknowns, upwards))
    found: list[Crossing] = []
    for before, after in pairwise(points):
        for crossing in crossings(space, before, after, search.vector):
            direction = crossing.directions.get("even")
            if direction is not None and abs(direction[DX]) > _MOVES:
                found.append(replace(crossing, directions={"even": direction * np.sign(direction[DX])}))
    return found


def _moving_pronk(search: Search) -> None:
    space = subspace("hind", "front")
    search.report("hopping in place", 0)
    for crossing in _in_place(search, space, pronk_in_place, 0.02):
        walked = search.walk(space, crossing.unknowns, crossing.directions["even"])
        if len(walked.points) < LEAST_ORBITS:
            search.refuse("PK", walked)
            continue
        names = search.add(space, walked.points, ("leaves PK in place", walked.end))
        search.junctions.append(Junction.at(crossing.unknowns, "PK in place", names[0], "none"))
        search.missing.pop("PK", None)
        return
    search.missing.setdefault("PK", "hopping in place has no junction to a moving gait")


def _moving_trot(search: Search) -> None:
    space = subspace()
    search.report("hopping in place on two legs", search.orbits)
    swap = list(pair_swap("front"))
    for crossing in _in_place(search, space, trot_in_place, 0.001):
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
    symmetric = _search_symmetric(twin, config, report)
    search = Search(parameters, config, report)
    for family, why in symmetric.missing.items():
        search.missing[family] = f"with a symmetric torso, {why}"
    search.missing["PK"] = "a torso that is not symmetric cannot pronk: see B, whose feet part only a little there"
    for branch, space in zip(symmetric.branches, symmetric.spaces, strict=True):
        for index in np.unique(np.linspace(0, len(branch) - 1, 5).astype(int))[1:-1]:
            report(f"{branch.name} of the symmetric torso", search.orbits)
            try:
                moved = _changed(space, branch.unknowns[index], twin, parameters, config.homotopy)
            except NoConvergence:
                continue
            along = branch.unknowns[min(index + 1, len(branch) - 1)] - branch.unknowns[index - 1]
            search.queue.append(Start(space, moved, along))
        search.run()
    return _diagram(search)


def _carried_over(search: Search) -> None:
    """Look for families that no junction led to, by changing the reference parameters step by step into these."""
    if search.parameters == REFERENCE:
        return
    for family, orbits in seeds().items():
        reasons: list[str] = []
        for orbit in orbits[: search.config.seeds]:
            if any(branch.family == family for branch in search.branches):
                break
            search.report(f"{family} of the reference parameters", search.orbits)
            space = subspace(*pairs_of(family))
            try:
                moved = _changed(space, orbit, REFERENCE, search.parameters, search.config.homotopy)
            except NoConvergence as failure:
                reasons.append(str(failure))
                continue
            became = family_of(moved)
            if not became.startswith(family[0]):
                reasons.append(f"became {became}")
                continue
            search.queue.append(Start(space, moved, np.eye(COUNT)[DX]))
            search.run()
        if reasons and not any(branch.family == family for branch in search.branches):
            search.missing[family] = (
                f"no junction leads to it, and {len(reasons)} orbits of the reference parameters, changed step by step "
                f"into these at constant speed, were lost ({'; '.join(dict.fromkeys(reasons))})"
            )


def _changed(space: Subspace, unknowns: Vector, before: SlipParameters, after: SlipParameters, steps: int) -> Vector:
    """An orbit of the same apex speed with other parameters.

    Raises:
        NoConvergence: if it is lost on the way.
    """
    coordinates, normal = space.coordinates(unknowns), np.eye(COUNT)[DX] @ space.basis
    change, share, step = np.zeros_like(coordinates), 0.0, 1.0 / steps
    while share < 1.0:
        new = min(1.0, share + step)
        vector = (1.0 - new) * before.vector() + new * after.vector()
        try:
            moved = correct(space, coordinates + change * (new - share), normal, vector).coordinates
            if np.abs(moved - coordinates).max() > _LARGEST_CHANGE:
                raise NoConvergence("it jumped to another branch")
        except NoConvergence as failure:
            step *= 0.5
            if step < _SMALLEST_SHARE:
                raise NoConvergence(f"after {share:.0%} of the way") from failure
            continue
        change = (moved - coordinates) / (new - share)
        coordinates, share, step = moved, new, min(1.0 / steps, 1.5 * step)
    return space.unknowns(coordinates)
