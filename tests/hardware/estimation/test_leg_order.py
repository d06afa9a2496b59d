"""Whether legs are taken for each other: against a trunk that is turned above feet that stay where they are, and
against the simulated robot, whose legs are exchanged on the wire."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from scipy.optimize import root

from hardware.control.controller import State
from hardware.control.settings import Settings, StandConfig
from hardware.estimation.kinematics import LegKinematics
from hardware.estimation.leg_order import ORDERS, LegOrder
from hardware.robot_sim.rig import Rig
from hardware.wire.readings import Imu, Joints
from hardware.wire.sdk_order import SDK_LEGS, UNITREE_LEGS
from symdyn.robot.legs import LEGS
from tests.hardware.control.lockstep import before, until
from tests.robots import GO2

KINEMATICS = LegKinematics(GO2)
STANCE = np.array(GO2.default_joint_pos)
FEET_W = KINEMATICS.feet(STANCE).centre_b
SOON = Settings(stand=StandConfig(rise_s=0.8, ramp_s=0.2, settle_s=0.3))
AS_TAKEN = tuple(range(len(LEGS)))
OTHERS = [order for order in ORDERS if order != AS_TAKEN]


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


def best(order: LegOrder) -> tuple[int, ...]:
    return ORDERS[int(np.argmax(order.explained()))]


class TestExplained:
    def test_a_trunk_above_its_feet_tilts_as_its_legs_say(self) -> None:
        order = LegOrder(KINEMATICS, STANCE)
        for leg in LEGS:
            for joints, imu in MOMENTS:
                order.observe(leg, joints, imu)
        assert best(order) == AS_TAKEN
        assert order.explained().max() > 0.98  # but for what is not linear
        assert order.other(0.25) is None

    @pytest.mark.parametrize("true", ORDERS)
    def test_legs_that_are_taken_for_others_are_named(self, true: tuple[int, ...]) -> None:
        order = LegOrder(KINEMATICS, STANCE)
        for joints, imu in MOMENTS:
            rows = np.zeros((4, 3))
            for corner, taken in enumerate(true):
                rows[taken] = joints.pos.reshape(4, 3)[corner]
            order.observe("LF", Joints(rows.ravel(), joints.vel, joints.torque), imu)
        assert best(order) == true
        assert (order.other(0.25) is None) == (true == AS_TAKEN)

    def test_a_trunk_that_does_not_move_is_explained_by_no_order(self) -> None:
        order = LegOrder(KINEMATICS, STANCE)
        noise = np.random.default_rng(1).normal(0.0, 0.002, (len(MOMENTS), 2))
        for (joints, _), (x, y) in zip(MOMENTS, noise, strict=True):
            order.observe("RH", joints, Imu(np.array([1.0, x, y, 0.0]), np.zeros(3), np.zeros(3), np.zeros(4)))
        assert (order.explained() < 0.0).all()
        assert order.other(0.25) is None

    def test_nothing_seen_is_nothing_found(self) -> None:
        assert not LegOrder(KINEMATICS, STANCE).explained().any()
        assert LegOrder(KINEMATICS, STANCE).other(0.25) is None


def exchange(rig: Rig, order: tuple[int, ...]) -> None:
    """Put the wire's legs of a robot in another order, in what it says and in what it is told alike."""
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


@pytest.mark.parametrize("order", OTHERS, ids=lambda order: "-".join(SDK_LEGS[leg] for leg in order))
def test_no_other_order_of_the_legs_passes_the_stand(order: tuple[int, ...]) -> None:
    its = before(State.STAND, SOON)  # until then nothing is told
    exchange(its.rig, order)
    until(its, State.STAND, 2.0)
    until(its, State.DAMP, 5.0)
    assert its.controller.fault is not None
    assert its.controller.fault.name == "leg_order"
    paper = dict(zip(UNITREE_LEGS.values(), UNITREE_LEGS, strict=True))
    for taken, leg in zip(SDK_LEGS, (SDK_LEGS[true] for true in order), strict=True):
        assert (f"{paper[taken]} is {paper[leg]}" in its.controller.fault.detail) == (taken != leg)
