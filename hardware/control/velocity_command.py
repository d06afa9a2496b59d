"""The velocity that the policy is told: what the operator asks for, within what the policy was trained on."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from hardware.wire.readings import Floats
from symdyn.policy.metadata import COMMANDS, PolicyMetadata

USUAL_RATE = 1.0
"""m/s^2 or rad/s^2, where the policy's training does not say how often its commands change."""


def implied_rates(metadata: PolicyMetadata) -> Floats:
    """How fast each velocity command may change, (3,) m/s^2, m/s^2, rad/s^2.

    Training draws a new command from the whole range after ``env.commands.velocity_again_s`` seconds: the range's span
    over the shortest such time is the fastest change that it knows, on average.
    """
    span = np.array([high - low for low, high in (metadata.command_range[name] for name in COMMANDS)])
    interval = _nested(metadata.training.get("config"), "env", "commands", "velocity_again_s")
    shortest = interval[0] if isinstance(interval, list) and interval else None
    if not isinstance(shortest, int | float) or not 0.0 < shortest < math.inf:
        return np.full(len(COMMANDS), USUAL_RATE)
    return span / shortest


class VelocityCommand:
    """A velocity command that goes towards what is asked no faster than :func:`implied_rates`.

    Args:
        metadata: of the policy.

    Attributes:
        value: (3,) v_x, v_y (m/s), yaw rate (rad/s).
    """

    def __init__(self, metadata: PolicyMetadata) -> None:
        ranges = [metadata.command_range[name] for name in COMMANDS]
        self._low, self._high = (np.array(bound) for bound in zip(*ranges, strict=True))
        self._rate = implied_rates(metadata)
        self.value = np.zeros(len(COMMANDS))

    def stand_still(self) -> None:
        """Begin anew from 0."""
        self.value = np.zeros(len(COMMANDS))

    def towards(self, asked: tuple[float, float, float], dt: float) -> Floats:
        """Go towards ``asked`` for dt, s; the new value, a fresh array."""
        goal = np.minimum(np.maximum(asked, self._low), self._high)
        step = self._rate * dt
        self.value = self.value + np.minimum(np.maximum(goal - self.value, -step), step)
        return self.value.copy()


def _nested(data: Any, *path: str) -> Any:
    for key in path:
        data = data.get(key) if isinstance(data, Mapping) else None
    return data
