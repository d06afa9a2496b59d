"""Real-time scheduling and processors that do not sleep, where the operating system grants them."""

from __future__ import annotations

import os
import struct
import sys
from dataclasses import dataclass
from pathlib import Path

PRIORITY = 20
"""Of every thread of a process. The interpreter's lock does not lend its holder the priority of those who wait for it,
so a thread of a lower one that holds it would be kept from running by the very loop that waits. Among equals one that
works is not interrupted, so what takes a good part of a tick, such as drawing, belongs in another process."""

WATCHDOG_PRIORITY = PRIORITY + 1
"""A deployer that never gives its processor back must not keep its watchdog from running."""

_SWITCH_S = 1e-4
_WAKING = Path("/dev/cpu_dma_latency")


@dataclass(frozen=True)
class Granted:
    """What the operating system gave.

    Attributes:
        priority: first-in-first-out scheduling of every thread; takes root, CAP_SYS_NICE or RLIMIT_RTPRIO.
        awake: idle processors wait instead of sleeping; takes a writable /dev/cpu_dma_latency (root, usually).
    """

    priority: bool
    awake: bool

    def __str__(self) -> str:
        scheduling = "real-time scheduling" if self.priority else "no real-time scheduling"
        return f"{scheduling}, idle processors {'stay awake' if self.awake else 'may sleep'}"


def ask(priority: int = PRIORITY) -> Granted:
    """Ask for punctuality of this process, with its threads as they are now, until it ends.

    In any case other threads hand the interpreter's lock over within 0.1 ms from now on.
    """
    sys.setswitchinterval(_SWITCH_S)
    return Granted(_scheduled(priority), _awake())


def _scheduled(priority: int) -> bool:
    try:
        for task in Path("/proc/self/task").iterdir():
            os.sched_setscheduler(int(task.name), os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(priority))
    except OSError:
        return False
    return True


def _awake() -> bool:
    """See "PM Quality Of Service Interface" in the kernel's documentation: it counts as long as the file is open."""
    try:
        held = os.open(_WAKING, os.O_WRONLY)
    except OSError:
        return False
    try:
        os.write(held, struct.pack("i", 0))  # us that waking may take
    except OSError:
        os.close(held)
        return False
    return True
