"""Judge a policy file: run a suite of protocols and turn the recordings into ``metrics.json``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rl.judging import protocols, summaries
from rl.judging.paper_protocol import GAIT_SEQUENCE, GAIT_SPEED, SETTLE_S
from rl.judging.protocols import Suite
from rl.judging.simulate import Episode, Script, run_grouped
from symdyn.analysis import metrics
from symdyn.gait.library import LIBRARY
from symdyn.io.files import jsonable
from symdyn.policy.file import Policy
from symdyn.robot.fit import Fit


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
    fit: Fit | None = None,
) -> Evaluation:
    """Run a suite.

    Args:
        policy: to judge.
        path: its file, to be named in the results.
        suite: what to run.
        on_progress: called with the episodes done and those in all.
        fit: the machine to judge it on; the nominal robot if None.
    """
    groups: dict[tuple, list[Script]] = {}
    for key, scripts in protocols.constant_scripts(suite.gaits, suite.speeds, suite.seeds, suite.constant_s).items():
        groups["constant", *key] = scripts
    if suite.sequences:
        groups["gaits",] = protocols.gait_scripts(suite.seeds)
        for gait, scripts in protocols.velocity_scripts(suite.gaits, suite.seeds).items():
            groups["velocity", gait] = scripts
    switches = protocols.transition_scripts(
        suite.gaits, suite.transition_speeds, suite.seeds[:1], suite.transition_hold_s
    )
    for key, scripts in switches.items():
        groups["switch", *key] = scripts
    episodes = run_grouped(policy, groups, on_progress, fit=fit)
    constant_runs = {key[1:]: found for key, found in episodes.items() if key[0] == "constant"}
    velocity_runs = {key[1]: found for key, found in episodes.items() if key[0] == "velocity"}
    gait_runs = episodes.get(("gaits",), [])
    reversal = policy.metadata.time_reversal
    table: dict[str, dict[str, Any]] = {gait: {} for gait in suite.gaits}
    for (gait, speed), found in constant_runs.items():
        table[gait][f"{speed:g}"] = summaries.constant(gait, found, reversal)
    result = {
        "suite": suite.name,
        "policy": str(path),
        "samples": policy.metadata.training.get("samples"),
        "seeds": list(suite.seeds),
        "protocol": _describe(suite, fit),
        "gaits": table,
        "transitions": [summaries.transition(key, episodes["switch", *key][0], reversal) for key in switches],
        "velocity_sequence": {
            gait: summaries.velocity_steps(gait, found, reversal) for gait, found in velocity_runs.items()
        },
        "gait_sequence": summaries.gait_steps(gait_runs, reversal) if gait_runs else {},
        "keys": {**metrics.KEYS, **summaries.EXTRA_KEYS},
    }
    first = {gait: found[0] for gait, found in velocity_runs.items()}
    return Evaluation(jsonable(result), first, gait_runs[0] if gait_runs else None)


def _describe(suite: Suite, fit: Fit | None) -> dict[str, Any]:
    which = "nominal" if fit is None else f"the machine of {fit.source} ({fit.place})"
    return {
        "model": f"{which}: no randomisation, no noise, no pushes; deterministic policy; from a stand",
        "sampling": "every physics step (5 ms); contact is a ground reaction force above 1 N",
        "constant": f"each gait at each speed for {suite.constant_s:g} s; "
        f"the first {SETTLE_S:g} s left out of all but settling_time",
        "velocity_sequence": list(protocols.VELOCITY_SEQUENCE) if suite.sequences else [],
        "gait_sequence": list(GAIT_SEQUENCE) if suite.sequences else [],
        "gait_sequence_speed": GAIT_SPEED,
        "transition_speeds": list(suite.transition_speeds),
        "rmsne_epsilon": metrics.RMSNE_EPSILON,
        "candidates_of_gait_identity": list(LIBRARY),
    }
