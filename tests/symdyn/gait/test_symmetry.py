"""The group by its axioms, its action on the robot by Pinocchio, and the table of gaits as the literature has it."""

from __future__ import annotations

from itertools import product

import numpy as np
import pinocchio
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from symdyn.gait.library import LIBRARY, Gait, get
from symdyn.gait.symmetry import (
    G_R,
    G_S,
    G_T,
    K4,
    PAIRS,
    E,
    Spatial,
    SpatioTemporal,
    classify,
    common_shift,
    mirrored,
    pair_joint_signs,
    pairs_in_phase,
    phase_groups,
    time_reversed,
)
from symdyn.robot.descriptions import urdf_path
from symdyn.robot.legs import LEGS
from tests.robots import GO2

by_name = pytest.mark.parametrize("g", K4, ids=lambda g: g.name)
thetas = arrays(np.float64, 4, elements=st.floats(0.0, 1.0, exclude_max=True))
shifts = st.floats(0.0, 1.0, exclude_max=True)
elements = st.builds(SpatioTemporal, st.sampled_from(K4), shifts, st.booleans())


def same_on_circle(a: np.ndarray, b: np.ndarray, tolerance: float = 1e-12) -> bool:
    return bool(np.all(np.abs(np.exp(2j * np.pi * (np.asarray(a) - np.asarray(b))) - 1.0) < tolerance))


def same_element(a: SpatioTemporal, b: SpatioTemporal) -> bool:
    alike = (a.spatial, a.reverses_time) == (b.spatial, b.reverses_time)
    return alike and same_on_circle(np.array(a.shift), np.array(b.shift))


# K4


def test_k4_is_klein_s_group() -> None:
    table = {
        ("g_s", "g_t"): "g_r", ("g_t", "g_s"): "g_r", ("g_s", "g_r"): "g_t",
        ("g_r", "g_s"): "g_t", ("g_t", "g_r"): "g_s", ("g_r", "g_t"): "g_s",
    }  # fmt: skip
    for a, b in product(K4, K4):
        expected = "e" if a == b else b.name if a == E else a.name if b == E else table[a.name, b.name]
        assert (a @ b).name == expected
    for a, b, c in product(K4, K4, K4):
        assert (a @ b) @ c == a @ (b @ c)


def test_reflections_by_hand() -> None:
    assert G_S.reflection_b.tolist() == [1, -1, 1]  # left to right
    assert G_T.reflection_b.tolist() == [-1, 1, 1]  # front to hind
    assert G_R.reflection_b.tolist() == [-1, -1, 1]  # half a turn
    assert [G_S.leg_image(leg) for leg in LEGS] == ["RH", "RF", "LF", "LH"]
    assert [G_T.leg_image(leg) for leg in LEGS] == ["LF", "LH", "RH", "RF"]
    assert [G_R.leg_image(leg) for leg in LEGS] == ["RF", "RH", "LH", "LF"]


@by_name
def test_axial_vectors_turn_as_cross_products_do(g: Spatial) -> None:
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(2, 10, 3))
    np.testing.assert_allclose(
        g.axial_reflection_b * np.cross(a, b), np.cross(g.reflection_b * a, g.reflection_b * b), atol=1e-12
    )


@pytest.mark.parametrize(("a", "b"), list(product(K4, K4)), ids=lambda g: g.name)
def test_every_representation_of_k4_is_a_homomorphism(a: Spatial, b: Spatial) -> None:
    ab, q, legs = a @ b, np.random.default_rng(0).normal(size=12), np.arange(4.0)
    assert np.array_equal(ab.reflection_b, a.reflection_b * b.reflection_b)
    assert np.array_equal(ab.axial_reflection_b, a.axial_reflection_b * b.axial_reflection_b)
    assert np.array_equal(legs[list(ab.leg_index)], legs[list(b.leg_index)][list(a.leg_index)])

    def act(g: Spatial, x: np.ndarray) -> np.ndarray:
        return g.joint_signs * x[list(g.joint_index)]

    assert np.array_equal(act(ab, q), act(a, act(b, q)))
    assert np.array_equal(act(a, act(a, q)), q)


# the spatio-temporal group


@given(elements, elements, thetas)
def test_the_action_of_a_product_is_the_product_of_the_actions(
    a: SpatioTemporal, b: SpatioTemporal, theta: np.ndarray
) -> None:
    assert same_on_circle((a @ b).on_offsets(theta), a.on_offsets(b.on_offsets(theta)))


