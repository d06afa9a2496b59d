from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slip.families.solve import solve_orbit
from slip.model.parameters import REFERENCE
from slip.model.unknowns import COUNT, EVENTS, STATES, UNKNOWN_NAMES, wrapped
from slip.orbits.orbit import Orbit, residual
from slip.orbits.symmetry import GROUP, OrbitElement, compare, image, orbit_symmetry, state_at
from slip.orbits.trajectory import sample
from symdyn.gait.symmetry import G_R, G_S, G_T, SpatioTemporal
from tests.slip.orbits.stored_orbits import FAMILIES, hop, orbit

NAMED = {g.name: g for g in GROUP}
every_family = pytest.mark.parametrize("family", FAMILIES)
forwards_in_time = st.sampled_from([g for g in GROUP if not g.reverses_time])


def by_name(values: np.ndarray) -> dict[str, float]:
    return dict(zip(UNKNOWN_NAMES, values, strict=True))


class TestGroup:
    def test_sixteen_different_elements(self):
        assert len({g.name for g in GROUP}) == len({g.matrix.tobytes() for g in GROUP}) == 16

    def test_products_are_those_of_the_matrices(self):
        for g, h in product(GROUP, repeat=2):
            assert g @ h in GROUP
            assert np.array_equal((g @ h).matrix, g.matrix @ h.matrix)

    def test_inverse(self):
        for g in GROUP:
            assert g @ g.inverse() == g.inverse() @ g == OrbitElement()

    def test_associative(self):
        for a, b, c in product(GROUP, repeat=3):
            assert (a @ b) @ c == a @ (b @ c)

    def test_relations(self):
        h, f, m, t = (NAMED[name] for name in "hfmt")
        assert m @ h == f @ m
        assert h @ f == f @ h
        assert all(t @ g == g @ t for g in GROUP)
        assert (h @ m) @ (h @ m) == h @ f  # of order four

    def test_those_of_the_body_permute_footfalls_as_symdyn_does(self):
        gait = orbit("GG").gait()
        for name, spatial in (("hf", G_S), ("m", G_T), ("hfm", G_R)):
            assert NAMED[name].spatial_name == spatial.name
            moved = Orbit(NAMED[name].on_unknowns(orbit("GG").unknowns), REFERENCE).gait()
            assert moved.distance(SpatioTemporal(spatial).on_gait(gait)) < 1e-9
        assert NAMED["h"].spatial_name is None


class TestActionWrittenOut:
    """On numbers that name their unknown, with nothing of slip.model.unknowns but the names."""

    values = np.arange(1.0, COUNT + 1.0)

    def test_hind(self):
        before, after = by_name(self.values), by_name(NAMED["h"].matrix @ self.values)
        for name, value in after.items():
            swapped = name.replace("LH", "?").replace("RH", "LH").replace("?", "RH")
            assert value == before[swapped]

    def test_mirror(self):
        before, after = by_name(self.values), by_name(NAMED["m"].matrix @ self.values)
        for name, value in after.items():
            swapped = name.replace("H", "?").replace("F", "H").replace("?", "F")
            flips = name in ("dx", "phi", "dphi") or "alpha" in name
            assert value == (-1.0 if flips else 1.0) * before[swapped]

    def test_time_reversal(self):
        before, after = by_name(self.values), by_name(NAMED["t"].matrix @ self.values)
        for name, value in after.items():
            event, _, leg = name.partition("_")
            if event in ("touchdown", "liftoff"):
                other = {"touchdown": "liftoff", "liftoff": "touchdown"}[event]
                assert value == before["period"] - before[f"{other}_{leg}"]
            else:
                assert value == (-1.0 if name.startswith("d") else 1.0) * before[name]


