"""A simulated robot that is one machine: its delay, gains, strength and encoders are those of the fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hardware.robot_sim.fitted_motors import SUBSTEP, FittedMotors
from hardware.robot_sim.sensors import NO_NOISE
from hardware.robot_sim.settings import PERIOD
from hardware.wire.readings import Joints
from symdyn.robot.fit import Fit, JointFit, Measured
from symdyn.robot.legs import JOINTS
from tests.hardware.robot_sim.simulated import go2
from tests.hardware.robot_sim.test_simulated_robot import run, targets
from tests.robots import GO2

ONES = np.ones(len(JOINTS))
DELAYS = (0.007, 0.018)


def machine(**values: float) -> Fit:
    nominal = {"delay": 0.0, "strength": 1.0, "kp": 1.0, "kd": 1.0, "friction": 0.0, "damping": 0.0, "offset": 0.0}
    its = {name: Measured(value, value, value) for name, value in (nominal | {"armature": 0.005} | values).items()}
    return Fit("go2", "test", "", "hung", "", tuple(JointFit(joint, **its) for joint in JOINTS))


def test_a_command_acts_after_the_delay_of_each_joint_give_or_take_half_a_period() -> None:
    fit = machine()
    late = [replace(j, delay=Measured(d, d, d)) for j, d in zip(fit.joints, DELAYS * 6, strict=True)]
    motors = FittedMotors(replace(fit, joints=tuple(late)))
    motors.command(0.0, 0.0 * ONES, ONES, ONES, 0.0 * ONES, 0.0 * ONES)
    motors.forget(0.0)
    motors.command(0.1, ONES, ONES, ONES, 0.0 * ONES, 0.0 * ONES)
    begins = np.arange(0.09, 0.13, SUBSTEP / 8)
    acting = np.array([motors.acting(begin)[0] for begin in begins])
    # the mean over a substep is half way when the command acts in its middle
    at = [begins[np.argmax(column >= 0.5)] + 0.5 * SUBSTEP - 0.1 for column in acting.T]
    assert np.array(at) == pytest.approx(np.array(DELAYS * 6), abs=0.5 * PERIOD + SUBSTEP / 8)
    reported = np.array([motors.reported(begin, 0.0 * ONES, 0.0 * ONES) for begin in begins])
    since = [begins[np.argmax(column > 0.5)] - 0.1 for column in reported.T]
    assert np.array(since) == pytest.approx(np.array(at), abs=SUBSTEP / 4)


def test_gravity_in_the_air_is_held_by_strength_times_the_torque_that_is_reported() -> None:
    def hanging(**values: float) -> Joints:
        robot = go2(start="hung", noise=NO_NOISE, fit=machine(**values))
        robot.command(targets())
        run(robot, 2.0)
        return Joints.of(robot.joints())

    plain, weak, off = hanging(), hanging(strength=0.8, kp=1.25, kd=1.25), hanging(offset=0.05)
    # the same stiffness at the joint: the same pose, and a torque that the motor takes to be larger
    np.testing.assert_allclose(weak.pos, plain.pos, atol=1e-4)
    np.testing.assert_allclose(weak.torque, plain.torque / 0.8, atol=5e-3)
    law = GO2.kp * (GO2.default_joint_pos - off.pos) - GO2.kd * off.vel
    np.testing.assert_allclose(off.torque, law, atol=1e-4)


def test_friction_is_what_a_steady_motion_costs() -> None:
    joint, speed = JOINTS.index("RF_calf"), -1.0

    def torque(friction: float) -> float:
        robot = go2(start="hung", noise=NO_NOISE, fit=machine(friction=friction))
        robot.command(targets())
        run(robot, 1.0)
        found = []
        for step in range(200):
            pos = GO2.default_joint_pos.copy()
            pos[joint] += speed * step * PERIOD
            robot.command(targets(pos))
            robot.step()
            found.append(Joints.of(robot.joints()).torque[joint])
        return float(np.mean(found[100:]))

    assert torque(0.6) - torque(0.0) == pytest.approx(np.sign(speed) * 0.6, abs=0.06)