@given(elements, elements, elements)
def test_associative_and_closed(a: SpatioTemporal, b: SpatioTemporal, c: SpatioTemporal) -> None:
    assert same_element((a @ b) @ c, a @ (b @ c))
    assert isinstance(a @ b, SpatioTemporal)
    assert 0.0 <= (a @ b).shift < 1.0


@given(elements, thetas)
def test_identity_and_inverse(a: SpatioTemporal, theta: np.ndarray) -> None:
    one = SpatioTemporal(E)
    assert np.array_equal(one.on_offsets(theta), theta)
    assert same_element(one @ a, a)
    assert same_element(a @ one, a)
    assert same_element(a @ a.inverse(), one)
    assert same_element(a.inverse() @ a, one)
    assert same_on_circle(a.inverse().on_offsets(a.on_offsets(theta)), theta)


def test_shift_and_time_reversal_do_not_commute() -> None:
    # the group is a semidirect product: running backwards turns the sense of a shift
    shift, backwards = SpatioTemporal(E, 0.2), SpatioTemporal(E, reverses_time=True)
    assert (shift @ backwards).shift == pytest.approx(0.2)
    assert (backwards @ shift).shift == pytest.approx(0.8)


@given(elements)
def test_on_gait_is_on_offsets(a: SpatioTemporal) -> None:
    for gait in LIBRARY.values():
        assert same_on_circle(a.on_gait(gait).theta, a.on_offsets(gait.theta))


def test_offsets_and_shifts_stay_below_one() -> None:
    assert np.all(SpatioTemporal(E, reverses_time=True).on_offsets(np.array([1e-17, 0.0, 0.0, 0.0])) < 1.0)
    assert SpatioTemporal(E, 1e-17).inverse().shift < 1.0


# the action on the robot


@pytest.fixture(scope="module")
def go2() -> pinocchio.Model:
    """The URDF by Pinocchio, free in space."""
    return pinocchio.buildModelFromUrdf(str(urdf_path(GO2)), pinocchio.JointModelFreeFlyer())


def configuration(model: pinocchio.Model, joint_pos: np.ndarray) -> np.ndarray:
    q = pinocchio.neutral(model)
    for name, angle in zip(GO2.joint_names, joint_pos, strict=True):
        q[model.joints[model.getJointId(name)].idx_q] = angle
    return q


def feet(model: pinocchio.Model, joint_pos: np.ndarray) -> np.ndarray:
    """Positions of the feet in the trunk's frame, (4, 3)."""
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, configuration(model, joint_pos))
    return np.array([data.oMf[model.getFrameId(link)].translation for link in GO2.foot_links])


def random_poses(n: int) -> np.ndarray:
    return np.random.default_rng(1).uniform(-1.5, 1.5, (n, 12))


def test_the_trunks_origin_is_the_hips_centre(go2: pinocchio.Model) -> None:
    # g_t and g_r turn about the hips' centre; that they may be applied about the trunk's origin needs this
    hips = [go2.jointPlacements[go2.getJointId(name)].translation for name in GO2.joint_names[::3]]
    assert np.abs(np.mean(hips, axis=0)).max() < 1e-6


@by_name
def test_joint_signs_map_feet_by_r(go2: pinocchio.Model, g: Spatial) -> None:
    tolerance = 1e-3 if g.swaps_ends else 1e-4
    for q in random_poses(50):
        image = g.joint_signs * q[list(g.joint_index)]
        expected = g.reflection_b * feet(go2, q)[list(g.leg_index)]
        assert np.abs(feet(go2, image) - expected).max() < tolerance


@by_name
def test_mass_matrix_is_equivariant(go2: pinocchio.Model, g: Spatial) -> None:
    # slip.md: the Go2 is C2 as a body and K4 only as a mechanism. Its inertias tell g_s from the others
    tolerance = {"e": 1e-12, "g_s": 2e-5}.get(g.name, 3e-2)
    order = [*range(6), *(go2.joints[go2.getJointId(name)].idx_v for name in GO2.joint_names)]

    def mass_matrix(q: np.ndarray) -> np.ndarray:
        upper = np.triu(pinocchio.crba(go2, go2.createData(), configuration(go2, q)))
        return (upper + np.triu(upper, 1).T)[np.ix_(order, order)]

    rho = np.zeros((18, 18))
    rho[range(3), range(3)] = g.reflection_b
    rho[range(3, 6), range(3, 6)] = g.axial_reflection_b
    rho[range(6, 18), [6 + i for i in g.joint_index]] = g.joint_signs
    for q in random_poses(10):
        mapped = rho @ mass_matrix(q) @ rho.T
        error = np.linalg.norm(mass_matrix(rho[6:, 6:] @ q) - mapped) / np.linalg.norm(mapped)
        assert error < tolerance
    if g in (G_T, G_R):
        assert error > 1e-2


