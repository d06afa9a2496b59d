"""``report.md`` and the figures of an evaluation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rl.judging import verdict
from rl.judging.evaluate import Evaluation
from symdyn.figures.plots import footfall_diagram, learning_curves, metric_bars, save, velocity_tracking
from symdyn.io.files import write_json, write_text
from symdyn.io.markdown import number, table

METRICS = "metrics.json"
REPORT = "report.md"

_COLUMNS = {
    "gait_identity": "strides in the gait",
    "phase_error": "phase error, stride",
    "gc_stance": "GC stance",
    "gc": "GC",
    "speed_error": "speed error, m/s",
    "settling_time": "settling time, s",
    "cot": "cost of transport",
    "fell": "fell",
}


def write(evaluation: Evaluation, out: Path, progress: Sequence[Mapping[str, Any]] = (), remark: str = "") -> Path:
    """Write metrics.json, the figures and report.md.

    Args:
        evaluation: what was found.
        out: directory, made if need be.
        progress: records of the training run, for learning curves; empty if there are none.
        remark: a paragraph to stand at the head of the report.

    Returns:
        The report.

    Raises:
        FileProblem: if something cannot be written.
    """
    metrics = evaluation.metrics
    write_json(out / METRICS, metrics)
    figures: dict[str, str] = {}

    def add(name: str, figure: Any, caption: str) -> None:
        save(figure, out / name)
        figures[name] = caption

    label = f"{Path(metrics['policy']).name}, {_samples(metrics)}"
    if evaluation.gaits is not None:
        sequence = metrics["protocol"]["gait_sequence"]
        speed = metrics["protocol"]["gait_sequence_speed"]
        title = f"Footfalls at {speed:g} m/s, two seconds each of {', '.join(sequence)} ({label})"
        add(
            "footfalls.png",
            footfall_diagram(evaluation.gaits.recording, title),
            "Commanded stance (hollow) and measured contact (solid) in the gait sequence, first seed.",
        )
    if evaluation.velocity:
        recordings = {gait: episode.recording for gait, episode in evaluation.velocity.items()}
        add(
            "velocity.png",
            velocity_tracking(recordings, f"Velocity tracking ({label})"),
            "Commanded (dashed) and measured velocity, first seed; a curve ends where the robot fell.",
        )
    for key in ("gc_stance", "gait_identity", "cot"):
        add(f"{key}.png", metric_bars(metrics["gaits"], key), _caption(metrics["keys"][key]))
    if progress:
        add("learning.png", learning_curves(list(progress)), "Training log, with exploration noise.")
    path = out / REPORT
    write_text(path, _markdown(metrics, figures, remark))
    return path


def _caption(meaning: str) -> str:
    """The meaning of a metric as a sentence, without the unit of a bare number."""
    unit, _, text = meaning.partition(": ")
    return f"{text[0].upper()}{text[1:]}{'' if unit == '1' else f' [{unit}]'}."


def _samples(metrics: Mapping[str, Any]) -> str:
    samples = metrics["samples"]
    return "samples unknown" if samples is None else f"{samples / 1e6:.3g}M samples"


def _markdown(metrics: Mapping[str, Any], figures: Mapping[str, str], remark: str) -> str:
    protocol = metrics["protocol"]
    lines = [
        f"# Evaluation of {Path(metrics['policy']).name}",
        "",
        *([remark, ""] if remark else []),
        *_verdict(metrics),
        f"Suite `{metrics['suite']}`, seeds {metrics['seeds']}, trained for {_samples(metrics)}.",
        f"Model: {protocol['model']}. Sampling: {protocol['sampling']}. RMSNE epsilon {protocol['rmsne_epsilon']:g}.",
        "",
        "## Each gait at constant speed",
        "",
        f"{_sentence(protocol['constant'])} Every key is explained in `metrics.json` under `keys`.",
        "",
        *_constant_table(metrics["gaits"]),
    ]
    if metrics["gait_sequence"]:
        lines += ["", "## The paper's gait sequence", "", *_sequence_table(metrics["gait_sequence"])]
    if metrics["velocity_sequence"]:
        lines += ["", "## The paper's velocity sequence", "", *_velocity_table(metrics["velocity_sequence"])]
    if metrics["transitions"]:
        lines += ["", "## Transitions between gaits", "", *_transition_table(metrics["transitions"])]
    if figures:
        lines += ["", "## Figures"]
        for name, caption in figures.items():
            lines += ["", f"![{caption}]({name})", "", caption]
    return "\n".join(lines) + "\n"


def _verdict(metrics: Mapping[str, Any]) -> list[str]:
    """The verdict in words, then the goals, those that are missed first."""
    goals = verdict.targets(metrics)
    rows = [
        [goal.what, number(goal.here), goal.limit, goal.paper, "yes" if goal.met else "**no**"]
        for goal in sorted(goals, key=lambda goal: goal.met)
    ]
    head = ["goal", "here", "limit", "paper", "met"]
    return ["## Verdict", "", verdict.sentence(metrics, goals), "", *table(head, rows), "", "## Protocol", ""]


def _sentence(text: str) -> str:
    return text[0].upper() + text[1:] + "."


def _constant_table(gaits: Mapping[str, Mapping[str, Mapping[str, float | None]]]) -> list[str]:
    rows = [
        [gait, speed, *(number(values.get(key)) for key in _COLUMNS)]
        for gait, by_speed in gaits.items()
        for speed, values in by_speed.items()
    ]
    return table(["gait", "command, m/s", *_COLUMNS.values()], rows)


def _sequence_table(sequence: Mapping[str, Any]) -> list[str]:
    keys = ("gait_identity", "phase_error", "gc_stance", "gc")
    rows = [[gait, *(number(values[key]) for key in keys)] for gait, values in sequence["by_gait"].items()]
    rows.append(["all", "-", "-", number(sequence["gc_stance"]), "-"])
    fell = f"Fell in {sequence['fell']:.0%} of the runs. The paper reports GC stance 0.07."
    return [*table(["gait", *(_COLUMNS[key] for key in keys)], rows), "", fell]


def _velocity_table(sequence: Mapping[str, Any]) -> list[str]:
    keys = ("settling_time", "speed_error", "y_error")
    rows = [
        [gait, step, *(number(values[k]) for k in keys), f"{run['fell']:.0%}"]
        for gait, run in sequence.items()
        for step, values in run["by_step"].items()
    ]
    return table(["gait", "command, m/s", "settling time, s", "speed error, m/s", "v_y error, m/s", "fell"], rows)


def _transition_table(transitions: Sequence[Mapping[str, Any]]) -> list[str]:
    rows = []
    for speed in sorted({t["speed"] for t in transitions}):
        of_speed = [t for t in transitions if t["speed"] == speed]
        within_one = sum(1 for t in of_speed if t["strides_to_switch"] is not None and t["strides_to_switch"] <= 1)
        never = sum(1 for t in of_speed if t["strides_to_switch"] is None)
        fell = sum(1 for t in of_speed if t["fell"])
        rows.append([f"{speed:g}", str(len(of_speed)), str(within_one), str(never), str(fell)])
    head = ["speed, m/s", "ordered pairs", "in the new gait within one stride", "never in the new gait", "fell"]
    return table(head, rows)
