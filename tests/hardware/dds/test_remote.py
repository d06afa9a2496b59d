"""The remote's bytes as Unitree's simulator writes them, and back."""

from __future__ import annotations

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hardware.dds.remote import Remote, held, remote_bytes
from hardware.wire.messages import rc_command_lcmt
from hardware.wire.readings import BUTTONS, SHOULDERS, Joystick

# from the highest bit on, as unitree_mujoco's bridge strings them together
BYTE_2 = (None, None, "L2", "R2", "select", "start", "L1", "R1")
BYTE_3 = ("left", "down", "right", "up", "Y", "X", "B", "A")


def remote(*buttons: str, lx=0.0, rx=0.0, ry=0.0, ly=0.0) -> bytes:
    data = bytearray(40)
    for place, names in ((2, BYTE_2), (3, BYTE_3)):
        data[place] = int("".join(str(int(name in buttons)) for name in names), 2)
    for place, value in ((4, lx), (8, rx), (12, ry), (20, ly)):
        data[place : place + 4] = struct.pack("f", value)
    return bytes(data)


def read(its: Remote, data: bytes) -> Joystick:
    return Joystick.of(its.message(data))


@pytest.mark.parametrize("name", SHOULDERS)
def test_shoulders_are_held_while_they_are_down(name):
    its = Remote()
    assert read(its, remote(name)).held == {name}
    assert read(its, remote()).held == frozenset()
    assert held(remote(name), name) and not held(remote(), name)


def test_a_button_stays_the_last_one_pressed():
    its = Remote()
    assert read(its, remote()).button == "A"
    for name in BUTTONS:
        assert read(its, remote(name)).button == name
        assert read(its, remote()).button == name
    assert read(its, remote("X")).button == "X"
    assert read(its, remote("X", "up")).button == "up"
    assert read(its, remote("X")).button == "up"


def test_start_and_select_are_nothing():
    joystick = read(Remote(), remote("start", "select"))
    assert joystick.held == frozenset() and joystick.button == "A"


stick = st.floats(-1.0, 1.0, width=32)


@given(stick, stick, stick, stick)
def test_sticks(lx, rx, ry, ly):
    joystick = read(Remote(), remote(lx=lx, rx=rx, ry=ry, ly=ly))
    assert joystick.left == (lx, ly)
    assert joystick.right == (rx, ry)


@given(st.sets(st.sampled_from(sorted(SHOULDERS))), st.integers(0, 7), stick, stick)
def test_what_the_simulated_robot_writes_is_read(shoulders, mode, x, y):
    message = rc_command_lcmt()
    message.mode, message.left_stick, message.right_stick = mode, [x, y], [y, x]
    for name in shoulders:
        setattr(message, SHOULDERS[name], 1)
    assert read(Remote(), remote_bytes(message)) == Joystick.of(message)
    assert remote_bytes(message) == remote(*shoulders, BUTTONS[mode], lx=x, ly=y, rx=y, ry=x)
