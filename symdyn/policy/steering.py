"""From what is asked of a robot to what its policy is told: a dead band, standing, and heading hold.

Trainer, simulator, viewer and robot call the same functions, on tensors and on numpy arrays. A command is (v_x, v_y,
yaw rate) in the heading frame, m/s, m/s, rad/s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from array_api_compat import array_namespace

from symdyn.arrays import Array
from symdyn.errors import InvalidValue


@dataclass(frozen=True)
class DeadBand:
    """Velocities too small to follow count as zero, with hysteresis, so that a noisy stick neither starts nor stops a
    robot nor reverses its gait. Each pair is (release, engage): a component that is zero stays zero below ``engage``;
    one that is not becomes zero below ``release`` or when its sign changes below ``engage``.

    Attributes:
        linear: of v_x and of v_y, m/s.
        yaw: of the yaw rate, rad/s.

    Raises:
        InvalidValue: unless 0 <= release <= engage.
    """

    linear: tuple[float, float] = (0.04, 0.08)
    yaw: tuple[float, float] = (0.04, 0.08)

    def __post_init__(self) -> None:
        for name, (release, engage) in (("linear", self.linear), ("yaw", self.yaw)):
            if not 0.0 <= release <= engage < math.inf:
                raise InvalidValue(f"dead_band.{name}", (release, engage), "two numbers >= 0, the smaller first")

    def apply(self, asked: Array, previous: Array) -> Array:
        """The command to follow.

        Args:
            asked: (..., 3).
            previous: (..., 3) what this returned last; zeros at first.

        Returns:
            (..., 3) ``asked`` with those of its components set to zero that lie in the dead band.
        """
        xp = array_namespace(asked, previous)
        kwargs = {"dtype": asked.dtype}
        release, engage = (
            xp.asarray([self.linear[i], self.linear[i], self.yaw[i]], **kwargs) for i in range(len(self.linear))
        )
        size = xp.abs(asked)
        follow = (size >= engage) | ((asked * previous > 0.0) & (size >= release))
        return xp.where(follow, asked, xp.zeros_like(asked))


STANDING_DUTY = 1.0
"""Duty factor of a robot that stands: all feet stay on the ground. Its clock stops."""


def stands(command: Array) -> Array:
    """Whether a command asks a robot to stand still: all of it is zero. (..., 3) -> (...,) bool."""
    xp = array_namespace(command)
    return ~xp.any(command != 0.0, axis=-1)


@dataclass(frozen=True)
class HeadingHold:
    """Proportional control of the heading while no turn is asked for: the yaw rate told to the policy is
    ``gain * (reference - heading)``, limited. The reference is the heading at which the last turn ended.

    Attributes:
        gain: rad/s per rad; 0 switches it off.
        limit: largest yaw rate that it asks for, rad/s.

    Raises:
        InvalidValue: for a number below zero.
    """

    gain: float = 2.0
    limit: float = 0.4

    def __post_init__(self) -> None:
        for name in ("gain", "limit"):
            if not 0.0 <= getattr(self, name) < math.inf:
                raise InvalidValue(f"heading_hold.{name}", getattr(self, name), "a number >= 0")

    def apply(self, command: Array, heading: Array, reference: Array) -> tuple[Array, Array]:
        """The command with its yaw rate, and the heading to hold from now on.

        A robot that is told to turn, or to stand, gets its command unchanged. While it turns, the reference follows its
        heading; while it stands, the reference stays.

        Args:
            command: (..., 3) after the dead band.
            heading: (...,) yaw of the trunk in the world, rad, from any origin.
            reference: (...,) what this returned last, rad.

        Returns:
            (..., 3) and (...,).
        """
        xp = array_namespace(command, heading, reference)
        turns = command[..., 2] != 0.0
        held = xp.where(turns, heading, reference)
        error = held - heading
        error = xp.atan2(xp.sin(error), xp.cos(error))
        correction = xp.clip(self.gain * error, -self.limit, self.limit)
        free = turns | stands(command)
        yaw_rate = xp.where(free, command[..., 2], correction)
        return xp.stack([command[..., 0], command[..., 1], yaw_rate], axis=-1), held


@dataclass(frozen=True)
class Steering:
    """How a policy's commands are prepared. A policy file carries it; one from before had none.

    Attributes:
        dead_band: for commands near zero.
        heading_hold: for running straight.
    """

    dead_band: DeadBand = field(default_factory=DeadBand)
    heading_hold: HeadingHold = field(default_factory=HeadingHold)
