"""Settings of the simulated robot."""

from __future__ import annotations

from typing import Literal

Start = Literal["lying", "standing", "hung"]


PERIOD = 0.002
"""s between two messages of the bridge, and between two steps of the physics."""


Since = Literal["start", "stand", "run"]
