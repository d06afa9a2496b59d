"""The bytes on the wire: those that bridges of others already speak, and nothing else taken or sent."""

from __future__ import annotations

import filecmp
import math
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hardware.wire.messages
from hardware.wire import channels, messages
from hardware.wire.channels import IMU, JOINTS, JOYSTICK, MESSAGES, SESSION, TARGETS, TICK, TRUTH, WrongMessage
from hardware.wire.messages import leg_control_data_lcmt, pd_tau_targets_lcmt, rc_command_lcmt, state_estimator_lcmt
from hardware.wire.readings import BUTTONS, SHOULDERS, Imu, Joints, Joystick, Targets

# of the bridge of walk-these-ways-go2: type, packed fingerprint, encoded bytes
GOLDEN = [
    (leg_control_data_lcmt, "5352516a697f890f", 272),
    (pd_tau_targets_lcmt, "db10251de2523982", 544),
    (rc_command_lcmt, "8ee4d605d87cfbc5", 46),
    (state_estimator_lcmt, "d50f90505dffcb6d", 160),
]
FOLDER = Path(hardware.wire.messages.__file__).parent

floats32 = st.floats(width=32, allow_nan=False, allow_infinity=False)
floats64 = st.floats(allow_nan=False, allow_infinity=False)


def vectors(numbers, size):
    return st.lists(numbers, min_size=size, max_size=size)


@pytest.mark.parametrize(("kind", "fingerprint", "size"), GOLDEN)
def test_fingerprint_and_size_are_those_that_bridges_speak(kind, fingerprint, size):
    data = kind().encode()
    assert data[:8].hex() == fingerprint
    assert len(data) == size


def test_joints_are_written_as_the_format_says():
    message = leg_control_data_lcmt()
    message.q = [0.25 * i for i in range(12)]
    message.qd = [-1.5 * i for i in range(12)]
    message.tau_est = [2.0 * i for i in range(12)]
    zeros = [0.0] * 12
    by_hand = bytes.fromhex("5352516a697f890f") + struct.pack(
        ">60f3q", *message.q, *message.qd, *zeros, *zeros, *message.tau_est, 0, 0, 0
    )
    assert channels.encode(JOINTS, message) == by_hand


def test_targets_are_written_as_the_format_says():
    message = pd_tau_targets_lcmt()
    message.q_des, message.kp, message.kd = [0.1 * i for i in range(12)], [30.0] * 12, [0.65] * 12
    message.id, message.robot_id = 12, 34
    zeros = [0.0] * 12
    by_hand = bytes.fromhex("db10251de2523982") + struct.pack(
        ">60d3q4d", *message.q_des, *zeros, *zeros, *message.kp, *message.kd, 0, 12, 34, *zeros[:4]
    )
    assert channels.encode(TARGETS, message) == by_hand


def test_the_joystick_is_written_as_the_format_says():
    message = rc_command_lcmt()
    message.mode, message.left_stick, message.right_stick = 5, [0.5, -1.0], [0.25, 1.0]
    message.left_upper_switch, message.left_lower_left_switch = 1, 2
    message.right_upper_switch, message.right_lower_right_switch = 4, 6
    by_hand = bytes.fromhex("8ee4d605d87cfbc5") + struct.pack(">h6f6h", 5, 0.5, -1.0, 0.25, 1.0, 0, 0, 1, 2, 0, 4, 0, 6)
    assert channels.encode(JOYSTICK, message) == by_hand


def test_the_imu_is_written_as_the_format_says():
    message = state_estimator_lcmt()
    message.rpy, message.omegaBody = [0.1, 0.2, 0.3], [1.0, 2.0, 3.0]
    message.quat, message.contact_estimate, message.aBody = [1.0, 0.0, 0.0, 0.0], [20.0, 30.0, 40.0, 50.0], [0, 0, 9.81]
    nine = [0.0] * 9
    by_hand = bytes.fromhex("d50f90505dffcb6d") + struct.pack(
        ">32f3q",
        *[*nine, 0.1, 0.2, 0.3, 1.0, 2.0, 3.0, *nine[:3], 1.0, 0.0, 0.0, 0.0, 20.0, 30.0, 40.0, 50.0, 0.0, 0.0, 9.81],
        *[0.0, 0.0, 0.0, 0, 0, 0],
    )
    assert channels.encode(IMU, message) == by_hand


