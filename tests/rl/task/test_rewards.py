"""Each reward term by hand, within its bounds, monotone, and blind to left and right on states of a real simulator."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from rl.physics.protocol import heading_velocity
from rl.task import rewards
from rl.task.settings import RewardConfig
from symdyn.errors import InvalidValue
from symdyn.gait.library import get
from tests.robots import GO2

if TYPE_CHECKING:
    from rl.physics.protocol import RobotState
    from tests.rl.physics.real_states import RealStates
    from tests.symdyn.robot.mirrored_by_hand import MirroredByHand

PAPER = RewardConfig()


def tensor(*values: float) -> torch.Tensor:
    return torch.tensor([values], dtype=torch.float64)


def only(values: torch.Tensor) -> float:
    assert values.shape == (1,)
    return float(values[0])


# by hand, with the paper's numbers written out


def test_weights_and_rates_are_the_papers() -> None:
    weights = (PAPER.x_velocity, PAPER.y_velocity, PAPER.yaw_velocity, PAPER.base_height)
    assert weights == (0.3, 0.3, 0.3, 0.3)
    assert (PAPER.torque_change, PAPER.hip_action, PAPER.clearance) == (0.1, 0.15, 0.15)
    assert (PAPER.temporal, PAPER.morphological) == (0.15, 0.15)
    assert (PAPER.x_rate, PAPER.y_rate, PAPER.yaw_rate, PAPER.height_rate) == (2.0, 10.0, 5.0, 5.0)
    assert (PAPER.torque_rate, PAPER.hip_rate, PAPER.clearance_rate) == (0.1, 0.5, 20.0)
    assert (PAPER.force_rate, PAPER.foot_speed_rate, PAPER.pair_rate) == (0.001, 2.0, 5.0)
    assert (PAPER.exp_share, PAPER.velocity_filter, PAPER.morphological_term) == (0.0, 0.0, True)


def test_velocity_error() -> None:
    got = rewards.velocity_error(torch.tensor([1.5, 0.5, 1.0]), torch.tensor([1.0, 1.0, 1.0]), 2.0)
    assert got.tolist() == pytest.approx([-(1 - math.exp(-1.0)), -(1 - math.exp(-1.0)), 0.0])


@pytest.mark.parametrize(("height", "d_h"), [(0.30, 0.05), (0.35, 0.0), (0.40, 0.0), (0.45, 0.0), (0.47, 0.02)])
def test_base_height(height: float, d_h: float) -> None:
    got = only(rewards.base_height(torch.tensor([height], dtype=torch.float64), (0.35, 0.45), 5.0))
    assert got == pytest.approx(-(1 - math.exp(-5.0 * d_h)), abs=1e-9)


def test_torque_change_is_the_1_norm() -> None:
    now, before = torch.zeros(1, 12), torch.zeros(1, 12)
    now[0, 0], now[0, 5], before[0, 11] = 2.0, -3.0, 1.0
    assert only(rewards.torque_change(now, before, 0.1)) == pytest.approx(-(1 - math.exp(-0.1 * 6.0)))


def test_hip_action_is_softmax_weighted() -> None:
    action = torch.full((1, 12), 100.0)  # thighs and calves do not matter
    action[0, [0, 3, 6, 9]] = torch.tensor([1.0, 0.0, 0.0, -2.0])
    e1, e2 = math.e, math.e**2
    weighted = (e1 * 1.0 + e2 * 2.0) / (e1 + 1.0 + 1.0 + e2)
    assert only(rewards.hip_action(action, 0.5)) == pytest.approx(-(1 - math.exp(-0.5 * weighted)))


def test_clearance() -> None:
    height = tensor(0.02, 0.02, 0.08, 0.03)
    swing = torch.tensor([[True, False, True, True]])
    progress = tensor(0.5, 0.5, 0.5, 0.0)
    # the first is 3 cm short at full weight, the last 2 cm at half; the second stands and the third is high enough
    short = 0.03 * 1.0 + 0.02 * 0.5
    got = only(rewards.clearance(height, swing, progress, 0.05, 20.0))
    assert got == pytest.approx(-(1 - math.exp(-20.0 * short)))


def test_clearance_weight_is_half_at_the_ends_of_swing_and_one_in_its_middle() -> None:
    swing, low = torch.tensor([[True, False, False, False]]), tensor(0.0, 0.0, 0.0, 0.0)

    def shortfall(s: float) -> float:
        return -math.log1p(only(rewards.clearance(low, swing, tensor(s, 0, 0, 0), 0.05, 20.0))) / 20.0

    assert shortfall(0.0) == pytest.approx(0.025)
    assert shortfall(0.5) == pytest.approx(0.05)
    assert shortfall(1.0) == pytest.approx(0.025)
    assert shortfall(0.25) == pytest.approx(0.5 * (1 + math.sqrt(0.5)) * 0.05)


def test_temporal() -> None:
    force, speed = tensor(100.0, 100.0, 0.0, 50.0), tensor(0.5, 0.5, 1.0, 0.0)
    expected_swing = tensor(1.0, 0.0, 0.25, 0.5)
    penalty = (
        (1 - math.exp(-0.1))  # swings, but bears 100 N; its speed is free
        + (1 - math.exp(-1.0))  # stands, but slides at 0.5 m/s; its force is free
        + 0.75 * (1 - math.exp(-2.0))
        + 0.5 * (1 - math.exp(-0.05))
    )
    assert only(rewards.temporal(force, speed, expected_swing, 0.001, 2.0)) == pytest.approx(-penalty)


def pose(**legs: tuple[float, float, float]) -> torch.Tensor:
    return torch.tensor([[*legs["LH"], *legs["LF"], *legs["RF"], *legs["RH"]]], dtype=torch.float64)


UNEVEN = pose(LH=(0.1, 0.7, -1.2), LF=(0.2, 0.9, -1.5), RF=(-0.2, 0.9, -1.5), RH=(-0.1, 0.7, -1.2))
"""Its own mirror image: hips of opposite sides turn oppositely about x. Fore and hind differ."""


def offsets(gait: str) -> torch.Tensor:
    return torch.tensor([get(gait).offsets], dtype=torch.float64)


def test_pairs_of_a_bound_agree_in_a_pose_that_is_its_own_mirror_image() -> None:
    assert only(rewards.morphological(UNEVEN, offsets("bound"), 5.0)) == 0.0
    # in a trot the fore and the hind leg of a diagonal should agree, and here they do not
    apart = (0.1 + 0.2 + 0.3) * 2.0
    assert only(rewards.pair_difference(UNEVEN, offsets("trot"))) == pytest.approx(apart)
    assert only(rewards.morphological(UNEVEN, offsets("trot"), 5.0)) == pytest.approx(-(1 - math.exp(-5.0 * apart)))


def test_equal_hip_angles_on_both_sides_are_no_symmetry() -> None:
    # both feet to the left of their hips: what |q_i - q_j| without signs would call alike
    leaning = pose(LH=(0.1, 0.7, -1.2), LF=(0.1, 0.7, -1.2), RF=(0.1, 0.7, -1.2), RH=(0.1, 0.7, -1.2))
    assert only(rewards.pair_difference(leaning, offsets("bound"))) == pytest.approx(0.4)


def test_pair_difference_sums_over_pairs_in_phase_and_joints() -> None:
    q = UNEVEN.clone()
    q[0, 10] += 0.05  # the thigh of RH
    assert only(rewards.pair_difference(q, offsets("bound"))) == pytest.approx(0.05)
    assert only(rewards.pair_difference(q, offsets("half_bound_left"))) == pytest.approx(0.05)
    q[0, 4] += 0.3  # the thigh of LF: only the bound pairs it with RF
    assert only(rewards.pair_difference(q, offsets("bound"))) == pytest.approx(0.35)
    assert only(rewards.pair_difference(q, offsets("half_bound_left"))) == pytest.approx(0.05)
    for gallop in ("rotary_gallop", "transverse_gallop"):
        assert only(rewards.pair_difference(q, offsets(gallop))) == 0.0


def test_total() -> None:
    terms = {"a": torch.tensor([-0.25, -0.7, 0.0]), "b": torch.tensor([-0.25, -0.7, 0.0])}
    assert rewards.total(terms, exp_share=0.0).tolist() == pytest.approx([0.5, 0.0, 1.0])
    assert rewards.total(terms, exp_share=1.0).tolist() == pytest.approx([math.exp(-0.5), math.exp(-1.4), 1.0])
    mixed = [0.75 * 0.5 + 0.25 * math.exp(-0.5), 0.25 * math.exp(-1.4), 1.0]
    assert rewards.total(terms, exp_share=0.25).tolist() == pytest.approx(mixed)


def test_soft_total_is_the_papers_away_from_the_corner_and_has_a_slope_everywhere() -> None:
    penalty = torch.linspace(-2.5, 0.0, 101, dtype=torch.float64, requires_grad=True)
    soft = rewards.total({"a": penalty}, exp_share=0.0, softness=0.1)
    hard = rewards.total({"a": penalty}, exp_share=0.0)
    (slope,) = torch.autograd.grad(soft.sum(), penalty)
    with torch.no_grad():
        # furthest at the corner, by log(2) widths; exponentially less beside it
        assert float((soft - hard).max()) == pytest.approx(0.1 * math.log(2.0), rel=0.05)
        apart = (penalty + 1.0).abs()
        assert ((soft - hard) <= 0.1 * torch.exp(-apart / 0.1) + 1e-12).all()
        assert (soft >= hard).all()
        assert (slope > 0.0).all()
        assert (slope <= 1.0).all()


@given(st.floats(-1.9, 0.0))
def test_clip_and_exp_agree_to_first_order_and_are_rewards(penalty: float) -> None:
    terms = {
        "a": torch.tensor([penalty / 2], dtype=torch.float64),
        "b": torch.tensor([penalty / 2], dtype=torch.float64),
    }
    clip, exp = only(rewards.total(terms, 0.0)), only(rewards.total(terms, 1.0))
    # Taylor: exp(p) - (1 + p) lies between 0 and p^2 / 2
    if penalty > -1.0:
        assert -1e-12 <= exp - clip <= penalty**2 / 2 + 1e-12
    assert 0.0 <= clip <= 1.0
    assert 0.0 < exp <= 1.0


@pytest.mark.parametrize("bad", [-0.1, math.nan, math.inf])
def test_bad_settings_are_refused_by_name(bad: float) -> None:
    with pytest.raises(InvalidValue, match="force_rate"):
        RewardConfig(force_rate=bad)
    with pytest.raises(InvalidValue, match="exp_share"):
        RewardConfig(exp_share=1.1)


# bounds and monotonicity

amounts = st.floats(0.0, 50.0)


@given(amounts, st.floats(0.01, 5.0), st.floats(0.001, 20.0))
def test_saturating_is_bounded_and_monotone(amount: float, more: float, rate: float) -> None:
    a, b = (float(rewards.saturating(torch.tensor(x, dtype=torch.float64), rate)) for x in (amount, amount + more))
    assert 0.0 <= a <= b <= 1.0
    if rate * amount < 20.0 and rate * more > 1e-6:
        assert a < b


@given(st.integers(0, 2**32 - 1), st.floats(0.0, 10.0))
def test_every_term_lies_between_minus_one_and_zero_whatever_the_state(seed: int, scale: float) -> None:
    generator = torch.Generator().manual_seed(seed)

    def normal(*shape: int) -> torch.Tensor:
        return scale * torch.randn(shape, generator=generator, dtype=torch.float64)

    unit = torch.rand((8, 4), generator=generator, dtype=torch.float64)
    terms = {
        "velocity": rewards.velocity_error(normal(8), normal(8), 10.0),
        "height": rewards.base_height(normal(8), (0.35, 0.45), 5.0),
        "torque": rewards.torque_change(normal(8, 12), normal(8, 12), 0.1),
        "hip": rewards.hip_action(normal(8, 12), 0.5),
        "clearance": rewards.clearance(normal(8, 4), normal(8, 4) > 0, unit, 0.05, 20.0),
        "temporal": rewards.temporal(normal(8, 4).abs() * 100.0, normal(8, 4).abs(), unit, 0.001, 2.0) / 4.0,  # per leg
        "morphological": rewards.morphological(normal(8, 12), unit.round(decimals=1), 5.0),
    }
    for name, value in terms.items():
        assert value.shape == (8,), name
        assert bool(((value >= -1.0) & (value <= 0.0)).all()), name


@given(st.integers(0, 3), st.floats(0.0, 300.0), st.floats(1.0, 100.0), st.floats(0.0, 1.0))
def test_more_force_in_swing_and_more_speed_in_stance_cost_more(
    leg: int, base: float, more: float, swing: float
) -> None:
    force, speed = tensor(base, base, base, base), tensor(0.2, 0.2, 0.2, 0.2)
    expected = tensor(swing, swing, swing, swing)
    before = only(rewards.temporal(force, speed, expected, 0.001, 2.0))
    force[0, leg] += more
    pushed = only(rewards.temporal(force, speed, expected, 0.001, 2.0))
    speed[0, leg] += more / 100.0
    slid = only(rewards.temporal(force, speed, expected, 0.001, 2.0))
    assert before >= pushed >= slid
    if swing > 0.01:
        assert before > pushed
    if swing < 0.99:
        assert pushed > slid


@given(st.floats(-0.05, 0.2), st.floats(0.001, 0.1), st.floats(0.0, 1.0))
def test_a_higher_swinging_foot_costs_no_more(height: float, more: float, s: float) -> None:
    swing, progress = torch.tensor([[True, True, False, False]]), tensor(s, s, s, s)

    def term(z: float) -> float:
        return only(rewards.clearance(tensor(z, 0.0, 0.0, 0.0), swing, progress, 0.05, 20.0))

    assert term(height) <= term(height + more)
    if height + more < 0.05:
        assert term(height) < term(height + more)


@given(
    st.integers(0, 2), st.floats(0.0, 1.0), st.floats(0.01, 0.5), st.sampled_from(["trot", "bound", "pronk", "pace"])
)
def test_legs_further_apart_cost_more(joint: int, apart: float, more: float, gait: str) -> None:
    q = UNEVEN.clone()
    q[:, 3:9] = q[:, [0, 1, 2, 9, 10, 11]]  # fore like hind
    theta = offsets(gait)
    assert only(rewards.pair_difference(q, theta)) == 0.0
    q[0, joint] += apart
    near = only(rewards.pair_difference(q, theta))
    q[0, joint] += more
    assert only(rewards.pair_difference(q, theta)) > near


# mirror invariance


def all_terms(
    state: RobotState, action: torch.Tensor, last_torque: torch.Tensor, theta: torch.Tensor, command: torch.Tensor,
    swing: torch.Tensor,
) -> dict[str, torch.Tensor]:  # fmt: skip
    velocity = heading_velocity(state)
    height = state.foot_pos_w[..., 2] - 0.0194
    force, speed = state.foot_force_w.norm(dim=-1), state.foot_vel_w.norm(dim=-1)
    return {
        "x": 0.3 * rewards.velocity_error(velocity[:, 0], command[:, 0], 2.0),
        "y": 0.3 * rewards.velocity_error(velocity[:, 1], command[:, 1], 10.0),
        "yaw": 0.3 * rewards.velocity_error(velocity[:, 2], command[:, 2], 5.0),
        "height": 0.3 * rewards.base_height(state.base_pos_w[:, 2], GO2.base_height_range, 5.0),
        "torque": 0.1 * rewards.torque_change(state.joint_torque, last_torque, 0.1),
        "hip": 0.15 * rewards.hip_action(action, 0.5),
        "clearance": 0.15 * rewards.clearance(height, swing > 0.5, swing, 0.05, 20.0),
        "temporal": 0.15 * rewards.temporal(force, speed, swing, 0.001, 2.0),
        "morphological": 0.15 * rewards.morphological(state.joint_pos, theta, 5.0),
    }


@pytest.mark.parametrize("gait", ["trot", "bound", "half_bound_left", "rotary_gallop", "pace"])
def test_a_state_and_its_mirror_image_earn_the_same(
    real_states: RealStates, by_hand: type[MirroredByHand], gait: str
) -> None:
    n, rng = len(real_states.qpos), np.random.default_rng(0)
    action, torque, command, swing = (
        torch.from_numpy(rng.normal(size=shape)).float() for shape in ((n, 12), (n, 12), (n, 3), (n, 4))
    )
    swing = torch.sigmoid(swing)
    torque = real_states.state.joint_torque + torque
    theta = offsets(gait).float().expand(n, 4)
    original = all_terms(real_states.state, action, torque, theta, command, swing)
    image = all_terms(
        real_states.image,
        by_hand.joints(action),
        by_hand.joints(torque),
        by_hand.legs(theta),
        command * torch.tensor([1.0, -1.0, -1.0]),
        by_hand.legs(swing),
    )
    for name, value in original.items():
        # the feet's meshes are off the sagittal plane by 0.04 mm, alike on both sides
        assert torch.allclose(value, image[name], atol=1e-4), name
        if (name, gait) != ("morphological", "rotary_gallop"):  # which has no legs in phase
            assert float(value.std()) > 1e-4, name
