"""What a budget buys: the deterministic policy of every checkpoint that a training run kept."""

from __future__ import annotations

import math
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from rl.experiments import figures
from rl.experiments.result import Result, Subject
from rl.judging import protocols, summaries
from rl.judging.paper_protocol import SETTLE_S
from rl.learning import checkpoint, run_dir
from rl.learning.export import export_policy
from symdyn.errors import InvalidValue
from symdyn.gait.library import PAPER_GAITS
from symdyn.policy.file import Policy

SPEEDS = (-1.7, -1.0, -0.5, -0.2, 0.2, 0.5, 1.0, 1.7)
"""m/s."""

SECONDS = 5.0
_KEYS = ("speed_error", "gc_stance", "gait_identity", "phase_error", "fell")


def checkpoints(runs: tuple[Path, ...]) -> dict[Path, list[Path]]:
    """The checkpoints that each run kept, oldest first.

    Raises:
        InvalidValue: if no run is given.
        FileProblem: if one is no run.
    """
    if not runs:
        raise InvalidValue("--learning", "nothing", "one or more runs of symdyn train, trained with --keep-every N")
    return {run: checkpoint.list_checkpoints(run_dir.existing(run)) for run in runs}


def run(subject: Subject, speeds: tuple[float, ...] = SPEEDS) -> Result:
    """Every kept checkpoint of the subject's learning runs, each gait at each speed; raises as :func:`checkpoints`."""
    chosen = checkpoints(subject.learning)
    scripts = protocols.constant_scripts(PAPER_GAITS, speeds, subject.seeds[:1], SECONDS)
    total = sum(len(files) for files in chosen.values())
    curves: dict[str, list[dict[str, float]]] = {}
    done = 0
    for training_run, files in chosen.items():
        rows = curves[training_run.name] = []
        for file in files:
            rows.append(_judged(subject, training_run, file, scripts))
            done += 1
            subject.watch(done, total)
    return Result(
        name="learning",
        title="What does a budget buy?",
        protocol=f"Each gait at {', '.join(f'{v:g}' for v in speeds)} m/s for {SECONDS:g} s from a stand, seed "
        f"{subject.seeds[0]}, the first {SETTLE_S:g} s left out; nominal model, deterministic policy of each "
        "checkpoint that the run kept. Samples count those of the run that it was started from.",
        metrics={"runs": curves},
        figures={
            "learning.png": (
                figures.learning(curves, "What a budget buys"),
                "Mean over gaits and speeds, one initial phase.",
            )
        },
    )


def _judged(subject: Subject, training_run: Path, file: Path, scripts: dict) -> dict[str, float]:
    with tempfile.TemporaryDirectory() as folder:
        policy = Policy.load(export_policy(training_run, Path(folder) / "policy.onnx", (file,)), subject.policy.robot)
    its = replace(subject, policy=policy, watch=lambda done, total: None)
    found = [
        summaries.constant(gait, episodes, its.time_reversal) for (gait, _), episodes in its.simulate(scripts).items()
    ]
    samples = float(policy.metadata.training["samples"])
    return {"samples": samples} | {key: _mean([row[key] for row in found]) for key in _KEYS}


def _mean(values: list[float]) -> float:
    """The mean of those that are numbers: an untrained robot takes no strides that could be judged."""
    known = [value for value in values if math.isfinite(value)]
    return float(np.mean(known)) if known else math.nan
