"""The person at the joystick: follows a script, waits for what a person would wait for, lets go when it goes wrong."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from hardware.control.joystick import JoystickConfig
from hardware.robot_sim.target_monitor import Mode
from hardware.wire.messages import rc_command_lcmt
from hardware.wire.readings import BUTTONS, SHOULDERS

PRESSED_S = 0.2
"""How long a finger stays on a button."""

AGAIN_S = 1.0
"""After which a button that had no effect is pressed once more."""

STICK_AT_REST = (0.013, -0.008)
"""Springs do not centre a stick exactly; well within the deployer's dead zone."""


@dataclass(frozen=True)
class Seen:
    """What a person beside the robot sees.

    Attributes:
        time: s.
        height: of the trunk, m.
        speed: of the trunk, m/s.
        mode: what the robot is told to do.
    """

    time: float
    height: float
    speed: float
    mode: Mode


@dataclass(frozen=True)
class Step:
    """One thing to do.

    Attributes:
        says: in words.
        hold_s: how long, after ``until`` has come true, s.
        until: what must be seen before the next step, or None.
        still_s: how long ``until`` must be seen without a break, s.
        shoulder: button of SHOULDERS, pressed at the beginning, and again and again until ``until`` is true.
        button: of BUTTONS, pressed once, or None.
        speed: to ask for with the left stick, m/s.
        upright: whether the motors should hold the robot up; if they are damped or limp, the person lets go.
    """

    says: str
    hold_s: float = 0.0
    until: Callable[[Seen], bool] | None = None
    still_s: float = 0.0
    shoulder: str | None = None
    button: str | None = None
    speed: float = 0.0
    upright: bool = False


class JoystickOperator:
    """Goes through steps.

    Args:
        steps: in order; the last one lasts for ever if its ``hold_s`` is infinite.
        config: what the sticks mean.

    Attributes:
        doing: in words.
        done: whether all steps are.
        let_go: when the person let go because the motors ceased to hold the robot, s, or None.
    """

    def __init__(self, steps: tuple[Step, ...], config: JoystickConfig | None = None) -> None:
        self._steps = steps
        self._config = JoystickConfig() if config is None else config
        self._index = 0
        self._true_since = self._met_at = self._pressed_at = math.nan
        self._button = BUTTONS[0]
        self.doing = "watches"
        self.done = not steps
        self.let_go: float | None = None

    @property
    def has_an_end(self) -> bool:
        """Whether the script has one; otherwise somebody has to end it."""
        return bool(self._steps) and math.isfinite(self._steps[-1].hold_s)

    def message(self, seen: Seen) -> rc_command_lcmt:
        """What the joystick says now; to be called at every message."""
        while not self.done and self.let_go is None and self._passed(seen):
            self._index += 1
            self._true_since = self._met_at = self._pressed_at = math.nan
            self.done = self._index == len(self._steps)
        if self.done or self.let_go is not None:
            self.doing = "watches" if self.let_go is None else "lets go"
            return self._message(0.0, None)
        step = self._steps[self._index]
        self.doing = step.says
        if step.button is not None:
            self._button = step.button
        if step.shoulder is not None:
            again = math.isnan(self._met_at) and seen.time - self._pressed_at >= AGAIN_S
            if math.isnan(self._pressed_at) or again:
                self._pressed_at = seen.time
        pressing = seen.time - self._pressed_at < PRESSED_S
        return self._message(step.speed, step.shoulder if pressing else None)

    def _passed(self, seen: Seen) -> bool:
        step = self._steps[self._index]
        if step.upright and seen.mode in ("damping", "limp"):
            self.let_go = seen.time
            return False
        if math.isnan(self._met_at):
            if step.until is None or step.until(seen):
                self._true_since = seen.time if math.isnan(self._true_since) else self._true_since
            else:
                self._true_since = math.nan
            if seen.time - self._true_since >= step.still_s:
                self._met_at = seen.time
        pressed = step.shoulder is None or seen.time - self._pressed_at >= PRESSED_S
        return pressed and seen.time - self._met_at >= step.hold_s

    def _message(self, speed: float, shoulder: str | None) -> rc_command_lcmt:
        message = rc_command_lcmt()
        right, forward = STICK_AT_REST
        message.left_stick = [right, forward if speed == 0.0 else speed / self._config.max_speed]
        message.right_stick = [right, forward]
        message.mode = BUTTONS.index(self._button)
        if shoulder is not None:
            setattr(message, SHOULDERS[shoulder], 1)
        return message
