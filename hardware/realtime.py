"""Real-time scheduling, where the operating system grants it."""

from __future__ import annotations

import os
import sys
import threading
from pathlib import Path

LOOP_PRIORITY = 20
"""Of threads on whose punctuality something hangs."""

OTHER_PRIORITY = 10
"""Of the other threads of such a process: they hold the interpreter's lock now and then, and then must be run, too."""

_SWITCH_S = 1e-4


def ask(*first: int | None) -> bool:
    """Ask for first-in-first-out scheduling of every thread of this process, as they are now; whether it was granted.

    It takes root or CAP_SYS_NICE. In any case other threads hand the interpreter's lock over within 0.1 ms from now on.

    Args:
        first: the operating system's numbers of the threads that come before the others, beside the calling one.
    """
    sys.setswitchinterval(_SWITCH_S)
    urgent = {threading.get_native_id(), *first}
    try:
        for task in Path("/proc/self/task").iterdir():
            number = int(task.name)
            priority = LOOP_PRIORITY if number in urgent else OTHER_PRIORITY
            os.sched_setscheduler(number, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(priority))
    except OSError:
        return False
    return True
