"""How a run's own checkpoints are compared: short runs on seeds and commands that no reported experiment uses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rl.judging import protocols
from rl.judging.simulate import Episode, Script, Segment, run_grouped
from symdyn.analysis.metrics import summarise
from symdyn.gait.library import Gait
from symdyn.policy.file import Policy

FIRST_SEED = 500_000
"""Far from those of symdyn evaluate (0 and up) and of symdyn experiment (1000 and up)."""

_SECONDS = 4.0
_SETTLE_S = 1.5
_SPEEDS = (-1.4, -0.6, 0.45, 0.9, 1.6)
_TURN = (0.7, 0.7)
"""v_x in m/s, yaw rate in rad/s."""
_SIDESTEP = 0.25
_SEQUENCES, _TOP_SPEED = 16, 1.9
_SEQUENCE_S, _HOLD_S = 12.0, 1.5


@dataclass(frozen=True)
class Validation:
    """What came of it; each number is a mean over its runs.

    Attributes:
        gc_stance: share of time that feet are in the wrong state, over every gait and speed.
        identity: share of strides in the commanded gait.
        speed_error: m/s.
        yaw_error: rad/s, of the runs that turn.
        lateral_error: m/s, of the runs that step sideways.
        fell: share of all runs that fell, random sequences included.
    """

    gc_stance: float
    identity: float
    speed_error: float
    yaw_error: float
    lateral_error: float
    fell: float

    @property
    def cost(self) -> float:
        """The number that is minimised: errors in units of what is still good (GC stance 0.05, 0.1 m/s, 0.1 rad/s), and
        a fall in one of a hundred runs, or a stride in twenty of another gait, weighs as much.
        """
        errors = self.gc_stance / 0.05 + (self.speed_error + self.lateral_error) / 0.1 + self.yaw_error / 0.1
        return errors + (1.0 - self.identity) / 0.05 + self.fell / 0.01


def validate(policy: Policy) -> Validation:
    """Judge a policy in every gait that it was trained for, on the nominal robot."""
    gaits = list(policy.gaits.values())
    names, seeds = list(policy.gaits), (FIRST_SEED,)
    straight = protocols.constant_scripts(names, _SPEEDS, seeds, _SECONDS)
    groups = {
        "straight": [script for scripts in straight.values() for script in scripts],
        "turn": [],
        "sidestep": [],
        "random": protocols.random_scripts(_SEQUENCES, names, _TOP_SPEED, _HOLD_S, _SEQUENCE_S, FIRST_SEED),
    }
    low, high = policy.metadata.command_range["yaw_rate"]
    if low < 0.0 < high:
        v, rate = _TURN
        groups["turn"] = [_script(gait, (v, 0.0, sign * rate)) for gait in gaits for sign in (-1.0, 1.0)]
    low, high = policy.metadata.command_range["velocity_y"]
    if low < 0.0 < high:
        v = (0.5, _SIDESTEP, 0.0)
        groups["sidestep"] = [_script(gait, v) for gait in gaits]
    episodes = run_grouped(policy, groups)

    def mean(group: str, key: str, worst: float = 1.0) -> float:
        if not episodes[group]:
            return 0.0  # the policy was not trained for it
        reversal = policy.metadata.time_reversal
        found = [
            summarise(e.recording, e.script.segments[0].gait.name, _SETTLE_S, reversal)[key]
            for e in episodes[group]
            if e.fell_at is None
        ]
        finite = [value for value in found if np.isfinite(value)]
        return float(np.mean(finite)) if finite else worst

    every: list[Episode] = [episode for group in episodes.values() for episode in group]
    return Validation(
        gc_stance=mean("straight", "gc_stance"),
        identity=mean("straight", "gait_identity", worst=0.0),
        speed_error=mean("straight", "speed_error"),
        yaw_error=mean("turn", "yaw_error"),
        lateral_error=mean("sidestep", "y_error"),
        fell=float(np.mean([episode.fell_at is not None for episode in every])),
    )


def _script(gait: Gait, velocity: tuple[float, float, float]) -> Script:
    return Script(f"{gait.name} at {velocity}", (Segment(0.0, gait, velocity),), _SECONDS, FIRST_SEED)
