"""The 52 numbers: their order as the paper and the issue give it, and their mirror image against a real robot's."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from symdyn.errors import SymdynError
from symdyn.gait.phase import leg_phase
from symdyn.gait.symmetry import G_R, G_S, G_T, K4, Spatial
from symdyn.policy.observation import OBSERVATION, command_terms
from symdyn.robot.definition import GO2
from symdyn.robot.frames import projected_gravity
from symdyn.robot.legs import JOINTS

if TYPE_CHECKING:
    from rl.physics.protocol import RobotState
    from tests.rl.physics.real_states import RealStates
    from tests.symdyn.robot.mirrored_by_hand import MirroredByHand

ORDER = [
    ("projected_gravity_b", 3),
    ("joint_pos_rel", 12),
    ("joint_vel", 12),
    ("last_action", 12),
    ("velocity_command", 3),
    ("clock_sin", 4),
    ("phase_offset", 4),
    ("duty_ratio", 2),
]


def test_order_and_sizes() -> None:
    assert [(term.name, term.size) for term in OBSERVATION.terms] == ORDER
    assert OBSERVATION.size == 52
    assert [(entry["name"], entry["size"]) for entry in OBSERVATION.as_list()] == ORDER
    start = 0
    for name, size in ORDER:
        assert OBSERVATION.slices[name] == slice(start, start + size)
        start += size


def test_order_of_the_legs_within_the_terms() -> None:
    labels = {term.name: term.labels for term in OBSERVATION.terms}
    assert labels["clock_sin"] == ("LH", "LF", "RF", "RH")
    assert labels["phase_offset"] == ("LF", "RF", "LH", "RH")
    for name in ("joint_pos_rel", "joint_vel", "last_action"):
        assert labels[name] == JOINTS


def test_noise_is_the_papers_table_3() -> None:
    noise = {term.name: term.noise for term in OBSERVATION.terms}
    assert noise.pop("projected_gravity_b") == 0.05
    assert noise.pop("joint_pos_rel") == 0.01
    assert noise.pop("joint_vel") == 1.5
    assert set(noise.values()) == {0.0}
    # of the vector: scaled as the numbers are
    amplitude = OBSERVATION.noise_amplitude()
    assert amplitude.shape == (52,)
    assert amplitude[:3].tolist() == [0.05] * 3
    assert amplitude[OBSERVATION.slices["joint_vel"]] == pytest.approx([1.5 * 0.05] * 12)


def values(n: int, seed: int = 0) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    return {name: rng.normal(size=(n, size)) for name, size in ORDER}


def test_assembled_by_hand() -> None:
    given_values = {name: np.full((1, size), k + 1.0) for k, (name, size) in enumerate(ORDER)}
    vector = OBSERVATION.assemble(given_values)[0]
    expected = [1.0] * 3 + [2.0] * 12 + [3.0 * 0.05] * 12 + [4.0] * 12 + [5.0] * 3 + [6.0] * 4 + [7.0] * 4 + [8.0] * 2
    assert vector == pytest.approx(expected)


def test_assembled_vector_is_fresh_and_the_same_in_torch() -> None:
    ours = values(3)
    theirs = {name: torch.from_numpy(value.copy()) for name, value in ours.items()}
    vector, tensor = OBSERVATION.assemble(ours), OBSERVATION.assemble(theirs)
    assert np.array_equal(vector, tensor.numpy())
    before = tensor.clone()
    for value in theirs.values():
        value += 1.0
    assert torch.equal(tensor, before)


@pytest.mark.parametrize("change", ["missing", "unknown", "wrong size"])
def test_wrong_terms_are_refused_by_name(change: str) -> None:
    wrong = values(2)
    if change == "missing":
        del wrong["clock_sin"]
    elif change == "unknown":
        wrong["clock_cos"] = wrong["clock_sin"]
    else:
        wrong["clock_sin"] = wrong["clock_sin"][:, :3]
    with pytest.raises(SymdynError, match="clock_cos" if change == "unknown" else "clock_sin"):
        OBSERVATION.assemble(wrong)


def test_command_terms_by_hand() -> None:
    terms = command_terms(
        offsets=np.array([[0.1, 0.2, 0.3, 0.4]]),  # LH, LF, RF, RH
        velocity=np.array([[1.0, 2.0, 3.0]]),
        leg_phases=np.array([[0.0, 0.25, 0.5, 0.75]]),
        duty=np.array([0.6]),
    )
    assert terms["phase_offset"][0] == pytest.approx([0.2, 0.3, 0.1, 0.4])  # LF, RF, LH, RH
    assert terms["velocity_command"][0] == pytest.approx([1.0, 2.0, 3.0])
    assert terms["clock_sin"][0] == pytest.approx([0.0, 1.0, 0.0, -1.0])
    assert terms["duty_ratio"][0] == pytest.approx([0.6, 0.4])


def mirror(g: Spatial, vector: np.ndarray) -> np.ndarray:
    index, sign = OBSERVATION.mirror(g)
    return sign * vector[..., index]


@pytest.mark.parametrize("g", K4, ids=lambda g: g.name)
@given(st.integers(0, 2**32 - 1))
def test_mirror_is_an_involution(g: Spatial, seed: int) -> None:
    vector = np.random.default_rng(seed).normal(size=(3, 52))
    assert np.array_equal(mirror(g, mirror(g, vector)), vector)
    if g.name != "e":
        assert not np.array_equal(mirror(g, vector), vector)


@given(st.sampled_from(K4), st.sampled_from(K4), st.integers(0, 2**32 - 1))
def test_mirrors_compose_as_the_group_does(a: Spatial, b: Spatial, seed: int) -> None:
    vector = np.random.default_rng(seed).normal(size=52)
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
    return OBSERVATION.assemble(
        {
            "projected_gravity_b": projected_gravity(state.base_quat_w.double().numpy()),
            "joint_pos_rel": state.joint_pos.double().numpy() - GO2.default_joint_pos,
            "joint_vel": state.joint_vel.double().numpy(),
            "last_action": action,
            **command_terms(offsets, velocity, legs, duty),
        }
    )


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
    term = next(term for term in OBSERVATION.terms if term.name == "joint_pos_rel")
    index, sign = term.mirror(g)
    transformed = g.joint_signs * q[:, list(g.joint_index)] - GO2.default_joint_pos
    difference = sign * (q - GO2.default_joint_pos)[:, index] - transformed
    np.testing.assert_allclose(difference, np.broadcast_to(difference[0], difference.shape), atol=1e-9)
    assert np.abs(difference[0]).max() > 0.1


@pytest.mark.parametrize("g", [G_S, G_T, G_R], ids=lambda g: g.name)
def test_mirror_of_vectors_and_legs_for_every_element(g: Spatial) -> None:
    # what needs no simulator: R on polar vectors, det(R) R on axial ones, legs by where they go
    x, y = (-1.0 if g.swaps_ends else 1.0), (-1.0 if g.swaps_sides else 1.0)
    slices, vector = OBSERVATION.slices, np.random.default_rng(0).normal(size=52)
    image = mirror(g, vector)
    assert image[slices["projected_gravity_b"]] == pytest.approx(vector[:3] * [x, y, 1.0])
    assert image[slices["velocity_command"]] == pytest.approx(vector[slices["velocity_command"]] * [x, y, x * y])
    assert image[slices["duty_ratio"]] == pytest.approx(vector[slices["duty_ratio"]])
    clock, offset = slices["clock_sin"].start, slices["phase_offset"].start
    for i, leg in enumerate(("LH", "LF", "RF", "RH")):
        goes_to = {"g_s": "RH RF LF LH", "g_t": "LF LH RH RF", "g_r": "RF RH LH LF"}[g.name].split()[i]
        there = ("LH", "LF", "RF", "RH").index(goes_to)
        assert image[clock + there] == vector[clock + i]
        in_offsets = ("LF", "RF", "LH", "RH")
        assert image[offset + in_offsets.index(goes_to)] == vector[offset + in_offsets.index(leg)]
