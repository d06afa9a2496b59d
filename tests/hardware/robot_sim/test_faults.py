"""Each fault does what it says, from when it should until when it should, and nothing else."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pinocchio
import pytest

from hardware.robot_sim.effects import FOREIGN_SENDER
from hardware.robot_sim.faults import FAULTS, get_fault
from hardware.robot_sim.rig import FALLEN_HEIGHT, PlannedFault, Rig
from hardware.robot_sim.scenarios import get_scenario
from hardware.robot_sim.settings import PERIOD
from hardware.wire.channels import IMU, JOINTS, JOYSTICK, TARGETS, TRUTH, WrongMessage, decode
from hardware.wire.readings import Joints, Joystick, Targets
from hardware.wire.sdk_order import SDK_JOINTS
from symdyn.errors import InvalidValue, UnknownName
from symdyn.robot.legs import JOINTS as JOINT_NAMES
from symdyn.robot.legs import LEGS
from tests.hardware.robot_sim.simulated import go2
from tests.robots import GO2

BEGIN, END, TOTAL = 0.04, 0.1, 0.14  # s
FIRST, LAST = round(BEGIN / PERIOD), round(END / PERIOD) - 1  # the first and the last period with the fault
ROBOTS = {
    "joint_stuck",
    "motor_dead",
    "payload",
    "push",
    "slippery",
    "swapped_legs_both",
    "swapped_legs_command",
    "tilt",
}
"""Faults that change what the robot does, and so all that comes after."""


def rig_with(plan: PlannedFault | None, scenario: str = "idle") -> Rig:
    return Rig(go2(start="standing"), get_scenario(scenario), plan)


def told(rig: Rig, seconds: float, pos=None, kp: float = GO2.kp, kd: float = GO2.kd) -> list[list[tuple[str, bytes]]]:
    """What is published in each period by a robot that is told this at 50 Hz."""
    ones, periods = np.ones(12), []
    wanted = GO2.default_joint_pos if pos is None else pos
    for k in range(round(seconds / PERIOD)):
        now = 100.0 + k * PERIOD
        if k % 10 == 0:
            rig.receive(now, Targets(wanted, kp * ones, kd * ones).message(k, 1))
        periods.append(rig.tick(now))
    return periods


@cache
def healthy() -> list[list[tuple[str, bytes]]]:
    return told(rig_with(None), TOTAL)


def ill(name: str, **plan) -> list[list[tuple[str, bytes]]]:
    return told(rig_with(PlannedFault(name, at=BEGIN + PERIOD, lasts=END - BEGIN, **plan)), TOTAL)


def messages(periods, channel, first=FIRST, last=LAST):
    found = []
    for period in periods[first : last + 1]:
        found += [decode(channel, data) for name, data in period if name == channel]
    return found


def truly(channel, first=FIRST, last=LAST):
    return messages(healthy(), channel, first, last)


def test_the_healthy_robot_publishes_each_channel_at_its_rate():
    for k, period in enumerate(healthy()):
        assert [channel for channel, _ in period] == [JOINTS, IMU, JOYSTICK, *([TRUTH] if (k + 1) % 5 == 0 else [])]


@pytest.mark.parametrize("name", FAULTS)
def test_before_it_begins_and_after_its_end_all_is_as_without_it(name):
    periods = ill(name)
    assert periods[:FIRST] == healthy()[:FIRST]
    if name not in (
        "slippery",
        "swapped_legs_command",  # neither makes a difference to a robot that stands as symmetrically as this
        "wrong_crc",  # of what goes over DDS only
    ):
        assert periods[FIRST : LAST + 1] != healthy()[FIRST : LAST + 1]
    if name not in ROBOTS and name not in ("bridge_estop", "second_deployer"):
        assert periods[LAST + 1 :] == healthy()[LAST + 1 :]


def test_only_the_last_word_of_a_low_state_is_wrong_if_its_checksum_is():
    rig, said = rig_with(PlannedFault("wrong_crc", at=BEGIN + PERIOD, lasts=END - BEGIN)), bytes(range(64))
    damaged = []
    for _ in range(round(TOTAL / PERIOD)):
        rig.tick(0.0)
        damaged.append(rig.damaged(said))
    for k, data in enumerate(damaged):
        assert data[:-4] == said[:-4]
        assert (data != said) == (FIRST <= k <= LAST)


@pytest.mark.parametrize("name", FAULTS)
def test_each_has_a_line_of_help(name):
    assert 10 < len(FAULTS[name].help) < 90


class TestSilence:
    @pytest.mark.parametrize(
        ("name", "gone"),
        [
            ("silent", {JOINTS, IMU, JOYSTICK}), ("silent_state", {JOINTS, IMU}), ("silent_joints", {JOINTS}),
            ("silent_imu", {IMU}), ("silent_joystick", {JOYSTICK}),
        ],
    )  # fmt: skip
    def test_just_these_channels_are_silent(self, name, gone):
        left = {channel for period in ill(name)[FIRST : LAST + 1] for channel, _ in period}
        assert left == {JOINTS, IMU, JOYSTICK, TRUTH} - gone

    def test_dropouts_lose_their_share(self):
        periods = told(rig_with(PlannedFault("dropouts", at=0.0, size=0.3)), 1.0)
        for channel in (JOINTS, IMU, JOYSTICK):
            assert len(messages(periods, channel, 0, 500)) / 500 == pytest.approx(0.7, abs=4 * math.sqrt(0.21 / 500))

    def test_late_messages_are_the_old_ones(self):
        got = [message.encode() for message in messages(ill("late", size=10.0), JOINTS)]
        assert got == [message.encode() for message in truly(JOINTS, FIRST, LAST - 5)]

    def test_frozen_messages_repeat_while_the_joystick_lives(self):
        for channel in (JOINTS, IMU):
            got = {message.encode() for message in messages(ill("frozen"), channel)}
            assert got == {truly(channel)[0].encode()}
        assert len(messages(ill("frozen"), JOYSTICK)) == LAST - FIRST + 1


class TestNumbers:
    @pytest.mark.parametrize(
        ("name", "field", "value"),
        [
            ("nan_joint", "q", math.nan), ("inf_velocity", "qd", math.inf), ("joint_velocity_spike", "qd", 80.0),
            ("torque_spike", "tau_est", 90.0), ("joint_out_of_range", "q", -0.83776 + 0.5),
        ],
    )  # fmt: skip
    def test_one_number_of_one_joint_is_wrong(self, name, field, value):
        calf = SDK_JOINTS.index("FR_calf_joint")
        for got, true in zip(messages(ill(name), JOINTS), truly(JOINTS), strict=True):
            wrong = getattr(got, field)[calf]
            assert wrong == pytest.approx(value, abs=1e-5, nan_ok=True)
            values = list(getattr(got, field))
            values[calf] = getattr(true, field)[calf]
            setattr(got, field, values)
            assert got.encode() == true.encode()

    @pytest.mark.parametrize(("name", "length"), [("quat_zero", 0.0), ("quat_not_unit", 1.1), ("nan_quat", math.nan)])
    def test_the_quaternion_is_of_another_length(self, name, length):
        for got in messages(ill(name), IMU):
            assert np.linalg.norm(got.quat) == pytest.approx(length, abs=1e-5, nan_ok=True)

    def test_the_quaternion_turns_back_what_the_true_one_turns(self):
        for got, true in zip(messages(ill("quat_inverse"), IMU), truly(IMU), strict=True):
            there, back = (pinocchio.Quaternion(*message.quat).normalized() for message in (true, got))
            assert (there * back).toRotationMatrix() == pytest.approx(np.eye(3), abs=1e-6)
            assert got.quat != true.quat

    def test_sticks_at_nan(self):
        assert all(not Joystick.of(message).finite() for message in messages(ill("nan_stick"), JOYSTICK))


def swap(values: np.ndarray, *pairs: tuple[str, str]) -> np.ndarray:
    """In symdyn's order, joints by name."""
    image = values.copy()
    for a, b in pairs:
        i, j = JOINT_NAMES.index(a), JOINT_NAMES.index(b)
        image[[i, j]] = values[[j, i]]
    return image