def test_the_committed_classes_are_what_lcm_gen_makes(tmp_path):
    lcm_gen = Path(sys.executable).parent / "lcm-gen"
    sources = sorted(FOLDER.glob("*.lcm"))
    subprocess.run([lcm_gen, "-p", "--ppath", tmp_path, *sources], check=True)
    made = tmp_path / "hardware" / "wire" / "messages"
    names = [source.with_suffix(".py").name for source in sources]
    assert len(names) >= len(GOLDEN)
    assert filecmp.cmpfiles(made, FOLDER, names, shallow=False) == (names, [], [])
    # its __init__ lists the types in an order of its own
    lines = [sorted((folder / "__init__.py").read_text().splitlines()) for folder in (made, FOLDER)]
    assert lines[0] == lines[1]


@pytest.mark.parametrize("channel", MESSAGES)
def test_what_is_sent_is_what_is_received(channel):
    message = MESSAGES[channel]()
    data = channels.encode(channel, message)
    assert channels.encode(channel, channels.decode(channel, data)) == data


@given(st.data())
def test_targets_survive_the_wire_in_every_bit(data):
    pos, kp, kd = (np.array(data.draw(vectors(floats64, 12))) for _ in range(3))
    number, sender = (data.draw(st.integers(-(2**63), 2**63 - 1)) for _ in range(2))
    message = Targets(pos, kp, kd).message(number, sender)
    received = channels.decode(TARGETS, channels.encode(TARGETS, message))
    again = Targets.of(received)
    assert np.array_equal(again.pos, pos)
    assert np.array_equal(again.kp, kp)
    assert np.array_equal(again.kd, kd)
    assert (received.id, received.robot_id) == (number, sender)
    # what the bridge would add to kp (q_des - q) - kd qd
    assert not any(received.qd_des) and not any(received.tau_ff)


@given(vectors(floats32, 12), vectors(floats32, 12), vectors(floats32, 12))
def test_joints_survive_the_wire_in_every_bit_of_a_float32(q, qd, torque):
    message = leg_control_data_lcmt()
    message.q, message.qd, message.tau_est = q, qd, torque
    joints = Joints.of(channels.decode(JOINTS, channels.encode(JOINTS, message)))
    assert sorted(joints.pos) == sorted(q) and sorted(joints.vel) == sorted(qd)
    assert sorted(joints.torque) == sorted(torque)
    assert joints.finite()


@given(
    st.integers(0, len(BUTTONS) - 1),
    st.sets(st.sampled_from(sorted(SHOULDERS))),
    vectors(floats32, 2),
    vectors(floats32, 2),
)
def test_the_joystick_survives_the_wire(mode, held, left, right):
    message = rc_command_lcmt()
    message.mode, message.left_stick, message.right_stick = mode, left, right
    for name in held:
        setattr(message, SHOULDERS[name], 1)
    joystick = Joystick.of(channels.decode(JOYSTICK, channels.encode(JOYSTICK, message)))
    assert joystick.button == BUTTONS[mode]
    assert joystick.held == held
    assert (list(joystick.left), list(joystick.right)) == (left, right)


@pytest.mark.parametrize("mode", [-1, 8, 32767])
def test_a_latched_button_that_is_none_counts_as_the_first(mode):
    message = rc_command_lcmt()
    message.mode = mode
    assert Joystick.of(message).button == "A"


@pytest.mark.parametrize("field", ["quat", "omegaBody", "aBody", "contact_estimate"])
def test_an_imu_message_with_a_nan_arrives_and_says_that_it_is_not_finite(field):
    message = state_estimator_lcmt()
    getattr(message, field)[1] = math.nan
    assert not Imu.of(channels.decode(IMU, message.encode())).finite()
    assert Imu.of(channels.decode(IMU, state_estimator_lcmt().encode())).finite()