class TestOrbits:
    @every_family
    def test_orbits_they_are(self, family):
        assert orbit(family).residual_norm < 1e-10

    @every_family
    def test_spatial_elements_map_orbits_to_orbits(self, family):
        for g in GROUP:
            if not g.reverses_time:
                found = image(orbit(family), g)
                assert found.is_orbit
                assert found.residual < 1e-9

    @pytest.mark.parametrize("family", ("PK", "BG", "BE"))
    def test_time_reversal_holds(self, family):
        found = orbit_symmetry(orbit(family))
        assert found.reversible
        assert all(one.residual < 1e-9 for one in found.images)
        assert found.touchdown_jump < 1e-10
        # run backwards and seen in the mirror it is the same gait, in the same direction
        assert "mt" in found.group
        assert "t" in found.siblings  # that one runs the other way

    @pytest.mark.parametrize("family", ("FG", "FE", "HG", "HE", "GG", "GE"))
    def test_time_reversal_fails_where_a_touchdown_is_a_jump(self, family):
        found = orbit_symmetry(orbit(family))
        assert not found.reversible
        assert found.touchdown_jump > 1e-2
        for one in found.images:
            assert one.is_orbit != one.element.reverses_time
            if one.element.reverses_time:
                assert one.residual > 1e-3

    @pytest.mark.parametrize(
        ("family", "group"),
        [
            ("PK", {"e", "h", "f", "hf", "mt", "hmt", "fmt", "hfmt"}),
            ("BG", {"e", "h", "f", "hf", "mt", "hmt", "fmt", "hfmt"}),
            ("BE", {"e", "h", "f", "hf", "mt", "hmt", "fmt", "hfmt"}),
            ("FG", {"e", "h"}),
            ("FE", {"e", "h"}),
            ("HG", {"e", "f"}),
            ("HE", {"e", "f"}),
            ("GG", {"e"}),
            ("GE", {"e"}),
        ],
    )
    def test_symmetry_group(self, family, group):
        found = orbit_symmetry(orbit(family))
        assert set(found.group) == group
        closed = {(NAMED[a] @ NAMED[b]).name for a, b in product(group, repeat=2)}
        assert closed == group

    def test_a_hop_in_place_has_every_symmetry(self):
        assert set(orbit_symmetry(hop()).group) == set(NAMED)

    def test_footfall_class(self):
        assert orbit_symmetry(orbit("PK")).footfall_class.describe() == "K=K4 H=K4"
        assert orbit_symmetry(orbit("BG")).footfall_class.describe() == "K=<g_s> H=<g_s>"
        assert orbit_symmetry(orbit("GG")).footfall_class.describe() == "K=1 H=1"

    @every_family
    def test_image_of_an_image(self, family):
        start = orbit(family)
        for g in GROUP:
            there = Orbit(g.on_unknowns(start.unknowns), REFERENCE)
            back = g.inverse().on_unknowns(there.unknowns)
            assert np.abs(back - NAMED["e"].on_unknowns(start.unknowns)).max() < 1e-12

    @given(forwards_in_time, st.sampled_from(FAMILIES), st.floats(0.3, 0.7), st.floats(0.5, 2.0), st.floats(-0.2, 0.2))
    def test_in_any_model_the_residual_of_the_image_is_that_in_the_mirrored_model(self, g, family, lb, kr, resting):
        # strides that are no orbits will do: spatial elements map every stride to a stride
        parameters = replace(REFERENCE, hind_distance=lb, stiffness_ratio=kr, resting_angle=resting)
        unknowns = orbit(family).unknowns
        there = residual(g.on_unknowns(unknowns), g.on_parameters(parameters))
        here = residual(unknowns, parameters)
        assert np.allclose(np.sort(np.abs(there)), np.sort(np.abs(here)), atol=1e-8)

    def test_an_asymmetric_model_has_no_mirror(self):
        lopsided = replace(REFERENCE, hind_distance=0.45)
        found = {one.element.name: one for one in orbit_symmetry(Orbit(orbit("BG").unknowns, lopsided)).images}
        assert found["h"].keeps_model
        assert not found["m"].keeps_model

    def test_a_bound_of_an_asymmetric_model_is_not_reversible(self):
        lopsided = replace(REFERENCE, hind_distance=0.49)
        bound = solve_orbit(orbit("BG").unknowns, lopsided, pairs=("hind", "front"))
        found = orbit_symmetry(bound)
        assert set(found.group) == {"e", "h", "f", "hf"}
        assert not found.reversible
        assert found.touchdown_jump > 1e-3
        # of the mirrored model its mirror image is an orbit
        mirror = NAMED["m"]
        there = residual(mirror.on_unknowns(bound.unknowns), mirror.on_parameters(lopsided))
        assert np.abs(there).max() < 1e-9


class TestSameGait:
    @every_family
    @pytest.mark.parametrize("strides", (0.0, 0.2, 0.71))
    def test_from_another_moment_of_the_cycle_on(self, family, strides):
        start = orbit(family)
        later = start.unknowns.copy()
        later[STATES] = state_at(start, strides * start.period)
        later[EVENTS] -= strides * start.period
        shift, distance = compare(start, wrapped(later))
        assert shift == pytest.approx(strides, abs=1e-9)
        assert distance < 1e-9

    @every_family
    def test_state_at(self, family):
        start = orbit(family)
        path = sample(start, 31)
        for time, state in zip(path.time[1:-1], path.state[1:-1], strict=True):
            assert np.allclose(state_at(start, float(time)), state, atol=1e-9)
        assert np.allclose(state_at(start, 2.0 * start.period), start.unknowns[STATES], atol=1e-9)

    def test_the_other_lead_is_another_gait(self):
        found = orbit_symmetry(orbit("HG"))
        assert found.image("h").is_orbit
        assert not found.image("h").is_same
        assert found.image("h").distance > 0.1

    def test_a_neighbour_on_the_branch_is_another_gait(self):
        unknowns = orbit("BG").unknowns.copy()
        unknowns[0] += 1e-5
        assert compare(orbit("BG"), unknowns)[1] == pytest.approx(1e-5, rel=1e-3)
