"""What the operator's display shows of the deployer: values that one process can send to another."""

from __future__ import annotations

from dataclasses import dataclass

from hardware.control.controller import Tick
from hardware.control.joystick import JoystickConfig


@dataclass(frozen=True)
class Timing:
    """Of the last seconds; s.

    Attributes:
        lateness: of ticks after their deadlines.
        compute: of a tick from waking to having sent.
        state_age: of the older of joints and IMU when it was used.
        overruns: ticks that began more than a tick late, since the start.
        realtime: what the operating system granted.
    """

    lateness: tuple[float, ...]
    compute: tuple[float, ...]
    state_age: tuple[float, ...]
    overruns: int
    realtime: str


@dataclass(frozen=True)
class Status:
    """Of one moment.

    Attributes:
        tick: the last, or None before the first.
        timing: of the last ticks.
        refused: messages of a wrong type or length, so far.
        log_failure: why the log is no longer written, or None.
    """

    tick: Tick | None
    timing: Timing
    refused: int
    log_failure: str | None


@dataclass(frozen=True)
class Controls:
    """What stays the same.

    Attributes:
        joystick: which button does what.
        keyboard: whether keys stand in for it.
        dry: whether nothing is sent.
    """

    joystick: JoystickConfig
    keyboard: bool = False
    dry: bool = False
