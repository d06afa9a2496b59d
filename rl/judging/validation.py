"""How a run's own checkpoints are compared: short runs on seeds and commands that no reported experiment uses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

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
_SEQUENCES = 16
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
    groups = {
        "straight": [_script(gait, (v, 0.0, 0.0), i) for i, v in enumerate(_SPEEDS) for gait in gaits],
        "turn": [],
        "sidestep": [],
        "random": _random(gaits),
    }
    low, high = policy.metadata.command_range["yaw_rate"]
    if low < 0.0 < high:
        v, rate = _TURN
        groups["turn"] = [_script(gait, (v, 0.0, sign * rate), 10) for gait in gaits for sign in (-1.0, 1.0)]
    low, high = policy.metadata.command_range["velocity_y"]
    if low < 0.0 < high:
        v = (0.5, _SIDESTEP, 0.0)
        groups["sidestep"] = [_script(gait, v, 20) for gait in gaits]
    episodes = run_grouped(policy, groups)

    def mean(group: str, key: str) -> float:
        reversal = policy.metadata.time_reversal
        found = [
            summarise(e.recording, e.script.segments[0].gait.name, _SETTLE_S, reversal)[key]
            for e in episodes[group]
            if e.fell_at is None
        ]
        finite = [value for value in found if np.isfinite(value)]
        return float(np.mean(finite)) if finite else 1.0 if episodes[group] else 0.0

    every: list[Episode] = [episode for group in episodes.values() for episode in group]
    return Validation(
        gc_stance=mean("straight", "gc_stance"),
        identity=mean("straight", "gait_identity"),
        speed_error=mean("straight", "speed_error"),
        yaw_error=mean("turn", "yaw_error"),
        lateral_error=mean("sidestep", "y_error"),
        fell=float(np.mean([episode.fell_at is not None for episode in every])),
    )


def _script(gait: Gait, velocity: tuple[float, float, float], number: int) -> Script:
    return Script(f"{gait.name} at {velocity}", (Segment(0.0, gait, velocity),), _SECONDS, FIRST_SEED + number)


def _random(gaits: Sequence[Gait]) -> list[Script]:
    rng = np.random.default_rng(FIRST_SEED)
    starts = np.arange(0.0, _SEQUENCE_S, _HOLD_S)

    def segment(start: float) -> Segment:
        return Segment(float(start), gaits[int(rng.integers(len(gaits)))], (float(rng.uniform(-1.9, 1.9)), 0.0, 0.0))

    return [
        Script(f"random {i}", tuple(segment(start) for start in starts), _SEQUENCE_S, FIRST_SEED + 100 + i)
        for i in range(_SEQUENCES)
    ]
