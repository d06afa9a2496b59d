"""Whether legs are taken for each other: against a trunk that is turned above feet that stay where they are, and
against the simulated robot, whose legs are exchanged on the wire."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pinocchio
import pytest
from lockstep import shipped, until
from scipy.optimize import root

from hardware.controller import Controller, State
from hardware.leg_kinematics import LegKinematics
from hardware.leg_order import LegOrder
from hardware.readings import Imu, Joints
from hardware.robot_sim.lockstep import Lockstep
from hardware.robot_sim.rig import Rig
from hardware.robot_sim.scenarios import get_scenario
from hardware.sdk_order import SDK_LEGS
from hardware.settings import Settings, StandConfig
from symdyn.cli.robot_sim import go2
from symdyn.legs import LEGS
from symdyn.robot import GO2

KINEMATICS = LegKinematics(GO2)
STANCE = np.array(GO2.default_joint_pos)
FEET_W = KINEMATICS.feet(STANCE).centre_b
QUICK = Settings(stand=StandConfig(rise_s=0.8, ramp_s=0.2, settle_s=0.2, wiggle_s=0.1))
ORDERS = [order for order in permutations(range(len(LEGS))) if order != tuple(range(len(LEGS)))]


def standing(roll: float, pitch: float) -> tuple[Joints, Imu]:
    """A trunk turned by these angles, above feet that have stayed on the floor; what joints and IMU say of it."""
    turn = pinocchio.rpy.rpyToMatrix(roll, pitch, 0.0)

    def missed(joint_pos: np.ndarray) -> np.ndarray:
        return (KINEMATICS.feet(joint_pos).centre_b - FEET_W @ turn).ravel()

    found = root(missed, STANCE)
    assert found.success
    still = np.zeros(12)
    x, y, z, w = pinocchio.Quaternion(turn).coeffs()
    return Joints(found.x, still, still), Imu(np.array([w, x, y, z]), np.zeros(3), np.zeros(3), np.zeros(4))


MOMENTS = [standing(roll, pitch) for roll, pitch in np.random.default_rng(0).uniform(-0.03, 0.03, (8, 2))]


class TestAgreement:
    def test_a_trunk_above_its_feet_tilts_as_its_legs_say(self) -> None:
        order = LegOrder(KINEMATICS)
        for leg in LEGS:
            for joints, imu in MOMENTS:
                order.observe(leg, joints, imu)
        assert order.agreement() == pytest.approx(np.ones((4, 2)), abs=1e-6)

    def test_not_if_the_legs_of_two_sides_or_ends_are_exchanged(self) -> None:
        for exchange, expected in (("RF LF", [1.0, -1.0]), ("LH LF", [-1.0, 1.0]), ("LH RF", [-1.0, -1.0])):
            # all four in pairs, and so a reflection or a half turn of the plane
            a, b = exchange.split()
            c, d = (leg for leg in LEGS if leg not in (a, b))
            image = {a: b, b: a, c: d, d: c}
            legs = [LEGS.index(image[leg]) for leg in LEGS]
            order = LegOrder(KINEMATICS)
            for joints, imu in MOMENTS:
                rows = joints.pos.reshape(4, 3)[legs]
                rows[:, 0] *= [1.0 if leg[0] == image[leg][0] else -1.0 for leg in LEGS]  # hips are mirror images
                order.observe("LF", Joints(rows.ravel(), joints.vel, joints.torque), imu)
            assert order.agreement()[LEGS.index("LF")] == pytest.approx(expected, abs=0.02)

    def test_what_was_not_seen_and_what_did_not_move_is_nothing(self) -> None:
        order = LegOrder(KINEMATICS)
        for _, imu in MOMENTS:
            order.observe("LF", MOMENTS[0][0], imu)
        for joints, _ in MOMENTS:
            order.observe("RH", joints, MOMENTS[0][1])
        assert order.agreement() == pytest.approx(np.zeros((4, 2)))


def exchanged(rig: Rig, order: tuple[int, ...]) -> Rig:
    """The robot with the wire's legs in another order, in what it says and in what it is told alike."""
    state = [3 * leg + joint for leg in order for joint in range(3)]
    joints, command = rig.robot.joints, rig.robot.command

    def said():
        message = joints()
        for field in ("q", "qd", "tau_est"):
            setattr(message, field, [getattr(message, field)[i] for i in state])
        return message

    def told(message) -> None:
        for field in ("q_des", "qd_des", "tau_ff", "kp", "kd"):
            values = dict(zip(state, getattr(message, field), strict=True))
            setattr(message, field, [values[i] for i in range(len(state))])
        command(message)

    rig.robot.joints, rig.robot.command = said, told
    return rig


@pytest.mark.parametrize("order", ORDERS, ids=lambda order: "-".join(SDK_LEGS[leg] for leg in order))
def test_no_other_order_of_the_legs_passes_the_stand(order: tuple[int, ...]) -> None:
    rig = exchanged(Rig(go2(), get_scenario("stand")), order)
    its = Lockstep(Controller(shipped(), QUICK), rig)
    until(its, State.STAND, 2.0)
    until(its, State.DAMP, 4.0)
    assert its.controller.fault is not None
    assert its.controller.fault.name == "leg_order"
