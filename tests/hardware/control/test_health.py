"""What Health says of a stretch of states, against the plain definitions of hardware.control.settings.SafetyConfig."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hardware.control.health import Health
from hardware.control.settings import TICK_HZ, SafetyConfig
from hardware.estimation.kinematics import JointLimits
from hardware.wire.link import Received
from hardware.wire.readings import Imu, Joints
from symdyn.robot.legs import JOINTS
from tests.robots import GO2

N = len(JOINTS)
SAFETY = SafetyConfig()
LIMITS = JointLimits.of(GO2)
MIDDLE = 0.5 * (LIMITS.lower + LIMITS.upper)


def imu(n: int) -> Imu:
    """At rest and upright, with a gyroscope whose last digits do not rest."""
    return Imu(np.array([1.0, 0.0, 0.0, 0.0]), np.array([1e-6 * n, 0.0, 0.0]), np.array([0.0, 0.0, 9.81]), np.zeros(4))


def verdicts(times: list[float], states: list[Joints]) -> list[str | None]:
    """The name of the fault at each time."""
    health = Health(LIMITS, SAFETY)
    found = []
    for n, (now, joints) in enumerate(zip(times, states, strict=True)):
        received = Received(None, now, n)
        fault = health.state_fault(now, received, received, joints, imu(n))
        found.append(None if fault is None else fault.name)
    return found


def expected(times: list[float], states: list[Joints]) -> list[str | None]:
    """By the definitions, looking at the whole past every time."""
    found: list[str | None] = []
    for k, now in enumerate(times):
        beyond = np.maximum(LIMITS.lower - states[k].pos, states[k].pos - LIMITS.upper)
        window = [i for i in range(k + 1) if now - times[i] <= SAFETY.velocity_s + 1e-9]
        speed = np.mean([np.abs(states[i].vel) for i in window], axis=0)
        whole = now - times[window[0]] > 0.5 * SAFETY.velocity_s
        strong_for = np.zeros(N)
        for joint in range(N):
            i = k
            while i >= 0 and abs(states[i].torque[joint]) > SAFETY.torque_factor * LIMITS.torque[joint]:
                strong_for[joint] = now - times[i]
                i -= 1
        if (beyond > SAFETY.position_margin).any():
            found.append("joint_position")
        elif whole and (speed > SAFETY.velocity_factor * LIMITS.velocity).any():
            found.append("joint_velocity")
        else:
            found.append("joint_torque" if (strong_for > SAFETY.torque_s).any() else None)
    return found


@st.composite
def stretches(draw: st.DrawFn) -> tuple[list[float], list[Joints]]:
    """Calm states with bursts in which one joint is near or beyond a limit, at ticks of which some are late."""
    now, times, states = 0.0, [], []
    for _ in range(draw(st.integers(1, 5))):
        joint = draw(st.integers(0, N - 1))
        kind = draw(st.sampled_from(["calm", "pos", "vel", "torque"]))
        # not on a limit itself, where only rounding decides
        size = draw(st.floats(0.9, 1.4).filter(lambda s: abs(s - 1.0) > 1e-9)) * draw(st.sampled_from([-1.0, 1.0]))
        for _ in range(draw(st.integers(1, 15))):
            now += draw(st.sampled_from([1.0, 1.0, 1.0, 1.0, 1.1, 3.3])) / TICK_HZ
            pos, vel, torque = MIDDLE.copy(), np.zeros(N), np.zeros(N)
            if kind == "pos":
                reach = 0.5 * (LIMITS.upper - LIMITS.lower) + SAFETY.position_margin
                pos[joint] += size * reach[joint]
            if kind == "vel":
                vel[joint] = size * SAFETY.velocity_factor * LIMITS.velocity[joint]
            if kind == "torque":
                torque[joint] = size * SAFETY.torque_factor * LIMITS.torque[joint]
            times.append(now)
            states.append(Joints(pos, vel, torque))
    return times, states


@given(stretches())
def test_limits_of_joints_are_judged_as_they_are_defined(stretch: tuple[list[float], list[Joints]]) -> None:
    assert verdicts(*stretch) == expected(*stretch)


@pytest.mark.parametrize("kind", ["vel", "torque"])
def test_a_lasting_excess_is_a_fault_and_a_short_one_is_not(kind: str) -> None:
    calm = Joints(MIDDLE, np.zeros(N), np.zeros(N))
    loud = {"vel": np.zeros(N), "torque": np.zeros(N)}
    loud[kind][3] = {"vel": 2.5 * LIMITS.velocity[3], "torque": 1.5 * LIMITS.torque[3]}[kind]
    excess = Joints(MIDDLE, **loud)
    times = [k / TICK_HZ for k in range(40)]
    assert set(verdicts(times, [calm] * 10 + [excess] + [calm] * 29)) == {None}
    assert {"vel": "joint_velocity", "torque": "joint_torque"}[kind] in verdicts(times, [calm] * 10 + [excess] * 30)


def test_torque_that_paused_is_no_lasting_excess_even_if_another_limit_was_broken_meanwhile() -> None:
    strong = Joints(MIDDLE, np.zeros(N), 1.5 * LIMITS.torque)
    outside = Joints(LIMITS.upper + 2.0 * SAFETY.position_margin, np.zeros(N), np.zeros(N))
    n = round(SAFETY.torque_s * TICK_HZ) - 1
    times = [k / TICK_HZ for k in range(2 * n + 1)]
    assert verdicts(times, [strong] * n + [outside] + [strong] * n) == [None] * n + ["joint_position"] + [None] * n


def test_joints_that_rest_to_the_last_digit_with_the_gyroscope_are_frozen() -> None:
    health = Health(LIMITS, SAFETY)
    joints = Joints(MIDDLE, np.zeros(N), np.zeros(N))
    names = []
    for k in range(40):
        received = Received(None, k / TICK_HZ, k)
        # the force of a foot may change: it is not what is looked at
        still = Imu(np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3), np.array([0.0, 0.0, 9.81]), np.full(4, float(k)))
        fault = health.state_fault(k / TICK_HZ, received, received, joints, still)
        names.append(None if fault is None else fault.name)
    first = round(SAFETY.frozen_s * TICK_HZ)
    assert set(names[:first]) == {None}
    assert set(names[first + 2 :]) == {"frozen_state"}
