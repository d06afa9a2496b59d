"""Settings of an animated gait."""

from __future__ import annotations

import math
from dataclasses import dataclass

from symdyn.errors import InvalidValue


@dataclass(frozen=True)
class AnimationConfig:
    """How a gait is shown.

    Attributes:
        strides: number of strides.
        seconds: time that a stride takes on screen, s; the picture states the slow motion.
        fps: frames a second.
        width: width of the picture, pixels; the height is 9/16 of it.
        forces: whether ground reaction forces are drawn.
    """

    strides: int = 3
    seconds: float = 2.0
    fps: int = 25
    width: int = 800
    forces: bool = True

    def __post_init__(self) -> None:
        for name, low, high in (("strides", 1, 100), ("fps", 5, 100), ("width", 200, 4000)):
            if not low <= getattr(self, name) <= high:
                raise InvalidValue(name, getattr(self, name), f"from {low} to {high}")
        if not (math.isfinite(self.seconds) and 0.2 <= self.seconds <= 60.0):
            raise InvalidValue("seconds", self.seconds, "from 0.2 to 60, s a stride")

    @property
    def frames_a_stride(self) -> int:
        """Whole number of frames, so that strides repeat exactly."""
        return max(2, round(self.seconds * self.fps))

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, pixels, both even, as video formats want them."""
        return 2 * (self.width // 2), 2 * (self.width * 9 // 32)