class TestOrder:
    FRONT = tuple((f"LF_{joint}", f"RF_{joint}") for joint in ("hip", "thigh", "calf"))

    @pytest.mark.parametrize(
        ("name", "pairs"),
        [
            ("swapped_legs_state", FRONT),
            ("swapped_legs_both", FRONT),
            ("swapped_joints_state", (("LH_thigh", "LH_calf"),)),
            ("swapped_hips_state", (("LF_hip", "LH_hip"), ("RF_hip", "RH_hip"))),
        ],
    )
    def test_joints_are_reported_for_each_other(self, name, pairs):
        for got, true in zip(messages(ill(name), JOINTS), truly(JOINTS), strict=True):
            for field in ("pos", "vel", "torque"):
                there = getattr(Joints.of(true), field)
                assert np.array_equal(getattr(Joints.of(got), field), swap(there, *pairs))
                assert not np.array_equal(there, swap(there, *pairs))

    def test_a_hip_is_reported_with_the_other_sign(self):
        sign = np.ones(12)
        sign[JOINT_NAMES.index("LF_hip")] = -1.0
        for got, true in zip(messages(ill("sign_flipped"), JOINTS), truly(JOINTS), strict=True):
            for field in ("pos", "vel", "torque"):
                assert np.array_equal(getattr(Joints.of(got), field), sign * getattr(Joints.of(true), field))

    @pytest.mark.parametrize("name", ["swapped_legs_command", "swapped_legs_both"])
    def test_front_legs_get_each_others_targets(self, name):
        wanted = GO2.default_joint_pos.copy()
        wanted[JOINT_NAMES.index("LF_hip")] += 0.3
        wanted[JOINT_NAMES.index("RF_hip")] += 0.1
        rig = Rig(go2(start="hung"), get_scenario("idle"), PlannedFault(name, at=0.0))
        told(rig, 0.02, wanted)
        told(rig, 2.0, wanted, kp=60.0, kd=3.0)
        assert Joints.of(rig.robot.joints()).pos == pytest.approx(swap(wanted, *self.FRONT), abs=0.05)


