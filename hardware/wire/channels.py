"""Which channel carries which message, and messages that are what they should be or are refused."""

from __future__ import annotations

import math
from io import BytesIO
from typing import Any

from hardware.wire.messages import (
    controller_tick_lcmt,
    leg_control_data_lcmt,
    pd_tau_targets_lcmt,
    rc_command_lcmt,
    session_info_lcmt,
    state_estimator_lcmt,
)
from symdyn.errors import SymdynError

JOINTS = "leg_control_data"
"""From the robot: positions, velocities and torques of the joints."""

IMU = "state_estimator_data"
"""From the robot: orientation, angular velocity, acceleration, foot force."""

JOYSTICK = "rc_command"
"""From the robot: its wireless controller."""

TARGETS = "pd_plustau_targets"
"""To the robot: what each motor shall do."""

TRUTH = "symdyn_truth"
"""From the simulated robot only: position, velocities and contacts as they are, legs in the order of the wire."""

TICK = "symdyn_tick"
"""In logs only: what the deployer did in a tick."""

SESSION = "symdyn_session"
"""In logs only, first: what ran."""

SELF_TEST = "LCM_SELF_TEST"
"""Of lcm itself, which hears itself on it when it opens a socket."""

MESSAGES: dict[str, type] = {
    JOINTS: leg_control_data_lcmt,
    IMU: state_estimator_lcmt,
    JOYSTICK: rc_command_lcmt,
    TARGETS: pd_tau_targets_lcmt,
    TRUTH: state_estimator_lcmt,
    TICK: controller_tick_lcmt,
    SESSION: session_info_lcmt,
}
"""Type by channel. Channels and types are those of the bridge of walk-these-ways-go2, but for those of symdyn."""

FROM_ROBOT = (JOINTS, IMU, JOYSTICK)


class WrongMessage(SymdynError):
    """Bytes that are no message of their channel's type, or a message with a field of a wrong length or type."""


def decode(channel: str, data: bytes) -> Any:
    """The message that a channel's bytes hold.

    Numbers that are not finite pass: what a NaN means is for the controller's safety to say.

    Raises:
        WrongMessage: if the channel has no type here, or the bytes are of another type or length.
    """
    kind = MESSAGES.get(channel)
    if kind is None:
        raise WrongMessage(f"There is no message type for channel {channel!r}; known: {', '.join(MESSAGES)}.")
    if data[:8] != kind._get_packed_fingerprint():  # type: ignore[attr-defined]
        raise WrongMessage(f"A message on {channel} is no {kind.__name__}: its fingerprint is {data[:8].hex()}.")
    stream = BytesIO(data)
    try:
        message = kind.decode(stream)  # type: ignore[attr-defined]
        # a string that is cut short is read without complaint
        length = len(message.encode()) if "string" in kind.__typenames__ else stream.tell()  # type: ignore[attr-defined]
    except Exception as error:  # generated code raises whatever struct, utf-8 or indexing raise
        raise WrongMessage(f"A message on {channel} of {len(data)} bytes cannot be read ({error}).") from error
    if length != len(data):
        raise WrongMessage(f"A message on {channel} has {len(data)} bytes, but a {kind.__name__} has {length}.")
    return message


def encode(channel: str, message: Any) -> bytes:
    """The bytes of a message that is about to be sent.

    lcm's own encoder cuts a field that is too long, and sends NaN.

    Raises:
        WrongMessage: if the message is of another type than its channel's, an array has a wrong length, or a number is
            not finite or too large for its field.
    """
    kind = MESSAGES.get(channel)
    if kind is None or type(message) is not kind:
        raise WrongMessage(f"A {type(message).__name__} was to be sent on {channel!r}.")
    for field, size in zip(kind.__slots__, kind.__dimensions__, strict=True):  # type: ignore[attr-defined]
        value = getattr(message, field)
        if isinstance(value, list | tuple) != (size is not None):
            raise WrongMessage(f"{field} of a {kind.__name__} is {value!r}, but must be {_shape(size)}.")
        if size is not None and len(value) != size[0]:
            raise WrongMessage(f"{field} of a {kind.__name__} has {len(value)} numbers, but must have {size[0]}.")
        if not all(map(_finite, value if size is not None else (value,))):
            raise WrongMessage(f"{field} of a {kind.__name__} holds {value!r}, but must be finite.")
    try:
        return message.encode()
    except Exception as error:  # generated code raises whatever struct and utf-8 raise
        raise WrongMessage(f"A {kind.__name__} cannot be written ({error}).") from error


def _shape(size: list[int] | None) -> str:
    return "one value" if size is None else f"a list of {size[0]}"


def _finite(value: Any) -> bool:
    try:
        return math.isfinite(value)
    except (TypeError, OverflowError):
        return True  # no number, or too large a one: the encoder refuses it


DEFAULT_URL = "udpm://239.255.76.67:7667?ttl=0"
"""LCM's own default: this host only. For a bridge on another computer: ttl=1."""