@pytest.mark.parametrize(("i", "j"), PAIRS)
def test_legs_that_move_alike_put_their_feet_alike_under_their_hips(go2: pinocchio.Model, i: int, j: int) -> None:
    # of one side: the same place seen from the hip; of opposite sides: the mirror image of it. Never turned fore-aft
    hip = np.array([go2.jointPlacements[go2.getJointId(name)].translation for name in GO2.joint_names[::3]])
    signs = pair_joint_signs()[PAIRS.index((i, j))]
    opposite = (LEGS[i][0] == "L") != (LEGS[j][0] == "L")
    for angles in random_poses(10)[:, :3]:
        q = np.zeros((4, 3))
        q[j], q[i] = angles, signs * angles
        position = feet(go2, q.ravel()) - hip
        assert position[i] == pytest.approx(position[j] * ([1, -1, 1] if opposite else [1, 1, 1]), abs=1e-6)


# gaits as subgroups: the table of slip.md

TABLE = {
    # K, H with its shifts, as worked out from the delays in slip.md
    "pronk": ({"e", "g_s", "g_t", "g_r"}, {"e": 0.0, "g_s": 0.0, "g_t": 0.0, "g_r": 0.0}),
    "trot": ({"e", "g_r"}, {"e": 0.0, "g_s": 0.5, "g_t": 0.5, "g_r": 0.0}),
    "pace": ({"e", "g_t"}, {"e": 0.0, "g_s": 0.5, "g_t": 0.0, "g_r": 0.5}),
    "bound": ({"e", "g_s"}, {"e": 0.0, "g_s": 0.0, "g_t": 0.5, "g_r": 0.5}),
    "half_bound_left": ({"e"}, {"e": 0.0}),
    "half_bound_right": ({"e"}, {"e": 0.0}),
    "walk": ({"e"}, {"e": 0.0, "g_s": 0.5}),
    "rotary_gallop": ({"e"}, {"e": 0.0, "g_r": 0.5}),
    "transverse_gallop": ({"e"}, {"e": 0.0, "g_t": 0.5}),
}

DESCRIPTIONS = {
    "pronk": "K=K4 H=K4", "trot": "K=<g_r> H=K4", "pace": "K=<g_t> H=K4", "bound": "K=<g_s> H=K4",
    "half_bound_left": "K=1 H=1", "half_bound_right": "K=1 H=1", "walk": "K=1 H=<g_s>",
    "rotary_gallop": "K=1 H=<g_r>", "transverse_gallop": "K=1 H=<g_t>",
}  # fmt: skip

PARTNERS = {
    "pronk": "pronk", "trot": "trot", "pace": "pace", "bound": "bound",
    "half_bound_left": "half_bound_right", "half_bound_right": "half_bound_left",
    "rotary_gallop": "rotary_gallop_mirrored", "transverse_gallop": "transverse_gallop_mirrored",
    # backwards a lateral sequence is a diagonal one, which neither lead of the library's walk is
    "walk": None,
}  # fmt: skip

SYMMETRIC_PAIRS = {
    "pronk": 6, "trot": 2, "pace": 2, "bound": 2, "half_bound_left": 1, "half_bound_right": 1,
    "walk": 0, "rotary_gallop": 0, "transverse_gallop": 0,
}  # fmt: skip


def test_the_table_covers_the_library() -> None:
    assert set(TABLE) == set(LIBRARY) == set(DESCRIPTIONS) == set(PARTNERS) == set(SYMMETRIC_PAIRS)


@pytest.mark.parametrize("name", TABLE)
@pytest.mark.parametrize("start", [0.0, 0.31])
def test_classify_prints_the_table(name: str, start: float) -> None:
    # wherever the stride is said to begin
    found = classify(Gait.wrapped(name, get(name).theta + start))
    K, H = TABLE[name]
    assert set(found.K) == K
    assert dict(found.H) == H
    assert found.describe() == DESCRIPTIONS[name]
    assert len(found.symmetric_pairs) == SYMMETRIC_PAIRS[name]