@pytest.mark.parametrize("field", ["q", "qd", "tau_est"])
def test_a_joint_message_with_an_infinity_arrives_and_says_that_it_is_not_finite(field):
    message = leg_control_data_lcmt()
    getattr(message, field)[11] = -math.inf
    assert not Joints.of(channels.decode(JOINTS, message.encode())).finite()


def test_sticks_at_nan_say_that_they_are_not_finite():
    message = rc_command_lcmt()
    message.right_stick = [0.0, math.nan]
    assert not Joystick.of(message).finite()


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, np.float32("nan")])
@pytest.mark.parametrize("field", ["q_des", "qd_des", "tau_ff", "kp", "kd", "se_contactState"])
def test_targets_that_are_not_finite_are_never_sent(field, value):
    message = pd_tau_targets_lcmt()
    getattr(message, field)[3] = value
    with pytest.raises(WrongMessage, match=f"{field}.*finite"):
        channels.encode(TARGETS, message)


@pytest.mark.parametrize("size", [0, 11, 13, 24])
def test_an_array_of_a_wrong_length_is_never_sent(size):
    message = pd_tau_targets_lcmt()
    message.kp = [30.0] * size
    with pytest.raises(WrongMessage, match=rf"kp .* {size} numbers, but must have 12"):
        channels.encode(TARGETS, message)


@pytest.mark.parametrize(
    ("channel", "field", "value"),
    [
        (TARGETS, "q_des", 1.0),
        (TARGETS, "q_des", None),
        (TARGETS, "q_des", np.zeros(12)),
        (TARGETS, "q_des", ["0.1"] * 12),
        (TARGETS, "id", [1]),
        (TARGETS, "id", 2**63),
        (TARGETS, "id", 1.5),
        (JOYSTICK, "mode", 70000),
        (JOINTS, "q", [1e300] * 12),
    ],
)  # fmt: skip
def test_a_field_that_holds_something_else_is_refused_and_not_an_accident(channel, field, value):
    message = MESSAGES[channel]()
    setattr(message, field, value)
    with pytest.raises(WrongMessage):
        channels.encode(channel, message)


def test_a_message_is_sent_on_its_own_channel_only():
    with pytest.raises(WrongMessage, match="rc_command_lcmt"):
        channels.encode(TARGETS, rc_command_lcmt())
    with pytest.raises(WrongMessage, match="elsewhere"):
        channels.encode("elsewhere", rc_command_lcmt())


@pytest.mark.parametrize("channel", MESSAGES)
def test_bytes_of_another_type_are_refused(channel):
    for kind in MESSAGES.values():
        if kind is not MESSAGES[channel]:
            with pytest.raises(WrongMessage, match="fingerprint"):
                channels.decode(channel, kind().encode())
    with pytest.raises(WrongMessage, match="elsewhere"):
        channels.decode("elsewhere", MESSAGES[channel]().encode())


@pytest.mark.parametrize("channel", MESSAGES)
def test_bytes_that_are_cut_or_have_a_tail_are_refused(channel):
    data = MESSAGES[channel]().encode()
    for length in range(len(data)):
        with pytest.raises(WrongMessage):
            channels.decode(channel, data[:length])
    with pytest.raises(WrongMessage, match=rf"has {len(data) + 1} bytes"):
        channels.decode(channel, data + b"\0")


@given(st.binary(max_size=700), st.sampled_from(sorted(MESSAGES)))
def test_any_bytes_are_a_message_or_refused(noise, channel):
    fingerprint = MESSAGES[channel]().encode()[:8]
    for data in (noise, fingerprint + noise):
        try:
            message = channels.decode(channel, data)
        except WrongMessage:
            continue
        assert len(message.encode()) == len(data)


def test_the_robots_channels_are_the_bridges():
    assert (JOINTS, IMU, JOYSTICK, TARGETS) == (
        "leg_control_data", "state_estimator_data", "rc_command", "pd_plustau_targets",
    )  # fmt: skip
    assert MESSAGES[TRUTH] is MESSAGES[IMU]
    own = {JOINTS, IMU, JOYSTICK, TARGETS, TRUTH, TICK, SESSION}
    assert set(MESSAGES) == own
    assert {kind.__name__ for kind in MESSAGES.values()} <= set(dir(messages))
