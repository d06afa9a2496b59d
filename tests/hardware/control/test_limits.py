"""Whatever is wanted and wherever the joints are: what is sent is within the motors' torque and drives no joint out."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from hardware.control.limits import damping, limited, target_range
from hardware.control.settings import TICK_HZ, SafetyConfig, StandConfig
from hardware.estimation.kinematics import JointLimits
from hardware.wire.readings import Joints, Targets
from symdyn.robot.legs import JOINTS
from tests.robots import GO2

N = len(JOINTS)
SAFETY = SafetyConfig()
LIMITS = JointLimits.of(GO2)
GAINS = [(GO2.kp, GO2.kd), (StandConfig.kp, StandConfig.kd), (0.1 * StandConfig.kp, 0.1 * StandConfig.kd), (0.0, 0.0)]

share = arrays(float, N, elements=st.floats(0.0, 1.0))
wanted = arrays(float, N, elements=st.floats(-1e3, 1e3))
speed = arrays(float, N, elements=st.floats(-3.0, 3.0))


def state(share: np.ndarray, speed: np.ndarray) -> Joints:
    """Anywhere in the range and as far beyond it as is no fault; at up to three times the limit of the speed."""
    low, high = LIMITS.lower - SAFETY.position_margin, LIMITS.upper + SAFETY.position_margin
    return Joints(low + share * (high - low), speed * LIMITS.velocity, np.zeros(N))


@given(share, speed, wanted, wanted, st.sampled_from(GAINS))
def test_torque_and_range_hold_whatever_is_wanted(
    share: np.ndarray, speed: np.ndarray, wanted: np.ndarray, previous: np.ndarray, gains: tuple[float, float]
) -> None:
    joints = state(share, speed)
    kp, kd = (gain * np.ones(N) for gain in gains)
    sent = limited(Targets(wanted, kp, kd), previous, 1.0 / TICK_HZ, joints, LIMITS, SAFETY)
    torque = sent.kp * (sent.pos - joints.pos) - sent.kd * joints.vel
    assert (np.abs(torque) <= LIMITS.torque + 1e-9).all()
    low, high = target_range(joints, LIMITS, SAFETY.target_lead)
    assert ((sent.pos >= low - 1e-12) & (sent.pos <= high + 1e-12)).all()
    assert (sent.kp == kp).all()
    assert ((sent.kd <= kd) & (sent.kd >= 0.0)).all()


@given(share, speed, share, st.sampled_from(GAINS[:2]))
def test_targets_within_every_limit_are_sent_as_they_are(
    share: np.ndarray, speed: np.ndarray, where: np.ndarray, gains: tuple[float, float]
) -> None:
    middle = 0.25 + 0.5 * share
    joints = Joints(LIMITS.lower + middle * (LIMITS.upper - LIMITS.lower), 0.03 * speed * LIMITS.velocity, np.zeros(N))
    kp, kd = (gain * np.ones(N) for gain in gains)
    reach = 0.5 * LIMITS.torque / kp
    asked = Targets(np.clip(joints.pos + (2.0 * where - 1.0) * reach, LIMITS.lower, LIMITS.upper), kp, kd)
    sent = limited(asked, asked.pos, 1.0 / TICK_HZ, joints, LIMITS, SAFETY)
    assert np.array_equal(sent.pos, asked.pos)
    assert np.array_equal(sent.kd, asked.kd)


def test_a_target_that_jumps_arrives_at_the_highest_rate() -> None:
    stance = GO2.default_joint_pos
    joints = Joints(stance, np.zeros(N), np.zeros(N))
    safety = SafetyConfig(target_rate=10.0)
    asked = Targets(stance + 0.3, 30.0 * np.ones(N), np.ones(N))
    pos, path = stance, []
    for _ in range(8):
        pos = limited(asked, pos, 0.005, joints, LIMITS, safety).pos
        path.append(pos - stance)
    steps = np.diff([np.zeros(N), *path], axis=0)
    assert steps.max() == pytest.approx(0.05)
    assert np.allclose(path[-1], 0.3)


@given(share)
def test_a_joint_at_the_end_of_its_range_is_not_pushed_further(share: np.ndarray) -> None:
    at_end = np.where(share < 0.5, LIMITS.lower, LIMITS.upper)
    outwards = np.where(share < 0.5, -1.0, 1.0)
    joints = Joints(at_end, np.zeros(N), np.zeros(N))
    asked = Targets(at_end + outwards, 30.0 * np.ones(N), 0.65 * np.ones(N))
    sent = limited(asked, at_end, 1.0, joints, LIMITS, SAFETY)
    assert np.allclose(sent.pos, at_end)


@given(share, speed)
def test_damping_takes_energy_within_the_motors_torque(share: np.ndarray, speed: np.ndarray) -> None:
    joints = state(share, speed)
    sent = damping(joints, joints.pos, LIMITS, SAFETY)
    torque = -sent.kd * joints.vel
    assert not sent.kp.any()
    assert (np.abs(torque) <= LIMITS.torque * (1 + 1e-12)).all()
    assert (torque * joints.vel <= 0.0).all()
    slow = np.abs(joints.vel) * SAFETY.damping_kd <= LIMITS.torque
    assert (sent.kd[slow] == SAFETY.damping_kd).all()
    assert ((sent.pos >= LIMITS.lower) & (sent.pos <= LIMITS.upper)).all()


def test_damping_of_a_robot_that_says_nothing() -> None:
    sent = damping(None, GO2.default_joint_pos, LIMITS, SAFETY)
    assert not sent.kp.any()
    assert (sent.kd == SAFETY.damping_kd).all()
