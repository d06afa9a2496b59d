"""A process of its own that damps the robot if the deployer is killed or hangs.

    python -m hardware.running.watchdog --url URL --sender N --last-words FD

It listens to the targets on the wire, so that whatever keeps the deployer from sending is seen: silence for
:data:`SILENCE_S` after the first target, or the end of the pipe from the deployer without a word. Then it streams
damping until the deployer, if it comes back, passes to Passive; until the operator presses L1; or until it is ended by
a signal.

The deployer's words through the pipe, a line each: ``passive N`` (targets up to number N are past; silence is all right
until a later one is seen) and ``quit``.
"""

from __future__ import annotations

import argparse
import logging
import os
import select
import signal
import sys
import time

import numpy as np

from hardware.control.settings import SafetyConfig
from hardware.running import realtime
from hardware.running.deadline_loop import DeadlineLoop
from hardware.wire.channels import JOYSTICK, TARGETS
from hardware.wire.link import Link
from hardware.wire.readings import Joystick, Targets
from symdyn.robot.legs import JOINTS

SILENCE_S = 0.06
"""s; twelve ticks of the deployer, which would itself damp after three that are late."""

PERIOD = 0.01
"""s between two looks, and between two targets of its damping."""

_PUNCTUAL_S = 0.02
"""s between two looks; after a longer pause of its own, what has arrived in it may not have been taken yet."""

_log = logging.getLogger("hardware.running.watchdog")


def guardian_of(sender: int) -> int:
    """The sender number of the watchdog of a deployer, whose own is even."""
    assert sender % 2 == 0
    return sender + 1


class Watchdog:
    """Sees silence, and breaks it.

    Args:
        link: receives targets and joystick; started.
        sender: of the deployer that is guarded.
        damping_kd: N m s/rad.
        to_passive: shoulder button that ends the damping.

    Attributes:
        fired_at: when it took over, s of time.monotonic(), or None.
        done: whether there is nothing left to guard.
    """

    def __init__(self, link: Link, sender: int, damping_kd: float, to_passive: str = "L1") -> None:
        self._link, self._sender = link, sender
        ones = np.ones(len(JOINTS))
        self._damping = Targets(pos=0.0 * ones, kp=0.0 * ones, kd=damping_kd * ones)
        self._to_passive = to_passive
        self._seen, self._seen_at = 0, -np.inf
        self._last_look = -np.inf
        self._past = 0
        self._number = 0
        self._released = True
        self.fired_at: float | None = None
        self.done = False

    def hear(self, words: str | None) -> None:
        """What the deployer says: a line, or None when it is gone without ``quit``."""
        match words.split() if words is not None else None:
            case None if self.fired_at is None:
                if self._armed:
                    self._fire("the deployer is gone")
                else:
                    self.done = True
            case ["passive", number]:
                self._past = int(number)
                self.fired_at = None
            case ["quit"]:
                self.done = True

    def tick(self, now: float) -> None:
        """Look, and send damping if it is time to. ``now``: s of time.monotonic()."""
        received = self._link.latest(TARGETS)
        if received is not None and received.message.robot_id == self._sender and received.message.id > self._seen:
            self._seen, self._seen_at = received.message.id, received.arrival
        if self.fired_at is None:
            punctual = now - self._last_look < _PUNCTUAL_S
            self._last_look = now
            if self._armed and punctual and now - self._seen_at > SILENCE_S:
                self._fire(f"no targets for {now - self._seen_at:.3f} s")
            else:
                return
        joystick = self._link.latest(JOYSTICK)
        if joystick is not None:
            held = self._to_passive in Joystick.of(joystick.message).held
            if held and self._released:
                _log.warning("%s pressed: the damping ends.", self._to_passive)
                self.done = True
                return
            self._released = not held
        self._number += 1
        self._link.send(TARGETS, self._damping.message(self._number, guardian_of(self._sender)))

    @property
    def _armed(self) -> bool:
        return self._seen > self._past

    def _fire(self, why: str) -> None:
        self.fired_at = time.monotonic()
        _log.warning(
            "The watchdog damps the robot: %s. %s on the joystick, or kill %d, ends it.",
            why, self._to_passive, os.getpid(),
        )  # fmt: skip


def main(arguments: list[str] | None = None) -> int:
    """The process. Returns 0."""
    parser = argparse.ArgumentParser(description="Damps the robot if the deployer dies. Started by symdyn deploy.")
    parser.add_argument("--url", required=True)
    parser.add_argument("--sender", required=True, type=int)
    parser.add_argument("--last-words", required=True, type=int, help="file descriptor of the pipe from the deployer")
    parser.add_argument("--damping-kd", type=float, default=SafetyConfig.damping_kd)
    parser.add_argument("--to-passive", default="L1")
    args = parser.parse_args(arguments)
    logging.basicConfig(level=logging.INFO, stream=sys.stderr, format="%(message)s")
    stopped = []
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda signum, frame: stopped.append(signum))
    link = Link(args.url, (TARGETS, JOYSTICK))
    link.start()
    watchdog = Watchdog(link, args.sender, args.damping_kd, args.to_passive)
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    realtime.ask(realtime.WATCHDOG_PRIORITY)
    loop = DeadlineLoop(PERIOD)
    pipe, rest, open_ = args.last_words, "", True
    while not watchdog.done and not stopped:
        now = loop.wait()
        if open_ and select.select([pipe], [], [], 0.0)[0]:
            data = os.read(pipe, 4096).decode()
            open_ = bool(data)
            *lines, rest = (rest + data).split("\n")
            for line in lines:
                watchdog.hear(line)
            if not open_:
                watchdog.hear(None)
        watchdog.tick(now)
    link.close()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