@pytest.mark.parametrize("name", PARTNERS)
def test_time_reversal_partner(name: str) -> None:
    assert classify(get(name)).time_reversal_partner == PARTNERS[name]
    # the galloping gaits' partners are their other leads: the mirror image, at another start of the stride
    if name.endswith("gallop"):
        assert common_shift(time_reversed(get(name)).theta, mirrored(get(name)).theta) is not None
        assert common_shift(time_reversed(get(name)).theta, get(name).theta) is None


@pytest.mark.parametrize("d", [0.2, 0.4, 0.45])
def test_a_bound_of_uneven_beat_has_only_g_s(d: float) -> None:
    found = classify(Gait.wrapped("bound", -np.array([0.0, d, d, 0.0])))
    assert (set(found.K), dict(found.H)) == ({"e", "g_s"}, {"e": 0.0, "g_s": 0.0})


def test_pairs_by_name() -> None:
    assert set(classify(get("trot")).symmetric_pairs) == {("LH", "RF"), ("LF", "RH")}
    assert set(classify(get("bound")).symmetric_pairs) == {("LH", "RH"), ("LF", "RF")}
    assert set(classify(get("half_bound_left")).symmetric_pairs) == {("LH", "RH")}


@given(st.sampled_from(sorted(LIBRARY)), elements)
def test_k_and_h_are_subgroups_and_elements_of_h_leave_the_gait_alone(name: str, a: SpatioTemporal) -> None:
    gait = a.on_gait(get(name))
    found, by = classify(gait), {g.name: g for g in K4}
    for names in (set(found.K), {name for name, _ in found.H}):
        assert {(by[x] @ by[y]).name for x in names for y in names} == names
    for element, shift in found.H:
        assert same_on_circle(SpatioTemporal(by[element], -shift).on_offsets(gait.theta), gait.theta, 1e-5)
    # K4 is abelian, so that the class of an image under it is the class of the gait; time reversal turns shifts round
    assert set(found.K) == TABLE[name][0]
    assert {element for element, _ in found.H} == set(TABLE[name][1])


@given(thetas)
def test_common_shift_finds_the_shift(theta: np.ndarray) -> None:
    for shift in (0.0, 0.25, 0.5, 0.993):
        found = common_shift(np.mod(theta + shift, 1.0), theta)
        assert found is not None
        assert 0.0 <= found < 1.0
        assert same_on_circle(np.array(found), np.array(shift), 1e-9) or (shift == 0.0 and found == 0.0)
    assert common_shift(theta + np.array([0.0, 0.0, 0.0, 0.02]), theta) is None
    assert common_shift(theta + np.array([0.0, 0.0, 0.0, 0.005]), theta) is not None


@given(thetas, st.floats(0.001, 0.2))
def test_pairs_in_phase_is_the_papers_f_on_the_circle(theta: np.ndarray, tolerance: float) -> None:
    found = pairs_in_phase(theta[None], tolerance)[0]
    theirs = pairs_in_phase(torch.from_numpy(theta)[None], tolerance)[0]
    assert found.tolist() == theirs.tolist()
    for (i, j), together in zip(PAIRS, found, strict=True):
        distance = abs(np.angle(np.exp(2j * np.pi * (theta[i] - theta[j])))) / (2 * np.pi)
        if abs(distance - tolerance) > 1e-9:
            assert together == (distance < tolerance)


def test_pairs_in_phase_by_hand() -> None:
    assert PAIRS == ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))
    # LH and RH are 0.006 apart across the start of the stride; LF and RF 0.02 apart
    found = pairs_in_phase(np.array([[0.998, 0.5, 0.52, 0.004]]))[0]
    assert found.tolist() == [False, False, True, False, False, False]


@pytest.mark.parametrize(
    ("name", "groups"),
    [
        ("trot", (0, 1, 0, 1)),
        ("bound", (0, 1, 1, 0)),
        ("half_bound_left", (0, 1, 2, 0)),
        ("rotary_gallop", (0, 1, 2, 3)),
        ("pronk", (0, 0, 0, 0)),
    ],
)
def test_phase_groups(name: str, groups: tuple[int, ...]) -> None:
    assert phase_groups(get(name)) == groups
