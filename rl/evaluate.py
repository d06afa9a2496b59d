"""Judge a policy file: run a suite of protocols and turn the recordings into ``metrics.json``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rl import protocols, summaries
from rl.protocols import Suite
from rl.simulate import Episode, run
from symdyn import metrics
from symdyn.gaits import LIBRARY
from symdyn.policy import Policy


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
        table[gait][f"{speed:g}"] = summaries.constant(gait, episodes, reversal)
    result = {
        "suite": suite.name,
        "policy": str(path),
        "samples": policy.metadata.training.get("samples"),
        "seeds": list(suite.seeds),
        "protocol": _describe(suite),
        "gaits": table,
        "transitions": [summaries.transition(key, episode, reversal) for key, episode in transition_runs.items()],
        "velocity_sequence": {
            gait: summaries.velocity_steps(gait, episodes, reversal) for gait, episodes in velocity_runs.items()
        },
        "gait_sequence": summaries.gait_steps(gait_runs, reversal) if gait_runs else {},
        "keys": {**metrics.KEYS, **summaries.EXTRA_KEYS},
    }
    first = {gait: episodes[0] for gait, episodes in velocity_runs.items()}
    return Evaluation(summaries.jsonable(result), first, gait_runs[0] if gait_runs else None)


def _describe(suite: Suite) -> dict[str, Any]:
    return {
        "model": "nominal: no randomisation, no noise, no pushes; deterministic policy; from a stand",
        "sampling": "every physics step (5 ms); contact is a ground reaction force above 1 N",
        "constant": f"each gait at each speed for {suite.constant_s:g} s; "
        f"the first {summaries.SETTLE_S:g} s left out of all but settling_time",
        "velocity_sequence": list(protocols.VELOCITY_SEQUENCE) if suite.sequences else [],
        "gait_sequence": list(protocols.GAIT_SEQUENCE) if suite.sequences else [],
        "gait_sequence_speed": protocols.GAIT_SPEED,
        "transition_speeds": list(suite.transition_speeds),
        "rmsne_epsilon": metrics.RMSNE_EPSILON,
        "candidates_of_gait_identity": list(LIBRARY),
    }
