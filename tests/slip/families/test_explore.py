"""The tracer: it finds the nine families and their junctions by itself, and every orbit of theirs is one."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from slip.families.branch import Branch
from slip.families.continuation import StepConfig
from slip.families.explore import explore
from slip.families.rest import fall_and_stance
from slip.families.search import ExploreConfig
from slip.families.seeds import seeds
from slip.families.solve import Held, NoOrbit, orbits_at, solve_orbit
from slip.families.store import SUMMARY, load, save
from slip.model.naming import family_of
from slip.model.parameters import REFERENCE, SlipParameters
from slip.model.unknowns import DX, DY, STATES
from slip.orbits.floquet import multipliers, return_map
from slip.orbits.independent_simulation import disagreement, simulate
from slip.orbits.orbit import Orbit
from slip.orbits.subspace import subspace
from symdyn.errors import FileProblem, InvalidValue, UnknownName
from symdyn.gait.symmetry import classify
from tests.slip.families.reference import diagram

NINE = ("PK", "BG", "BE", "FG", "FE", "HG", "HE", "GG", "GE")


def orbits_of_all_families() -> list[tuple[str, int]]:
    return [(name, share) for name in NINE for share in (0, 1, 2, 3, 4)]


def branch(name: str) -> Branch:
    return diagram().family(name)[0]


def test_all_nine_families_are_found() -> None:
    assert set(NINE) <= set(diagram().names)


@pytest.mark.parametrize(
    ("on", "to", "pair", "dx", "period", "dphi"),
    # measured by an independent prototype
    [("PK", "BG", "both", 4.434062, 1.364598, 0.0), ("BG", "HG", "hind", 4.506161, 1.352251, 0.028591)],
)
def test_known_junctions(on: str, to: str, pair: str, dx: float, period: float, dphi: float) -> None:
    (junction,) = (j for j in diagram().junctions if (j.on, j.to, j.pair) == (on, to, pair))
    assert junction.dx == pytest.approx(dx, abs=1e-5)
    assert pytest.approx(period, abs=1e-5) == junction.T
    assert junction.dphi == pytest.approx(dphi, abs=1e-5)


def test_half_bounds_and_gallops_leave_where_a_pair_parts() -> None:
    found = {(j.on, j.to, j.pair) for j in diagram().junctions}
    assert {("BG", "FG", "front"), ("BE", "FE", "front"), ("BE", "HE", "hind"), ("FG", "GG", "hind")} <= found
    assert ("HE", "GE", "front") in found


def test_at_a_junction_the_block_of_its_pair_is_singular() -> None:
    for junction in diagram().junctions:
        if junction.pair not in ("hind", "front"):
            continue
        unknowns = np.array(junction.unknowns)
        pairs = {"B": ("hind", "front"), "F": ("hind",), "H": ("front",)}[junction.on[0]]
        orbit = solve_orbit(unknowns, REFERENCE, pairs=pairs)
        block = subspace(*pairs).odd_block(orbit.stride.jacobian, junction.pair)
        singular = np.linalg.svd(block)[1]
        assert singular[-1] < 1e-6 * singular[0]


@pytest.mark.parametrize(("name", "share"), orbits_of_all_families())
def test_orbits_are_orbits(name: str, share: int) -> None:
    along = branch(name)
    orbit = along.orbit(share * (len(along) - 1) // 4)
    assert orbit.residual_norm < 1e-10
    assert orbit.energy_drift < 1e-11
    assert orbit.least_force > -1e-9
    assert disagreement(orbit) < 1e-8
    assert family_of(orbit.unknowns, along.pairs) == name


def test_every_orbit_was_confirmed_by_event_detection() -> None:
    for along in diagram().branches:
        assert along.confirmed.max() < 1e-8


def test_neighbours_on_a_branch_are_near() -> None:
    for along in diagram().branches:
        assert np.linalg.norm(np.diff(along.unknowns, axis=0), axis=1).max() < 0.6


def test_the_moving_pronk_begins_where_the_legs_swing_in_time_with_the_hop() -> None:
    """The limit of no speed is linear: over the known hop y(t), the hip at a distance xi ahead of the foot obeys
    xi'' = (y'' + 1) xi / y, odd about mid-stance; then the leg swings freely and must hang straight down at the apex.
    """
    stiffness, swing = 4.0 * REFERENCE.stiffness, np.sqrt(REFERENCE.swing_stiffness)
    frequency = np.sqrt(stiffness)

    def angle_at_apex(height: float) -> float:
        fall, stance = fall_and_stance(stiffness, height)
        climb = np.sqrt(2.0 * height)
        depth = np.hypot(1.0 / stiffness, climb / frequency)

        def rate(t: float, s: np.ndarray) -> list[float]:
            dip = -depth * np.cos(frequency * t)  # above the static compression 1 / K
            return [s[1], (1.0 - stiffness * dip) * s[0] / (1.0 - 1.0 / stiffness + dip)]

        xi, speed = solve_ivp(rate, (0.0, 0.5 * stance), [0.0, 1.0], rtol=1e-12, atol=1e-14).y[:, -1]
        alpha, dalpha = -xi, -speed + climb * xi
        return alpha * np.cos(swing * fall) + dalpha / swing * np.sin(swing * fall)

    fall, stance = fall_and_stance(4.0 * REFERENCE.stiffness, brentq(angle_at_apex, 0.08, 0.2, xtol=1e-14))
    (junction,) = (j for j in diagram().junctions if j.on == "PK in place")
    assert junction.dx == pytest.approx(0.0, abs=1e-9)
    assert pytest.approx(2.0 * fall + stance, abs=1e-7) == junction.T


def test_symmetry_classes_of_the_footfalls() -> None:
    assert classify(branch("PK").orbit(5).gait()).group == classify(branch("PK").orbit(50).gait()).group
    # a pronk keeps all of K4, a bound left and right, half-bounds and gallops nothing
    assert len(classify(branch("PK").orbit(5).gait()).group[0]) == 4
    assert len(classify(branch("BE").orbit(20).gait()).group[0]) == 2
    for name in ("FG", "FE", "HG", "HE", "GG", "GE"):
        assert len(classify(branch(name).orbit(10).gait()).group[0]) == 1


@pytest.mark.parametrize("name", ["PK", "BE", "HG"])
def test_return_map_against_simulated_strides(name: str) -> None:
    """The derivative of the apex return map, by perturbing the state and letting events happen."""
    orbit = branch(name).orbit(8)
    derivative = return_map(orbit.stride.jacobian)
    h, state = 1e-6, orbit.unknowns[STATES]
    for i in range(STATES.stop):
        if i == DY:
            continue
        ends = []
        for sign in (1.0, -1.0):
            moved = state.copy()
            moved[i] += sign * h
            ends.append(simulate(moved, orbit.standing, REFERENCE, 3.0 * orbit.period).state)
        slope = (ends[0] - ends[1]) / (2.0 * h)
        np.testing.assert_allclose(derivative[:, i], slope, atol=2e-4 * (1.0 + np.abs(slope).max()))


def test_energy_holds_one_multiplier_at_one() -> None:
    orbit = branch("BG").orbit(12)
    gradient = orbit.energy_gradient
    np.testing.assert_allclose(gradient @ return_map(orbit.stride.jacobian), gradient, atol=1e-7)
    assert len(multipliers(orbit)) == 11


def test_orbits_at_a_speed() -> None:
    orbits = orbits_at(diagram(), 4.2, "HG")
    assert len(orbits) >= 2  # the branch has turning points
    for orbit in orbits:
        assert orbit.apex_speed == pytest.approx(4.2, abs=1e-12)
        assert orbit.residual_norm < 1e-10
    with pytest.raises(NoOrbit, match=r"Speeds of this family: HG 3\.09"):
        orbits_at(diagram(), 14.0, "HG")
    with pytest.raises(UnknownName, match="Known: B"):
        orbits_at(diagram(), 2.0, "walk")


def test_solving_from_a_bad_guess_says_why() -> None:
    good = branch("PK").unknowns[40]
    near = good + 1e-2 * np.random.default_rng(0).normal(size=good.shape)
    solved = solve_orbit(near, REFERENCE, Held("dx", good[DX]), ("hind", "front"))
    np.testing.assert_allclose(solved.unknowns, good, atol=1e-8)
    far = good + np.random.default_rng(0).normal(size=good.shape) * 0.5
    with pytest.raises(NoOrbit) as caught:
        solve_orbit(far, REFERENCE)
    assert caught.value.reason in ("no convergence", "no gait")
    assert "Try" in str(caught.value)
    with pytest.raises(InvalidValue, match="not finite in dx"):
        solve_orbit(np.where(np.arange(len(good)) == DX, np.nan, good), REFERENCE)
    with pytest.raises(UnknownName, match="hind"):
        solve_orbit(good, REFERENCE, pairs=("left",))
    with pytest.raises(UnknownName, match="period"):
        Held("T")


def test_a_trot_exists_where_legs_swing_slowly_and_springs_are_stiff() -> None:
    steps = StepConfig(most=12)
    slow = diagram(
        SlipParameters(stiffness=20.0, swing_stiffness=5.0), ExploreConfig(steps=steps, highest_hop=0.3, seeds=0)
    )
    assert {"TR", "PC"} <= set(slow.names)
    trot, pace = slow.family("TR")[0], slow.family("PC")[0]
    assert len(classify(trot.orbit(5).gait()).group[0]) == 2
    assert classify(trot.orbit(5).gait()).group != classify(pace.orbit(5).gait()).group
    assert trot.confirmed.max() < 1e-8
    assert pace.confirmed.max() < 1e-8


def test_a_family_that_does_not_exist_is_named_with_the_reason() -> None:
    steps = StepConfig(most=6)
    fast = explore(REFERENCE, ExploreConfig(steps=steps, highest_hop=0.2))
    assert "TR" not in fast.names
    assert "swings" in fast.missing["TR"]
    assert fast.refused["TR"].shape == (22,)


def test_a_torso_that_is_not_symmetric() -> None:
    p = dataclasses.replace(REFERENCE, hind_distance=0.49)
    found = diagram(p, ExploreConfig(steps=StepConfig(most=40, max_speed=4.0), trot=False, seeds=0))
    assert "PK" in found.missing
    assert {b.family for b in found.branches} & {"BG", "BE"}
    for along in found.branches:
        assert along.confirmed.max() < 1e-8
        assert along.orbit(0).residual_norm < 1e-10


@pytest.mark.parametrize("family", sorted(seeds()))
def test_seeds_are_orbits_of_the_reference_parameters(family: str) -> None:
    for unknowns in seeds()[family]:
        orbit = Orbit(unknowns, REFERENCE)
        assert orbit.residual_norm < 1e-10
        assert family_of(unknowns) == family
        assert disagreement(orbit) < 1e-8


def test_families_that_no_junction_leads_to_are_carried_over(monkeypatch: pytest.MonkeyPatch) -> None:
    """A light torso bounds, though its pronk has no junction with a bound."""
    carried = {"BE": 2, "FG": 1}  # of each so many orbits: all of them, of all families, take a minute and a half
    monkeypatch.setattr(
        "slip.families.explore.seeds", lambda: {family: seeds()[family][:count] for family, count in carried.items()}
    )
    light = SlipParameters(stiffness=5.084, swing_stiffness=43.44, pitch_inertia=0.2179, rest_length=1.0341)
    found = explore(light, ExploreConfig(steps=StepConfig(most=8), trot=False, highest_hop=0.2))
    assert "PK" in found.names
    assert {b.family for b in found.branches} & {"BG", "BE"}
    assert not set(found.names) & set(found.missing)
    for along in found.branches:
        assert along.orbit(0).residual_norm < 1e-10
        assert along.confirmed.max() < 1e-8
    assert "FG" in found.missing
    for family, why in found.missing.items():
        assert ("lost" if family in carried else "no junction on the branches that were traced") in why


def test_stored_and_loaded(tmp_path: Path) -> None:
    save(diagram(), tmp_path)
    again = load(tmp_path)
    assert again.parameters == diagram().parameters
    assert again.junctions == diagram().junctions
    assert again.missing == diagram().missing
    for before, after in zip(diagram().branches, again.branches, strict=True):
        assert (before.name, before.ends) == (after.name, after.ends)
        np.testing.assert_array_equal(before.unknowns, after.unknowns)
        np.testing.assert_array_equal(before.multipliers, after.multipliers)


def test_bad_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(FileProblem):
        load(tmp_path)
    save(diagram(), tmp_path)
    (tmp_path / SUMMARY).write_text('{"format_version": 1}')
    with pytest.raises(FileProblem, match="does not hold gait families"):
        load(tmp_path)


@pytest.mark.parametrize(
    ("settings", "name"),
    [
        ({"first": 0.0}, "step lengths"),
        ({"most": 1}, "most"),
        ({"max_speed": -1.0}, "max_speed"),
    ],
)
def test_bad_step_settings_are_refused(settings: dict[str, float], name: str) -> None:
    with pytest.raises(InvalidValue, match=name):
        StepConfig(**settings)  # type: ignore[arg-type]
