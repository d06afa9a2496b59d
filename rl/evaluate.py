"""Judge a policy file: run a suite of protocols and turn the recordings into ``metrics.json``."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rl import protocols
from rl.protocols import Suite
from rl.simulate import Episode, run
from symdyn import metrics
from symdyn.footfall import cut_strides
from symdyn.gaits import LIBRARY
from symdyn.policy import Policy

SETTLE_S = 1.0
"""s after a change of command that steady-state metrics leave out (the paper: about 1 s to converge)."""

EXTRA_KEYS: Mapping[str, str] = {
    "null": "there is no such number: in at least one seed nothing settled, moved, or lasted long enough to be judged",
    "fell": "share of the seeds in which the robot fell, 0 to 1; the other metrics are over the time before",
    "seconds_to_switch": "s from the switch to the beginning of the first stride run in the new gait; null if never",
    "strides_to_switch": "the same in commanded stride periods",
    "by_step": "for each velocity of the sequence: stride-averaged settling time (s) and steady-state errors (m/s)",
    "by_gait": "for each gait of the sequence: its metrics over its own two seconds",
}
"""Keys of metrics.json beside those of :data:`symdyn.metrics.KEYS`."""


@dataclass(frozen=True)
class Evaluation:
    """A suite's results.

    Attributes:
        metrics: the content of metrics.json.
        velocity: one episode a gait of the velocity sequence, for figures.
        gaits: an episode of the gait sequence, or None.
    """

    metrics: dict[str, Any]
    velocity: dict[str, Episode]
    gaits: Episode | None


def evaluate(
    policy: Policy,
    path: Path,
    suite: Suite,
    on_progress: Callable[[int, int], None] | None = None,
) -> Evaluation:
    """Run a suite.

    Args:
        policy: to judge.
        path: its file, to be named in the results.
        suite: what to run.
        on_progress: called with the episodes done and those in all.
    """
    constant = protocols.constant_scripts(suite)
    velocity = protocols.velocity_scripts(suite) if suite.sequences else {}
    gait_sequence = protocols.gait_scripts(suite) if suite.sequences else []
    transitions = protocols.transition_scripts(suite)
    scripts = [
        *(script for group in constant.values() for script in group),
        *(script for group in velocity.values() for script in group),
        *gait_sequence,
        *transitions.values(),
    ]
    total = len(scripts)
    progress = None if on_progress is None else lambda done: on_progress(done, total)
    left = iter(run(policy, scripts, progress))
    constant_runs = {key: [next(left) for _ in group] for key, group in constant.items()}
    velocity_runs = {key: [next(left) for _ in group] for key, group in velocity.items()}
    gait_runs = [next(left) for _ in gait_sequence]
    transition_runs = {key: next(left) for key in transitions}
    reversal = policy.metadata.time_reversal
    table: dict[str, dict[str, Any]] = {gait: {} for gait in suite.gaits}
    for (gait, speed), episodes in constant_runs.items():
        table[gait][f"{speed:g}"] = _constant(gait, episodes, reversal)
    result = {
        "suite": suite.name,
        "policy": str(path),
        "samples": policy.metadata.training.get("samples"),
        "seeds": list(suite.seeds),
        "protocol": _describe(suite),
        "gaits": table,
        "transitions": [_transition(key, episode, reversal) for key, episode in transition_runs.items()],
        "velocity_sequence": {
            gait: _velocity_steps(gait, episodes, reversal) for gait, episodes in velocity_runs.items()
        },
        "gait_sequence": _gait_steps(gait_runs, reversal) if gait_runs else {},
        "keys": {**metrics.KEYS, **EXTRA_KEYS},
    }
    first = {gait: episodes[0] for gait, episodes in velocity_runs.items()}
    return Evaluation(_jsonable(result), first, gait_runs[0] if gait_runs else None)


def _describe(suite: Suite) -> dict[str, Any]:
    return {
        "model": "nominal: no randomisation, no noise, no pushes; deterministic policy; from a stand",
        "sampling": "every physics step (5 ms); contact is a ground reaction force above 1 N",
        "constant": f"each gait at each speed for {suite.constant_s:g} s; the first {SETTLE_S:g} s left out of all but "
        "settling_time",
        "velocity_sequence": list(protocols.VELOCITY_SEQUENCE) if suite.sequences else [],
        "gait_sequence": list(protocols.GAIT_SEQUENCE) if suite.sequences else [],
        "gait_sequence_speed": protocols.GAIT_SPEED,
        "transition_speeds": list(suite.transition_speeds),
        "rmsne_epsilon": metrics.RMSNE_EPSILON,
        "candidates_of_gait_identity": list(LIBRARY),
    }


def _constant(gait: str, episodes: Sequence[Episode], time_reversal: bool) -> dict[str, float]:
    summaries = [metrics.summarise(e.recording, gait, SETTLE_S, time_reversal) for e in episodes if _long_enough(e)]
    return {**_mean(summaries), "fell": _share_fallen(episodes)}


def _velocity_steps(gait: str, episodes: Sequence[Episode], time_reversal: bool) -> dict[str, Any]:
    by_step = {}
    for i, speed in enumerate(protocols.VELOCITY_SEQUENCE):
        start = i * protocols.VELOCITY_HOLD_S
        parts = [e.recording.between(start, start + protocols.VELOCITY_HOLD_S) for e in episodes]
        whole = [p for p in parts if len(p.time) * p.dt > SETTLE_S + 1.0]
        summary = _mean([metrics.summarise(part, gait, SETTLE_S, time_reversal) for part in whole])
        by_step[f"{speed:g}"] = {
            k: summary.get(k) for k in ("settling_time", "speed_error", "y_error", "gait_identity")
        }
    return {"by_step": by_step, "fell": _share_fallen(episodes)}


def _gait_steps(episodes: Sequence[Episode], time_reversal: bool) -> dict[str, Any]:
    by_gait = {}
    for i, gait in enumerate(protocols.GAIT_SEQUENCE):
        start = i * protocols.GAIT_HOLD_S
        parts = [e.recording.between(start, start + protocols.GAIT_HOLD_S) for e in episodes]
        whole = [p for p in parts if len(p.time) * p.dt > 0.75 * protocols.GAIT_HOLD_S]
        by_gait[gait] = _mean([metrics.summarise(part, gait, 0.0, time_reversal) for part in whole])
    finished = [e for e in episodes if e.fell_at is None]
    stance = [metrics.gc_stance(e.recording.contact, e.recording.desired_stance) for e in finished]
    return {
        "gc_stance": float(np.mean(stance)) if stance else math.nan,
        "by_gait": by_gait,
        "fell": _share_fallen(episodes),
    }


def _transition(key: tuple[str, str, float], episode: Episode, time_reversal: bool) -> dict[str, Any]:
    first, second, speed = key
    switch = episode.script.segments[1].start
    after = episode.recording.between(switch, episode.script.duration)
    seconds, count = math.nan, math.nan
    if len(after.time):
        found = cut_strides(after, time_reversal=time_reversal)
        same = [i for i, name in enumerate(found.gait) if name == second]
        if same:
            seconds = float(found.start[same[0]]) * after.dt
            count = seconds / float(after.period[0])
    return {
        "from": first,
        "to": second,
        "speed": speed,
        "seconds_to_switch": seconds,
        "strides_to_switch": count,
        "gc_stance": metrics.gc_stance(after.contact, after.desired_stance) if len(after.time) else math.nan,
        "fell": float(episode.fell_at is not None),
    }


def _long_enough(episode: Episode) -> bool:
    return episode.fell_at is None or episode.fell_at > SETTLE_S + 1.0


def _share_fallen(episodes: Sequence[Episode]) -> float:
    return float(np.mean([episode.fell_at is not None for episode in episodes]))


def _mean(summaries: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """The mean of each key over runs; not finite (null in the file) if that of any run is not, or if there is none."""
    if not summaries:
        return dict.fromkeys(metrics.KEYS, math.nan)
    return {key: float(np.mean([summary[key] for summary in summaries])) for key in summaries[0]}


def _jsonable(value: Any) -> Any:
    """NaN and infinity are no JSON: null says that there is no such number."""
    if isinstance(value, dict):
        return {key: _jsonable(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_jsonable(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
