"""Settings of a film."""

from __future__ import annotations

import math
from dataclasses import dataclass

from symdyn.errors import InvalidValue


@dataclass(frozen=True)
class FilmConfig:
    """How a recording is shown.

    Attributes:
        size: width and height of a frame, pixels, both even.
        fps: frames a second.
        slow: seconds on screen for a second of running: 4 is slow motion, 1 real time.
    """

    size: tuple[int, int] = (640, 360)
    fps: int = 25
    slow: float = 1.0

    def __post_init__(self) -> None:
        for name, value, high in zip(("width", "height"), self.size, (3840, 2160), strict=True):
            if not (160 <= value <= high and value % 2 == 0):
                raise InvalidValue(f"The {name} of --size", value, f"an even number from 160 to {high}, pixels")
        if not 5 <= self.fps <= 100:
            raise InvalidValue("--fps", self.fps, "from 5 to 100")
        if not (math.isfinite(self.slow) and 0.05 <= self.slow <= 100.0):
            raise InvalidValue("--slow", self.slow, "from 0.05 to 100")

    def frames_of(self, seconds: float) -> int:
        """How many frames show so many seconds of running; at least one."""
        return max(1, round(seconds * self.slow * self.fps))
