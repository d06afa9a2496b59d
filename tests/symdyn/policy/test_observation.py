"""The observations: their order as the paper and the issue give it, and their mirror image against a real robot's."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from symdyn.errors import PolicyMismatch, SymdynError, UnknownName
from symdyn.gait.phase import leg_phase
from symdyn.gait.symmetry import G_R, G_S, G_T, K4, Spatial
from symdyn.policy.layout import Layout
from symdyn.policy.observation import (
    LAYOUTS,
    NEEDS,
    SENSORS,
    TERMS,
    VALUES,
    Sensed,
    Situation,
    check_supplied,
    get_layout,
    observe,
    read_layout,
)
from symdyn.robot.frames import projected_gravity
from symdyn.robot.legs import JOINTS
from tests.robots import GO2

if TYPE_CHECKING:
    from rl.physics.protocol import RobotState
    from tests.rl.physics.real_states import RealStates
    from tests.symdyn.robot.mirrored_by_hand import MirroredByHand

PAPER = [
    ("projected_gravity_b", 3),
    ("joint_pos_rel", 12),
    ("joint_vel", 12),
    ("last_action", 12),
    ("velocity_command", 3),
    ("clock_sin", 4),
    ("phase_offset", 4),
    ("duty_ratio", 2),
]
ORDERS = {"paper": PAPER, "extended": [*PAPER, ("clock_cos", 4), ("base_ang_vel_b", 3)]}

every_layout = pytest.mark.parametrize("name", ORDERS)


@every_layout
def test_order_and_sizes(name: str) -> None:
    layout, order = get_layout(name), ORDERS[name]
    assert [(term.name, term.size) for term in layout.terms] == order
    assert layout.size == {"paper": 52, "extended": 59}[name]
    assert [(entry["name"], entry["size"]) for entry in layout.as_list()] == order
    start = 0
    for term, size in order:
        assert layout.slices[term] == slice(start, start + size)
        start += size


def test_the_layouts_are_these() -> None:
    assert set(LAYOUTS) == set(ORDERS)
    with pytest.raises(UnknownName, match=r"Unknown observation 'papers'.*Known: extended, paper"):
        get_layout("papers")


def test_order_of_the_legs_within_the_terms() -> None:
    labels = {name: term.labels for name, term in TERMS.items()}
    assert labels["clock_sin"] == labels["clock_cos"] == ("LH", "LF", "RF", "RH")
    assert labels["phase_offset"] == ("LF", "RF", "LH", "RH")
    for name in ("joint_pos_rel", "joint_vel", "last_action"):
        assert labels[name] == JOINTS


def test_noise_is_the_papers_table_3_and_legged_gyms_for_the_gyroscope() -> None:
    noise = {name: term.noise for name, term in TERMS.items()}
    assert noise.pop("projected_gravity_b") == 0.05
    assert noise.pop("joint_pos_rel") == 0.01
    assert noise.pop("joint_vel") == 1.5
    assert noise.pop("base_ang_vel_b") == 0.2
    assert set(noise.values()) == {0.0}
    # of the vector: scaled as the numbers are
    layout = LAYOUTS["extended"]
    amplitude = layout.noise_amplitude()
    assert amplitude.shape == (59,)
    assert amplitude[:3].tolist() == [0.05] * 3
    assert amplitude[layout.slices["joint_vel"]] == pytest.approx([1.5 * 0.05] * 12)
    assert amplitude[layout.slices["base_ang_vel_b"]] == pytest.approx([0.2 * 0.25] * 3)


def test_every_term_has_a_value_and_every_need_is_a_sensor() -> None:
    assert set(TERMS) == set(VALUES)
    assert set(NEEDS) <= set(TERMS)
    assert set(NEEDS.values()) == set(SENSORS) - {"heading"}  # heading hold needs it, no observation does


def values(name: str, n: int, seed: int = 0) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    return {term: rng.normal(size=(n, size)) for term, size in ORDERS[name]}


def test_assembled_by_hand() -> None:
    given_values = {name: np.full((1, size), k + 1.0) for k, (name, size) in enumerate(ORDERS["extended"])}
    paper = [1.0] * 3 + [2.0] * 12 + [3.0 * 0.05] * 12 + [4.0] * 12 + [5.0] * 3 + [6.0] * 4 + [7.0] * 4 + [8.0] * 2
    vector = LAYOUTS["extended"].assemble(given_values)[0]
    assert vector == pytest.approx([*paper, *[9.0] * 4, *[10.0 * 0.25] * 3])
    vector = LAYOUTS["paper"].assemble({name: given_values[name] for name, _ in PAPER})[0]
    assert vector == pytest.approx(paper)


@every_layout
def test_assembled_vector_is_fresh_and_the_same_in_torch(name: str) -> None:
    ours, layout = values(name, 3), get_layout(name)
    theirs = {term: torch.from_numpy(value.copy()) for term, value in ours.items()}
    vector, tensor = layout.assemble(ours), layout.assemble(theirs)
    assert np.array_equal(vector, tensor.numpy())
    before = tensor.clone()
    for value in theirs.values():
        value += 1.0
    assert torch.equal(tensor, before)


@pytest.mark.parametrize("change", ["missing", "unknown", "wrong size"])
def test_wrong_terms_are_refused_by_name(change: str) -> None:
    wrong = values("paper", 2)
    if change == "missing":
        del wrong["clock_sin"]
    elif change == "unknown":
        wrong["clock_cos"] = wrong["clock_sin"]
    else:
        wrong["clock_sin"] = wrong["clock_sin"][:, :3]
    with pytest.raises(SymdynError, match="clock_cos" if change == "unknown" else "clock_sin"):
        LAYOUTS["paper"].assemble(wrong)


def test_observed_by_hand() -> None:
    joints = np.arange(12.0)[None]
    situation = Situation(
        sensed=Sensed(np.array([[0.1, 0.2, -0.9]]), joints, 2.0 * joints, np.array([[0.4, 0.8, 1.2]])),
        default_joint_pos=np.full(12, 0.5),
        last_action=-joints,
        offsets=np.array([[0.1, 0.2, 0.3, 0.4]]),  # LH, LF, RF, RH
        velocity=np.array([[1.0, 2.0, 3.0]]),
        leg_phases=np.array([[0.0, 0.25, 0.5, 0.75]]),
        duty=np.array([0.6]),
    )
    layout = LAYOUTS["extended"]
    (vector,) = observe(layout, situation)
    part = {name: vector[where] for name, where in layout.slices.items()}
    assert part["projected_gravity_b"] == pytest.approx([0.1, 0.2, -0.9])
    assert part["joint_pos_rel"] == pytest.approx(np.arange(12.0) - 0.5)
    assert part["joint_vel"] == pytest.approx(0.1 * np.arange(12.0))
    assert part["last_action"] == pytest.approx(-np.arange(12.0))
    assert part["phase_offset"] == pytest.approx([0.2, 0.3, 0.1, 0.4])  # LF, RF, LH, RH
    assert part["velocity_command"] == pytest.approx([1.0, 2.0, 3.0])
    assert part["clock_sin"] == pytest.approx([0.0, 1.0, 0.0, -1.0])
    assert part["clock_cos"] == pytest.approx([1.0, 0.0, -1.0, 0.0])
    assert part["duty_ratio"] == pytest.approx([0.6, 0.4])
    assert part["base_ang_vel_b"] == pytest.approx([0.1, 0.2, 0.3])
    # the observation of the paper is the beginning of the extended one
    assert np.array_equal(observe(LAYOUTS["paper"], situation)[0], vector[:52])


def test_a_driver_without_a_gyroscope_refuses_the_extended_observation_by_name() -> None:
    without = tuple(sensor for sensor in SENSORS if sensor != "angular_velocity_b")
    check_supplied(LAYOUTS["paper"], without, "The driver")
    check_supplied(LAYOUTS["extended"], SENSORS, "The driver")
    message = r"^The driver cannot supply base_ang_vel_b, .* it has no angular_velocity_b\.$"
    with pytest.raises(PolicyMismatch, match=message):
        check_supplied(LAYOUTS["extended"], without, "The driver")


class TestLayoutOfAFile:
    @every_layout
    def test_read_back_it_is_the_same(self, name: str) -> None:
        assert read_layout(get_layout(name).as_list(), "file") == get_layout(name)

    def test_order_and_scales_are_the_files(self) -> None:
        table = [{"name": "joint_vel", "size": 12, "scale": 0.1}, {"name": "clock_sin", "size": 4, "scale": 2.0}]
        layout = read_layout(table, "file")
        assert layout.names == ("joint_vel", "clock_sin")
        vector = layout.assemble({"joint_vel": np.ones((1, 12)), "clock_sin": np.ones((1, 4))})
        assert vector[0] == pytest.approx([0.1] * 12 + [2.0] * 4)

    @pytest.mark.parametrize(
        ("table", "message"),
        [
            (
                [{"name": "height_map", "size": 100, "scale": 1.0}],
                "observes 'height_map', which this version of symdyn cannot",
            ),
            ([{"name": "clock_sin", "size": 8, "scale": 1.0}], "observes 'clock_sin' with 8 numbers.*supplies 4"),
            ([{"name": "clock_sin", "size": 4, "scale": 1.0}] * 2, "observes 'clock_sin' twice"),
        ],
    )
    def test_what_cannot_be_supplied_is_refused_by_name(self, table: list, message: str) -> None:
        with pytest.raises(PolicyMismatch, match=f"^their.onnx: {message}"):
            read_layout(table, "their.onnx")


MIRRORED: Layout = LAYOUTS["extended"]
"""It holds every term."""


def mirror(g: Spatial, vector: np.ndarray) -> np.ndarray:
    index, sign = MIRRORED.mirror(g)
    return sign * vector[..., index]


@pytest.mark.parametrize("g", K4, ids=lambda g: g.name)
@given(st.integers(0, 2**32 - 1))
def test_mirror_is_an_involution(g: Spatial, seed: int) -> None:
    vector = np.random.default_rng(seed).normal(size=(3, MIRRORED.size))
    assert np.array_equal(mirror(g, mirror(g, vector)), vector)
    if g.name != "e":
        assert not np.array_equal(mirror(g, vector), vector)


@given(st.sampled_from(K4), st.sampled_from(K4), st.integers(0, 2**32 - 1))
def test_mirrors_compose_as_the_group_does(a: Spatial, b: Spatial, seed: int) -> None:
    vector = np.random.default_rng(seed).normal(size=MIRRORED.size)
    assert np.array_equal(mirror(a @ b, vector), mirror(a, mirror(b, vector)))


def observed(
    state: RobotState,
    action: np.ndarray,
    offsets: np.ndarray,
    velocity: np.ndarray,
    phase: np.ndarray,
    duty: np.ndarray,
) -> np.ndarray:
    """The observation of a simulated robot, as training puts it together."""
    legs = leg_phase(phase, offsets, velocity[:, 0])
    sensed = Sensed(
        projected_gravity(state.base_quat_w.double().numpy()),
        state.joint_pos.double().numpy(),
        state.joint_vel.double().numpy(),
        state.base_ang_vel_b.double().numpy(),
    )
    return observe(MIRRORED, Situation(sensed, GO2.default_joint_pos, action, offsets, velocity, legs, duty))


def test_mirror_of_an_observation_is_the_observation_of_the_mirrored_robot(
    real_states: RealStates, by_hand: type[MirroredByHand]
) -> None:
    n, rng = len(real_states.qpos), np.random.default_rng(3)
    action, offsets = rng.normal(size=(n, 12)), rng.random((n, 4))
    velocity, phase, duty = rng.normal(size=(n, 3)), rng.random(n), rng.uniform(0.2, 0.8, n)
    original = observed(real_states.state, action, offsets, velocity, phase, duty)
    image = observed(
        real_states.image,
        by_hand.joints(action),
        by_hand.legs(offsets),
        velocity * np.array([1.0, -1.0, -1.0]),
        phase,
        duty,
    )
    np.testing.assert_allclose(mirror(G_S, original), image, atol=1e-6)
    # the states are far from being their own mirror images, so that a wrong sign or leg would show
    assert np.abs(mirror(G_S, original) - original).max(axis=0)[[1, *range(3, 39)]].min() > 0.1


@pytest.mark.parametrize("g", [G_T, G_R], ids=lambda g: g.name)
def test_mirror_of_joint_positions_for_the_fore_aft_elements(real_states: RealStates, g: Spatial) -> None:
    # what the transformed robot observes, up to a constant: these elements move the default pose itself
    q = real_states.state.joint_pos.double().numpy()
    index, sign = TERMS["joint_pos_rel"].mirror(g)
    transformed = g.joint_signs * q[:, list(g.joint_index)] - GO2.default_joint_pos
    difference = sign * (q - GO2.default_joint_pos)[:, index] - transformed
    np.testing.assert_allclose(difference, np.broadcast_to(difference[0], difference.shape), atol=1e-9)
    assert np.abs(difference[0]).max() > 0.1


@pytest.mark.parametrize("g", [G_S, G_T, G_R], ids=lambda g: g.name)
def test_mirror_of_vectors_and_legs_for_every_element(g: Spatial) -> None:
    # what needs no simulator: R on polar vectors, det(R) R on axial ones, legs by where they go
    x, y = (-1.0 if g.swaps_ends else 1.0), (-1.0 if g.swaps_sides else 1.0)
    slices, vector = MIRRORED.slices, np.random.default_rng(0).normal(size=MIRRORED.size)
    image = mirror(g, vector)
    assert image[slices["projected_gravity_b"]] == pytest.approx(vector[:3] * [x, y, 1.0])
    assert image[slices["velocity_command"]] == pytest.approx(vector[slices["velocity_command"]] * [x, y, x * y])
    assert image[slices["duty_ratio"]] == pytest.approx(vector[slices["duty_ratio"]])
    assert image[slices["base_ang_vel_b"]] == pytest.approx(vector[slices["base_ang_vel_b"]] * [y, x, x * y])
    clock, cosine, offset = (slices[name].start for name in ("clock_sin", "clock_cos", "phase_offset"))
    for i, leg in enumerate(("LH", "LF", "RF", "RH")):
        goes_to = {"g_s": "RH RF LF LH", "g_t": "LF LH RH RF", "g_r": "RF RH LH LF"}[g.name].split()[i]
        there = ("LH", "LF", "RF", "RH").index(goes_to)
        assert image[clock + there] == vector[clock + i]
        assert image[cosine + there] == vector[cosine + i]
        in_offsets = ("LF", "RF", "LH", "RH")
        assert image[offset + in_offsets.index(goes_to)] == vector[offset + in_offsets.index(leg)]
