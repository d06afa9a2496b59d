"""A process of its own that damps the motors over DDS if the bridge is killed or hangs.

    python -m hardware.bridge.guard --interface NAME --domain N --bridge KEY --last-words FD

It hears the LowCmds on the wire, so that whatever keeps the bridge from sending is seen: silence for
:data:`hardware.bridge.settings.STALL_S` after its first LowCmd, or the end of the pipe from the bridge without a word.
Then it streams damping until it is told ``quit`` through the pipe, until the operator presses L1 on the remote control
while the bridge is gone, or until it is ended by a signal.
"""

from __future__ import annotations

import argparse
import logging
import os
import select
import signal
import sys
from uuid import UUID

from hardware.bridge.settings import STALL_S
from hardware.dds.codec import BadMessage
from hardware.dds.messages import LOW_CMD_CODEC, LOW_STATE_CODEC, damping
from hardware.dds.node import LOW_CMD, LOW_STATE, Node, Reader, Writer
from hardware.dds.remote import held
from hardware.dds.types import LowCmd, LowState
from hardware.running import realtime
from hardware.running.deadline_loop import DeadlineLoop

PERIOD = 0.005
"""s between two looks, and between two LowCmds of its damping."""

TO_PASSIVE = "L1"
"""Button of the remote control that ends the damping, as it ends that of symdyn deploy."""

_PUNCTUAL_S = 0.015
"""s between two looks; after a longer pause of its own, what has arrived in it may not have been taken yet."""

_KEPT = 64
_log = logging.getLogger("hardware.bridge.guard")


class Guard:
    """Sees silence, and breaks it.

    Args:
        node: on the robot's network.
        bridge: key of the writer that is guarded.
        damping_kd: N m s/rad.

    Attributes:
        fired: whether it has taken over.
        done: whether there is nothing left to guard.
    """

    def __init__(self, node: Node, bridge: UUID, damping_kd: float) -> None:
        self.writer = Writer(node, LOW_CMD, LowCmd)
        self._commands = Reader(node, LOW_CMD, LowCmd, _KEPT, ignore_own=True)
        self._states = Reader(node, LOW_STATE, LowState)
        self._bridge = bridge
        self._damping = LOW_CMD_CODEC.encode(damping(damping_kd))
        self._seen_at: float | None = None
        self._last_look = -float("inf")
        self._released = False
        self._alone = False
        self.fired = self.done = False

    def hear(self, words: str | None) -> None:
        """What the bridge says: a line, or None when it is gone without ``quit``."""
        if words is not None:
            self.done = words.strip() == "quit"
            return
        self._alone = True
        if self._seen_at is None:
            self.done = True
        elif not self.fired:
            self._fire("the bridge is gone")

    def tick(self, now: float) -> None:
        """Look, and damp if it is time to. ``now``: s of time.monotonic()."""
        if any(self._commands.writer(sample.handle) == self._bridge for sample in self._commands.take()):
            self._seen_at = now
        punctual = now - self._last_look < _PUNCTUAL_S
        self._last_look = now
        if not self.fired:
            if self._seen_at is None or not punctual or now - self._seen_at <= STALL_S:
                return
            self._fire(f"no commands for {1e3 * (now - self._seen_at):.0f} ms")
        if self._alone and self._ended_by_operator():
            _log.warning("%s pressed: the damping ends.", TO_PASSIVE)
            self.done = True
            return
        self.writer.write(self._damping)

    def _ended_by_operator(self) -> bool:
        for sample in self._states.take():
            try:
                state = LOW_STATE_CODEC.decode(sample.data)
            except BadMessage:
                continue
            if LOW_STATE_CODEC.crc_fits(state):
                down = held(state["wireless_remote"].tobytes(), TO_PASSIVE)
                if down and self._released:
                    return True
                self._released = not down
        return False

    def _fire(self, why: str) -> None:
        self.fired = True
        _log.warning(
            "The guard damps the robot: %s. %s on the remote control, or kill %d, ends it.",
            why, TO_PASSIVE, os.getpid(),
        )  # fmt: skip


def main(arguments: list[str] | None = None) -> int:
    """The process. Returns 0."""
    parser = argparse.ArgumentParser(description="Damps the robot if the bridge dies. Started by symdyn bridge.")
    parser.add_argument("--interface", default=None)
    parser.add_argument("--domain", required=True, type=int)
    parser.add_argument("--bridge", required=True, type=UUID, help="key of the bridge's writer of LowCmd")
    parser.add_argument("--last-words", required=True, type=int, help="file descriptor of the pipe from the bridge")
    parser.add_argument("--damping-kd", required=True, type=float)
    args = parser.parse_args(arguments)
    logging.basicConfig(level=logging.INFO, stream=sys.stderr, format="%(message)s")
    stopped: list[int] = []
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda signum, frame: stopped.append(signum))
    guard = Guard(Node(args.interface, args.domain), args.bridge, args.damping_kd)
    # the robot must take its commands, and the bridge must see them
    while guard.writer.readers < 2 and not stopped:
        if select.select([args.last_words], [], [], PERIOD)[0]:
            return 0  # the bridge is gone again
    sys.stdout.write(f"ready {guard.writer.key}\n")
    sys.stdout.flush()
    realtime.ask(realtime.WATCHDOG_PRIORITY)
    loop = DeadlineLoop(PERIOD)
    pipe, rest, open_ = args.last_words, "", True
    while not guard.done and not stopped:
        now = loop.wait()
        if open_ and select.select([pipe], [], [], 0.0)[0]:
            data = os.read(pipe, 4096).decode()
            open_ = bool(data)
            *lines, rest = (rest + data).split("\n")
            for line in lines:
                guard.hear(line)
            if not open_ and not guard.done:
                guard.hear(None)
        guard.tick(now)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
