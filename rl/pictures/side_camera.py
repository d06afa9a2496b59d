"""A camera that goes along beside the robot, smoothly: it follows where the robot goes, not how it bounces."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from symdyn.analysis.recording import Floats, Recording
from symdyn.robot.frames import yaw

FOLLOW_S = 0.35
"""s; standard deviation of the average over time that the camera follows: a stride of the Go2 takes 0.2 to 0.5 s."""

TURN_S = 0.8
"""s; the same for the direction that it looks in."""

BELOW = 0.12
"""m; how much lower than the trunk's origin the camera looks, so that trunk and feet show."""

FROM_ABOVE = 12.0
"""degrees by which it looks down."""

FROM_AHEAD = 15.0
"""degrees by which it stands before the robot's side, so that the legs of both sides show."""

_REACH = 3.0
"""Standard deviations of a Gaussian that count."""


def side_views(recording: Recording) -> tuple[Floats, Floats]:
    """Where the camera looks at every sample: from the robot's right, so that it runs to the right.

    Returns:
        The point looked at, (S, 3) m in the world; the azimuth of the line of sight, (S,) degrees from the world's x
        axis, as MuJoCo counts it.
    """
    point = _smooth(recording.base_pos_w, FOLLOW_S / recording.dt) - np.array([0.0, 0.0, BELOW])
    heading = _smooth(np.unwrap(yaw(recording.base_quat_w)), TURN_S / recording.dt)
    return point, np.degrees(heading) + 90.0 + FROM_AHEAD


def _smooth(values: NDArray[np.float64], sigma: float) -> NDArray[np.float64]:
    """Gaussian average over the first axis; beyond the ends values go on as they came, so that nothing slows down."""
    reach = min(round(_REACH * sigma), len(values) - 1)
    padding = [(reach, reach)] + [(0, 0)] * (values.ndim - 1)
    longer = np.pad(values, padding, mode="reflect", reflect_type="odd")
    return gaussian_filter1d(longer, sigma, axis=0, truncate=_REACH)[reach : reach + len(values)]
