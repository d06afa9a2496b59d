"""``python -m benchmarks.bare_loop SECONDS``: what the machine itself does to a loop that has nothing to wait for.

The deployer's rate and scheduling, and as much work as a tick has, but no other thread, no message, no lock. Ticks that
this loop loses, no program on this machine could keep. Prints deadlines and lost ones.
"""

from __future__ import annotations

import gc
import sys
import time

from hardware.control.settings import TICK_HZ
from hardware.running import realtime
from hardware.running.deadline_loop import DeadlineLoop

_WORK_S = 0.0015
"""s; the median of a tick in the soak."""


def main() -> int:
    """Run, and print what became of it."""
    realtime.ask()
    gc.disable()
    loop = DeadlineLoop(1.0 / TICK_HZ)
    end = time.monotonic() + float(sys.argv[1])
    while (now := loop.wait()) < end:
        while time.monotonic() < now + _WORK_S:
            pass
    sys.stdout.write(f"{loop.ticks + loop.skipped} {loop.skipped}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
