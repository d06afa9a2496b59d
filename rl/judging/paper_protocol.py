"""Numbers that the protocols of the paper's Results section share."""

from __future__ import annotations

GAIT_SEQUENCE = ("trot", "bound", "half_bound_left", "rotary_gallop")
"""Two seconds each at 0.5 m/s: paper, section IV-B, which says half-bounding and galloping and not which."""


GAIT_SPEED = 0.5


SETTLE_S = 1.0
"""s after a change of command that steady-state metrics leave out (the paper: about 1 s to converge)."""
