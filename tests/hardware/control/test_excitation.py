"""The script that moves every joint: what it asks for, and that the deployer's checks and limits hold in it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from hardware.control.controller import Controller, Request, State
from hardware.control.excitation import AMPLITUDES, MOVE_S, RATE, TURN_S, Excitation
from hardware.control.limits import target_range
from hardware.control.settings import Settings, StandConfig
from hardware.estimation.kinematics import JointLimits
from hardware.robot_sim.lockstep import Lockstep
from hardware.robot_sim.rig import PlannedFault, Rig
from hardware.robot_sim.scenarios import get_scenario
from hardware.wire.readings import Joints
from symdyn.errors import InvalidValue
from symdyn.robot.legs import JOINTS, LEG_JOINTS
from tests.hardware.control.lockstep import shipped, until
from tests.hardware.robot_sim.simulated import go2
from tests.robots import GO2

LIMITS = JointLimits.of(GO2)
TIMES = np.arange(0.0, 130.0, 0.01)
QUICK = Settings(stand=StandConfig(rise_s=0.8, ramp_s=0.2, settle_s=0.2, wiggle_s=0.1), identify="hung")


@pytest.mark.parametrize("place", list(AMPLITUDES))
def test_it_begins_and_ends_in_the_stance_and_stays_within_every_range(place) -> None:
    excitation = Excitation(GO2, LIMITS, place)
    positions = np.array([excitation.positions(time) for time in TIMES])
    for time in (0.0, excitation.duration, 1000.0):
        np.testing.assert_allclose(excitation.positions(time), GO2.default_joint_pos, atol=1e-12)
    assert 110.0 < excitation.duration < 130.0
    assert (positions > LIMITS.lower).all()
    assert (positions < LIMITS.upper).all()
    # a function of time and of nothing else
    np.testing.assert_array_equal(positions[::-1], [excitation.positions(time) for time in TIMES[::-1]])


def test_in_a_joints_turn_only_its_leg_moves_and_it_moves_most() -> None:
    excitation = Excitation(GO2, LIMITS, "hung")
    for joint in range(len(JOINTS)):
        begin = MOVE_S + joint * TURN_S
        turn = np.array([excitation.positions(time) for time in begin + np.arange(0.0, TURN_S, 0.01)])
        assert excitation.joint(begin + 0.5) == joint
        width = np.ptp(turn, axis=0)
        leg = joint // len(LEG_JOINTS)
        moving = set(np.flatnonzero(width > 1e-9))
        assert moving <= set(range(3 * leg, 3 * leg + 3))
        assert int(np.argmax(width)) == joint
        assert width[joint] > 0.5


def test_a_place_that_is_none_is_refused() -> None:
    with pytest.raises(InvalidValue, match="'no', 'hung' or 'standing'"):
        Settings(identify="lying")  # type: ignore[arg-type]


def hung(fault: PlannedFault | None = None) -> Lockstep:
    rig = Rig(go2(start="hung"), get_scenario("identify"), fault)
    return Lockstep(Controller(shipped(), QUICK), rig)


def test_it_follows_the_stand_and_every_target_is_within_the_limits_and_slow_and_a_stop_damps() -> None:
    world = hung()
    until(world, State.IDENTIFY, 20.0)
    moments = world.run(4.0)
    assert {moment.tick.state for moment in moments} == {State.IDENTIFY}
    assert not any(moment.tick.ready or moment.tick.acted for moment in moments)
    for before, moment in pairwise(moments):
        assert moment.tick.targets is not None
        assert before.tick.targets is not None
        assert moment.inputs.joints is not None
        joints = Joints.of(moment.inputs.joints.message)
        targets = moment.tick.targets
        law = targets.kp * (targets.pos - joints.pos) - targets.kd * joints.vel
        assert (np.abs(law) <= LIMITS.torque + 1e-6).all()
        low, high = target_range(joints, LIMITS, QUICK.safety.target_lead)
        assert ((low <= targets.pos) & (targets.pos <= high)).all()
        speed = np.abs(targets.pos - before.tick.targets.pos) / (moment.time - before.time)
        assert (speed <= RATE * (1.0 + 1e-6)).all()
    assert np.ptp([moment.tick.targets.pos[0] for moment in moments if moment.tick.targets], axis=0) > 0.1
    world.requests |= Request.STOP
    assert world.run(0.05)[-1].tick.state is State.DAMP


@pytest.mark.parametrize("name", ["silent", "nan_joint"])
def test_a_fault_damps_there_as_anywhere(name) -> None:
    world = hung(PlannedFault(name, 0.5, "run"))
    until(world, State.IDENTIFY, 20.0)
    states = [moment.tick.state for moment in world.run(1.0)]
    assert states[-1] is State.DAMP
    assert world.rig.fault_began is not None
