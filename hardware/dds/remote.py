"""The 40 bytes of the remote control in a LowState.

Buttons are bits of bytes 2 and 3, sticks are floats from bytes 4, 8, 12 and 20 on, of left x, right x, right y and left
y; right and forward are positive (unitree_sdk2's xRockerBtnDataStruct, unitree_mujoco's bridge).
"""

from __future__ import annotations

import struct

from hardware.dds.types import REMOTE_BYTES
from hardware.wire.messages import rc_command_lcmt
from hardware.wire.readings import BUTTONS, SHOULDERS

_SHOULDER_BITS = {"R1": 0, "L1": 1, "R2": 4, "L2": 5}
_SHOULDER_BYTE, _BUTTON_BYTE = 2, 3
_STICKS = struct.Struct("<4xfff4xf16x")
assert _STICKS.size == REMOTE_BYTES


class Remote:
    """Makes the joystick message of the remote's bytes.

    The message says which button was pressed last; the remote, which are down. What is down from the start, before any
    other, counts as pressed.
    """

    def __init__(self) -> None:
        self._before = 0
        self._mode = 0

    def message(self, data: bytes) -> rc_command_lcmt:
        """Of 40 bytes."""
        message = rc_command_lcmt()
        left_x, right_x, right_y, left_y = _STICKS.unpack(data)
        message.left_stick, message.right_stick = [left_x, left_y], [right_x, right_y]
        for name, bit in _SHOULDER_BITS.items():
            setattr(message, SHOULDERS[name], data[_SHOULDER_BYTE] >> bit & 1)
        down = data[_BUTTON_BYTE]
        pressed = down & ~self._before
        self._before = down
        if pressed:
            self._mode = pressed.bit_length() - 1
        message.mode = self._mode
        return message


def remote_bytes(message: rc_command_lcmt) -> bytes:
    """The bytes of a remote whose button of ``message.mode`` is held down."""
    (left_x, left_y), (right_x, right_y) = message.left_stick, message.right_stick
    data = bytearray(_STICKS.pack(left_x, right_x, right_y, left_y))
    for name, bit in _SHOULDER_BITS.items():
        data[_SHOULDER_BYTE] |= bool(getattr(message, SHOULDERS[name])) << bit
    if 0 <= message.mode < len(BUTTONS):
        data[_BUTTON_BYTE] = 1 << message.mode
    return bytes(data)


def held(data: bytes, shoulder: str) -> bool:
    """Whether a button of SHOULDERS is down."""
    return bool(data[_SHOULDER_BYTE] >> _SHOULDER_BITS[shoulder] & 1)
