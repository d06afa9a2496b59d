"""Times and limits of the bridge."""

from __future__ import annotations

PERIOD = 0.002
"""s between two LowCmds."""

SILENCE_S = 0.1
"""s without targets after which the motors are damped: twice what the deployer's watchdog waits, and some more."""

STALL_S = 0.05
"""s without a LowCmd after which the guard damps; if this process finds out that it was so, it does, too."""

GENTLE_KP = 5.0
"""N m/rad. After a silence stiffer targets are not forwarded: whoever sends them goes on from where he was, while the
robot has sunk. symdyn deploy begins to stand up with gains that rise from 0."""