class TestOthers:
    def test_stray_bytes_are_none_of_the_channels_messages(self):
        stray = 0
        for period, true in zip(ill("wrong_type")[FIRST : LAST + 1], healthy()[FIRST : LAST + 1], strict=True):
            assert period[: len(true) - (len(true) == 4)] == true[:3]
            for channel, data in period:
                try:
                    decode(channel, data)
                except WrongMessage:
                    stray += 1
        assert stray >= 4 * 2

    def test_the_second_deployer_sends_sound_targets_at_50_hz(self):
        periods = told(rig_with(PlannedFault("second_deployer", at=0.0)), 0.5)
        got = messages(periods, TARGETS, 0, 250)
        assert len(got) == pytest.approx(25, abs=1)
        assert {message.robot_id for message in got} == {FOREIGN_SENDER}
        assert [message.id for message in got] == list(range(1, len(got) + 1))

    def test_the_operators_stop_is_held(self):
        assert all("L2" in Joystick.of(message).held for message in messages(ill("joystick_estop"), JOYSTICK))
        assert not any(Joystick.of(message).held for message in truly(JOYSTICK))

    def test_the_bridges_stop_leaves_motors_with_what_they_had(self):
        rig = rig_with(PlannedFault("bridge_estop", at=0.1))
        told(rig, 0.2)
        assert rig.robot.bridge_stopped
        told(rig, 1.0, kp=0.0, kd=4.0)
        assert rig.robot.height > 0.3


