"""Deployer and simulated robot as processes over LCM, and an ear on the wire: for benchmarks and end-to-end tests."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence, Set
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import IO

from hardware.wire.channels import TARGETS
from hardware.wire.link import Link
from hardware.wire.messages import pd_tau_targets_lcmt
from hardware.wire.readings import Targets
from symdyn.robot.robot_file import DEFAULT_ROBOT, get_robot

QUICK_STAND = (
    "--stand.rise-s", "0.8", "--stand.ramp-s", "0.2", "--stand.settle-s", "0.2", "--stand.wiggle-s", "0.1",
)  # fmt: skip
"""Options of symdyn deploy that stand up in 2.2 s."""


WATCHDOG, DISPLAY = "hardware.running.watchdog", "hardware.running.display"
"""Modules of which symdyn deploy starts processes."""

_LAST_WORDS_S = 1.0


class Command:
    """A command as a process. Its words go to a file, which a watchdog that outlives it may hold open.

    Args:
        arguments: of the command.
        module: that is run.
        terminal: whether it is to find a terminal; what it draws there is among its words.
    """

    def __init__(self, arguments: Sequence[object], module: str = "symdyn", terminal: bool = False) -> None:
        self._words = tempfile.TemporaryFile("w+")  # noqa: SIM115
        command = [sys.executable, "-m", module, *map(str, arguments)]
        self._reader: threading.Thread | None = None
        if not terminal:
            self.process = subprocess.Popen(command, stdout=self._words, stderr=subprocess.STDOUT)
            return
        screen, end = os.openpty()
        environment = {**os.environ, "TERM": "xterm-256color", "COLUMNS": "120", "LINES": "40"}
        self.process = subprocess.Popen(command, stdout=end, stderr=end, env=environment)
        os.close(end)
        self._reader = threading.Thread(target=_read_off, args=(screen, self._words), daemon=True)
        self._reader.start()

    def ends(self, within: float) -> tuple[int, str]:
        """Wait for its end: the exit code and what it said."""
        code = self.process.wait(within)
        if self._reader is not None:
            self._reader.join(_LAST_WORDS_S)
        return code, self.words()

    def damps_and_ends(self, within: float) -> tuple[int, str]:
        """End a deployer as an operator would: SIGTERM damps, another ends the damping. As :meth:`ends`."""
        for _ in range(2):
            self.process.send_signal(signal.SIGTERM)
            time.sleep(0.5)
        return self.ends(within)

    def words(self) -> str:
        """What it has said so far."""
        with Path(f"/proc/self/fd/{self._words.fileno()}").open() as again:  # from the start, at a place of its own
            return again.read()

    def child(self, module: str) -> int:
        """The number of the process that it has started of a module."""
        pids = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text().split()
        return next(int(pid) for pid in pids if module.encode() in Path(f"/proc/{pid}/cmdline").read_bytes())


def _read_off(screen: int, file: IO[str]) -> None:
    try:
        while drawn := os.read(screen, 65536):
            os.write(file.fileno(), drawn)
    except OSError:  # nobody has the other end open any more
        pass
    finally:
        os.close(screen)


@contextmanager
def process(*arguments: object, module: str = "symdyn", terminal: bool = False) -> Iterator[Command]:
    """A command, as :class:`Command` says, killed with its watchdog if they are still there at the end."""
    its = Command(arguments, module, terminal)
    try:
        yield its
    finally:
        if its.process.poll() is None:
            children = Path(f"/proc/{its.process.pid}/task/{its.process.pid}/children").read_text().split()
            for pid in (its.process.pid, *map(int, children)):
                os.kill(pid, signal.SIGKILL)
            its.process.wait()


@contextmanager
def on_processors(processors: Set[int]) -> Iterator[None]:
    """What is started within the block runs on these processors."""
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, processors)
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


class Ear:
    """Hears every target on the wire."""

    def __init__(self, url: str) -> None:
        self.targets: list[tuple[float, Targets]] = []
        self.link = Link(url, [TARGETS], self._take)
        self.link.start()

    def _take(self, channel: str, data: bytes, arrival: float, number: int) -> None:
        self.targets.append((arrival, Targets.of(pd_tau_targets_lcmt.decode(data))))

    @property
    def mode(self) -> str:
        """By the gains of the last targets."""
        if not self.targets:
            return "untold"
        kp = self.targets[-1][1].kp
        return "damping" if not kp.any() else "running" if (kp == get_robot(DEFAULT_ROBOT).kp).all() else "standing"

    def first_damping(self, after: float) -> float:
        """When the first damping after a moment came, s of time.monotonic()."""
        return next(when for when, targets in self.targets if when >= after and not targets.kp.any())

    def longest_gap(self, after: float) -> float:
        """Between two targets, s."""
        times = [when for when, _ in self.targets if when >= after]
        return max(b - a for a, b in pairwise(times))


@contextmanager
def hearing(url: str) -> Iterator[Ear]:
    """An ear until the end of the block."""
    ear = Ear(url)
    try:
        yield ear
    finally:
        ear.link.close()
