"""Vary stride period and duty factor about a policy's own curves, and write down what each costs.

A cell of the sweep is one factor on T and one on beta, with which every gait runs at every speed. After each cell the
table is written anew, whole: what was interrupted goes on where it stopped. Timing, clock, model and metrics are those
of :mod:`rl.judging.simulate` and :mod:`symdyn.analysis.metrics`; a factor is a factor on ``a_T`` or ``a_beta`` of the
curve, so that the clamps of :mod:`symdyn.gait.timing` hold here, too, and the table has the T and beta that were really
commanded.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from itertools import product
from pathlib import Path
from typing import Any

from rl.judging.paper_protocol import SETTLE_S
from rl.judging.simulate import Episode, Script, Segment, run
from rl.judging.sweep_config import CELL, SweepConfig
from symdyn.analysis import metrics, trials
from symdyn.analysis.trials import Trial
from symdyn.errors import FileProblem
from symdyn.gait import library as gaits
from symdyn.io.files import read_json, writable_directory, write_json, write_text
from symdyn.policy.file import Policy

JSON_TABLE = "timing_sweep.json"
CSV_TABLE = "timing_sweep.csv"


def sweep(
    policy: Policy,
    path: Path,
    config: SweepConfig,
    out: Path,
    on_progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Run a sweep, or what is left of it, and write its table.

    Args:
        policy: to run.
        path: its file.
        config: what to try.
        out: directory of the table, made if need be.
        on_progress: called with the trials done and those in all.

    Returns:
        The CSV table; the JSON table, with settings and units, lies beside it.

    Raises:
        InvalidValue: if a factor makes a curve absurd.
        FileProblem: if ``out`` holds a sweep of another policy or of other settings, or cannot be written.
    """
    curves = {
        (period, duty): replace(policy.timing, a_T=policy.timing.a_T * period, a_beta=policy.timing.a_beta * duty)
        for period, duty in config.cells
    }
    settings = _settings(policy, path, config)
    rows = _finished(out / JSON_TABLE, settings)
    writable_directory(out)
    done = {tuple(row[name] for name in CELL) for row in rows}
    scripts = _scripts(config)
    for cell, curve in curves.items():
        if on_progress is not None:
            on_progress(len(rows), config.trials)
        if cell in done:
            continue
        episodes = run(policy.with_timing(curve), scripts)
        rows += [{**_trial(policy, e).as_dict(), **dict(zip(CELL, cell, strict=True))} for e in episodes]
        _write(out, settings, rows)
    if on_progress is not None:
        on_progress(len(rows), config.trials)
    _write(out, settings, rows)  # the CSV table of a sweep that was interrupted between its two files
    return out / CSV_TABLE


def _scripts(config: SweepConfig) -> list[Script]:
    return [
        Script(f"{gait} at {v:g} m/s", (Segment(0.0, gaits.get(gait), (v, 0.0, 0.0)),), config.seconds, seed)
        for gait, v, seed in product(config.gaits, config.speeds, config.seeds)
    ]


def _trial(policy: Policy, episode: Episode) -> Trial:
    (segment,) = episode.script.segments
    recording, fell = episode.recording, episode.fell_at is not None
    found = {} if fell else metrics.summarise(recording, segment.gait.name, SETTLE_S, policy.metadata.time_reversal)
    identity = _number(found.get("gait_identity"))
    return Trial(
        v=segment.velocity[0],
        T=float(recording.period[-1]),
        beta=float(recording.duty[-1]),
        cost_of_transport=_number(found.get("cot")),
        tracking_error=_number(found.get("speed_error")),
        weight=identity or 0.0,
        gait=segment.gait.name,
        seed=episode.script.seed,
        fell=fell,
        gc_stance=_number(found.get("gc_stance")),
        gait_identity=identity,
        samples=len(recording.time),
        leg_length=policy.metadata.leg_length,
    )


def _number(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


def _settings(policy: Policy, path: Path, config: SweepConfig) -> dict[str, Any]:
    """What decides the table, as JSON holds it."""
    return {
        "robot": policy.robot.name,
        "policy": str(path),
        "policy_sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
        "policy_samples": policy.metadata.training.get("samples"),
        "timing": policy.timing.as_dict(),
        "leg_length": policy.metadata.leg_length,
        "model": "nominal: no randomisation, no noise, no pushes; deterministic policy; from a stand",
        "settle_s": SETTLE_S,
        "weight": "gait_identity: share of strides that show the commanded gait; 0 where the robot fell",
        "sweep": {name: list(v) if isinstance(v, tuple) else v for name, v in asdict(config).items()},
    }


def _finished(table: Path, settings: dict[str, Any]) -> list[dict[str, Any]]:
    """The rows of an earlier, interrupted run of the same sweep."""
    if not table.exists():
        return []
    data = read_json(table)
    before = data.get("settings") if isinstance(data, dict) else None
    if not isinstance(before, dict) or not isinstance(data.get("rows"), list):
        raise FileProblem(table, "is not a table of symdyn evaluate --sweep-timing; choose another --out.")
    # a file that has moved is the same policy
    changed = [name for name in settings if name != "policy" and before.get(name) != settings[name]]
    if changed:
        raise FileProblem(
            table, f"contains a sweep with a different {', '.join(changed)}; choose another --out or delete it."
        )
    trials.read(table)
    return data["rows"]


def _write(out: Path, settings: dict[str, Any], rows: Sequence[dict[str, Any]]) -> None:
    document = {
        "format_version": trials.FORMAT_VERSION,
        "settings": settings,
        "columns": {
            **trials.COLUMNS,
            "period_factor": "1: T over that of the policy's curve, before the clamps",
            "duty_factor": "1: beta over that of the policy's curve, before the clamps",
        },
        "rows": list(rows),
    }
    write_json(out / JSON_TABLE, document)
    write_text(out / CSV_TABLE, trials.as_csv(rows))
