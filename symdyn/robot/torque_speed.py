"""The torque that a motor can give at a speed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def torque_range(speed: Floats, peak: Floats, no_load_speed: Floats, knee: float) -> tuple[Floats, Floats]:
    """Lowest and highest torque that a motor can give at a speed.

    Against its motion it gives its peak torque. Along it, the peak torque holds up to ``knee`` of the no-load speed and
    falls linearly from there to zero at the no-load speed: the straight line of a voltage-limited DC motor, cut off at
    the torque that gears and electronics allow.

    Args:
        speed: (..., joints) rad/s.
        peak: (..., joints) N m.
        no_load_speed: (joints,) rad/s.
        knee: in [0, 1).

    Returns:
        Two arrays (..., joints), N m.
    """
    left = (1.0 - np.abs(speed) / no_load_speed) / (1.0 - knee)
    along = peak * np.clip(left, 0.0, 1.0)
    return np.where(speed < 0.0, -along, -peak), np.where(speed > 0.0, along, peak)