class TestRobot:
    """The robot itself is worse off than one without the fault."""

    def test_a_torque_rolls_it_over_and_the_bridge_stops(self):
        rig = rig_with(PlannedFault("tilt", at=0.1))
        told(rig, 1.5)
        assert rig.max_tilt > 1.0
        assert rig.robot.bridge_stopped
        assert rig.fell_at is not None and rig.robot.height < FALLEN_HEIGHT
        assert not rig.robot.wrench_w.any()

    def test_a_push_is_a_sudden_velocity_and_happens_once(self):
        rig, calm = rig_with(PlannedFault("push", at=0.1, size=0.5)), rig_with(None)
        for one in (rig, calm):
            told(one, 0.1)
        assert np.array(rig.robot.truth().vWorld) - calm.robot.truth().vWorld == pytest.approx(
            [0.0, 0.5, 0.0], abs=1e-6
        )
        pushed = rig.robot.data.qvel.copy()
        for one in (rig, calm):
            told(one, 0.01)
        assert rig.robot.data.qvel[1] < pushed[1], "the floor holds it, and nobody pushes again"

    def test_a_payload_weighs_and_is_taken_off_again(self):
        rig, calm = rig_with(PlannedFault("payload", at=0.0, lasts=2.0)), rig_with(None)
        mass = calm.robot.model.body_mass.sum()
        told(rig, 1.9)
        told(calm, 1.9)
        assert rig.robot.model.body_mass.sum() == pytest.approx(mass + 4.0)
        loads = [[one.robot.data.sensor(f"{leg}_force_w").data[2] for leg in LEGS] for one in (rig, calm)]
        assert abs(np.sum(loads[0]) - np.sum(loads[1])) / 9.81 == pytest.approx(4.0, abs=0.3)
        told(rig, 0.2)
        assert rig.robot.model.body_mass.sum() == pytest.approx(mass)

    def test_on_a_slippery_floor_a_push_carries_further(self):
        moved = []
        for plan in (None, PlannedFault("slippery", at=0.0, size=0.05)):
            rig = rig_with(plan)
            told(rig, 0.1)
            rig.robot.kick(np.array([1.0, 0.0, 0.0]))
            told(rig, 0.2)
            feet = [rig.robot.data.site(f"{leg}_foot").xpos[0] for leg in LEGS]
            moved.append(np.mean(feet))
        assert moved[1] - moved[0] > 0.03

    @pytest.mark.parametrize("name", ["joint_stuck", "motor_dead"])
    def test_a_joint_that_does_not_obey(self, name):
        off = []
        for plan in (None, PlannedFault(name, at=0.0)):
            rig = Rig(go2(start="hung"), get_scenario("idle"), plan)
            told(rig, 0.02)
            wanted = Joints.of(rig.robot.joints()).pos
            wanted[JOINT_NAMES.index("LF_thigh")] += 0.5
            told(rig, 2.0, wanted, kp=60.0, kd=3.0)
            off.append(np.abs(Joints.of(rig.robot.joints()).pos - wanted)[JOINT_NAMES.index("LF_thigh")])
        assert off[0] < 0.05
        assert off[1] > 0.3


class TestWhen:
    @pytest.mark.parametrize(("since", "kp", "kd"), [("stand", 60.0, 3.0), ("run", GO2.kp, GO2.kd)])
    def test_it_counts_from_the_first_targets_of_stand_or_run(self, since, kp, kd):
        rig = rig_with(PlannedFault("silent", at=0.05, since=since))
        told(rig, 0.1, kp=0.0, kd=4.0)
        assert rig.fault_began is None
        told(rig, 0.048, kp=kp, kd=kd)
        assert rig.fault_began is None
        told(rig, PERIOD, kp=kp, kd=kd)
        assert rig.fault_began is not None
        assert rig.robot.time == pytest.approx(0.15)

    def test_the_reaction_is_the_first_damping_after_it(self):
        rig = rig_with(PlannedFault("silent", at=0.05))
        ones = np.ones(12)
        for k in range(100):
            now = 50.0 + k * PERIOD
            kp, kd = (0.0, 4.0) if k < 5 or k >= 60 else (30.0, 0.65)
            rig.receive(now, Targets(GO2.default_joint_pos, kp * ones, kd * ones).message(k, 1))
            rig.tick(now)
        assert rig.fault_began == pytest.approx(50.05, abs=PERIOD)
        assert rig.damping_after_fault == pytest.approx(50.12)

    def test_bad_plans_are_refused_by_name(self):
        with pytest.raises(UnknownName, match="silent_imu"):
            get_fault("silent_imus")
        with pytest.raises(UnknownName):
            PlannedFault("gremlins")
        for field, value, flag in (
            ("at", -1.0, "--fault-at"), ("at", math.nan, "--fault-at"), ("lasts", 0.0, "--fault-for"),
            ("lasts", math.nan, "--fault-for"), ("size", math.inf, "--fault-size"),
        ):  # fmt: skip
            with pytest.raises(InvalidValue, match=flag):
                PlannedFault("silent", **{field: value})
