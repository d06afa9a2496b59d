"""Stages of a training run: settings that change on the way, and until when each set holds."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from symdyn.errors import InvalidValue

MEASURED = (
    "reward/total",
    "task/x_velocity_error",
    "task/y_velocity_error",
    "task/yaw_rate_error",
    "task/fell_per_s",
    "episode/return",
    "episode/seconds",
)
"""What a criterion can go by: figures that every update logs."""

CHANGEABLE = ("engine.", "env.", "ppo.")
"""How the names of the settings begin that a stage may change."""

FIXED = (
    "env.observation",
    "ppo.hidden",
    "ppo.initial_std",
    "ppo.steps",
    "ppo.privileged_critic",
    "ppo.equivariant",
    "ppo.mixed_precision",
)
"""Settings among them that a network, once made, cannot follow."""

RAMPED = ("env.rewards.", "ppo.")
"""How the names of the settings begin whose numbers go linearly to their new values during a stage's ramp."""


@dataclass(frozen=True)
class Criterion:
    """A figure whose mean over the last updates ends a stage when it is good enough.

    Attributes:
        metric: one of :data:`MEASURED`.
        at_most: the stage ends when the mean is this or less.
        at_least: the stage ends when the mean is this or more. Exactly one of the two is given.
        updates: that the mean is over.
    """

    metric: str
    at_most: float | None = None
    at_least: float | None = None
    updates: int = 20

    def __post_init__(self) -> None:
        if self.metric not in MEASURED:
            raise InvalidValue("A stage's criterion", self.metric, f"one of what is measured: {', '.join(MEASURED)}")
        if (self.at_most is None) == (self.at_least is None):
            raise InvalidValue("A stage's criterion", (self.at_most, self.at_least), "either at_most or at_least")
        if self.updates < 1:
            raise InvalidValue("A criterion's updates", self.updates, "a whole number > 0")

    def met(self, mean: float) -> bool:
        """Whether the mean is good enough."""
        if self.at_most is not None:
            return mean <= self.at_most
        assert self.at_least is not None
        return mean >= self.at_least

    def __str__(self) -> str:
        sign, bound = ("<=", self.at_most) if self.at_most is not None else (">=", self.at_least)
        return f"{self.metric} {sign} {bound:g}"


@dataclass(frozen=True)
class Stage:
    """A part of a run.

    Attributes:
        name: what to call it.
        samples: how many it lasts, or, with a criterion, at most lasts. Only the last stage may be without: it lasts
            until the run's iterations are done.
        settings: what it changes, by dotted name (``env.rewards.x_rate: 2.5``); all else stays as in the stage before.
            Rewards and the learner's numbers change during the ramp, all others at once, and then all episodes begin
            anew.
        ramp: samples from its beginning in which numbers go linearly to their new values.
        criterion: what ends it before its samples are used up, once the ramp is over; None for nothing.
    """

    name: str
    samples: float | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)
    ramp: float = 0.0
    criterion: Criterion | None = None

    def __post_init__(self) -> None:
        if not self.name.strip():
            raise InvalidValue("A stage's name", self.name, "a word or more")
        if self.samples is not None and not 0.0 < self.samples < math.inf:
            raise InvalidValue(f"stage {self.name!r}: samples", self.samples, "a number > 0")
        longest = math.inf if self.samples is None else self.samples
        if not 0.0 <= self.ramp <= longest:
            raise InvalidValue(f"stage {self.name!r}: ramp", self.ramp, "from 0 to the stage's samples")
        for name in self.settings:
            if not name.startswith(CHANGEABLE) or name in FIXED:
                allowed = ", ".join(f"{start}*" for start in CHANGEABLE)
                raise InvalidValue(
                    f"stage {self.name!r}: setting", name, f"one of {allowed}, but none of {', '.join(FIXED)}"
                )


def check(stages: tuple[Stage, ...]) -> None:
    """Check that a list of stages comes to an end.

    Raises:
        InvalidValue: if a name stands twice, or a stage before the last has no number of samples.
    """
    names = [stage.name for stage in stages]
    if len(set(names)) != len(names):
        raise InvalidValue("The stages' names", names, "different from each other")
    for stage in stages[:-1]:
        if stage.samples is None:
            raise InvalidValue(
                f"stage {stage.name!r}: samples", None, "given: only the last stage may last until the run ends"
            )


def share(stage: Stage, samples: float) -> float:
    """How much of a stage's change has taken place after so many samples of it, in [0, 1]."""
    return 1.0 if stage.ramp == 0.0 else min(samples / stage.ramp, 1.0)


def changed(data: Mapping[str, Any], settings: Mapping[str, Any]) -> dict[str, Any]:
    """Nested plain settings with others of dotted names.

    Raises:
        InvalidValue: if there is no setting of a name.
    """
    result = copy.deepcopy(dict(data))
    for name, value in settings.items():
        *folders, last = name.split(".")
        place = result
        for folder in folders:
            place = place.get(folder) if isinstance(place, dict) else None
        if not isinstance(place, dict) or last not in place:
            raise InvalidValue("A setting of the stages", name, "the dotted name of a setting, as in config.yaml")
        place[last] = value
    return result


def blend(before: Any, after: Any, share_of_after: float, name: str = "") -> Any:
    """Nested plain settings between two: numbers of :data:`RAMPED` linearly, everything else as after."""
    if isinstance(after, Mapping):
        return {key: blend(before[key], value, share_of_after, f"{name}{key}.") for key, value in after.items()}
    numbers = isinstance(before, float) and isinstance(after, float)
    if not numbers or not name.startswith(RAMPED):
        return after
    return (1.0 - share_of_after) * before + share_of_after * after
