"""The keyboard in place of the joystick: keys become the same messages."""

from __future__ import annotations

import logging
import select
import sys
import termios
import threading
import time
import tty
from dataclasses import dataclass

from hardware.control.joystick import JoystickConfig
from hardware.wire.channels import JOYSTICK
from hardware.wire.link import Link
from hardware.wire.messages import rc_command_lcmt
from hardware.wire.readings import BUTTONS, SHOULDERS
from symdyn.errors import ResourceProblem

_PERIOD = 0.02
_HELD_S = 0.2
_STEP = 0.1
_STICKS = {
    "w": ("left", 1, _STEP),
    "s": ("left", 1, -_STEP),
    "a": ("left", 0, -_STEP),
    "d": ("left", 0, _STEP),
    "q": ("right", 0, -_STEP),
    "e": ("right", 0, _STEP),
}

_log = logging.getLogger(__name__)


@dataclass
class KeyboardJoystick:
    """What the keys pressed so far amount to.

    Attributes:
        config: which shoulder button does what.
    """

    config: JoystickConfig

    def __post_init__(self) -> None:
        self._sticks = {"left": [0.0, 0.0], "right": [0.0, 0.0]}
        self._mode = 0
        self._held_until: dict[str, float] = {}

    def press(self, key: str, now: float) -> None:
        """Take a key. Others than those of :data:`KEYS` do nothing. ``now``: s."""
        shoulder = {
            "\r": self.config.next_state,
            "\n": self.config.next_state,
            " ": self.config.stop[0],
            "p": self.config.to_passive,
        }
        if key in shoulder:
            self._held_until[shoulder[key]] = now + _HELD_S
        elif key in _STICKS:
            stick, axis, step = _STICKS[key]
            self._sticks[stick][axis] = round(min(1.0, max(-1.0, self._sticks[stick][axis] + step)), 3)
        elif key == "0":
            self._sticks = {"left": [0.0, 0.0], "right": [0.0, 0.0]}
        elif key in "12345678":
            self._mode = min(int(key), len(BUTTONS)) - 1

    def message(self, now: float) -> rc_command_lcmt:
        """As the joystick would say it. ``now``: s."""
        message = rc_command_lcmt()
        message.mode = self._mode
        message.left_stick, message.right_stick = list(self._sticks["left"]), list(self._sticks["right"])
        for name, field in SHOULDERS.items():
            setattr(message, field, int(self._held_until.get(name, 0.0) > now))
        return message


class Keyboard:
    """Reads the terminal in a thread and feeds a link, until it is closed.

    Args:
        link: to feed; it must not receive the joystick's channel from elsewhere.
        config: which shoulder button does what.

    Raises:
        ResourceProblem: if standard input is no terminal.
    """

    def __init__(self, link: Link, config: JoystickConfig) -> None:
        if not sys.stdin.isatty():
            raise ResourceProblem("--keyboard needs a terminal, but standard input is not a terminal.")
        self._link = link
        self._joystick = KeyboardJoystick(config)
        self._descriptor = sys.stdin.fileno()
        self._before = termios.tcgetattr(self._descriptor)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="keyboard", daemon=True)

    def start(self) -> None:
        """Take the terminal's keys from now on."""
        tty.setcbreak(self._descriptor)
        self._thread.start()

    def close(self) -> None:
        """Give the terminal back."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join(timeout=1.0)
        termios.tcsetattr(self._descriptor, termios.TCSADRAIN, self._before)

    def _run(self) -> None:
        try:
            while not self._stop.is_set():
                if select.select([sys.stdin], [], [], _PERIOD)[0]:
                    key = sys.stdin.read(1)
                    if not key:
                        break  # the terminal is gone, and so are the messages: the joystick counts as lost
                    self._joystick.press(key, time.monotonic())
                self._link.take(JOYSTICK, self._joystick.message(time.monotonic()).encode())
        except Exception:
            _log.exception("The keyboard cannot be read any more")
