"""The text of a log's report."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from hardware.control.controller import State
from hardware.control.faults import FAULTS
from hardware.logs import metrics as log_metrics
from hardware.logs.figures import label
from symdyn.io.markdown import number, table
from symdyn.robot.legs import LEGS

_COLUMNS = {
    "gc_stance": "GC stance",
    "gc": "GC",
    "gait_identity": "strides in the gait",
    "phase_error": "phase error, strides",
    "lag_s": "late by, s",
    "speed": "speed, m/s",
    "settling_time": "settling time, s",
    "cot": "cost of transport",
}

_ESTIMATOR = {
    "v_x_rms": "v_x, m/s",
    "v_y_rms": "v_y, m/s",
    "yaw_rate_rms": "yaw rate, rad/s",
    "contact_wrong": "contacts",
}

_PAPER = (
    "The paper's robot (section IV, 0.8 m/s, 5 s per gait) reached the commanded velocity within 1 s; its contacts in "
    "bound and half-bound were off by about 0.1 s."
)


def markdown(metrics: Mapping[str, Any], captions: Mapping[str, str]) -> list[str]:
    """The lines of the report.

    Args:
        metrics: of hardware.logs.report.Analysis.
        captions: of the figures, by file name.
    """
    policy = "The log does not name the policy." if metrics["policy"] is None else f"Policy `{metrics['policy']}`."
    lines = [
        f"# Log {metrics['log']}",
        "",
        f"Begun {metrics['start']}, {metrics['seconds']:.1f} s long. {policy}"
        + (" A dry run: no targets were sent." if metrics["dry"] else ""),
    ]
    if metrics["problems"]:
        lines += ["", *(f"- {problem}" for problem in metrics["problems"])]
    lines += _fault_lines(metrics)
    lines += _segment_lines(metrics)
    if metrics["observed"] is not None:
        lines += ["", "## Motion of the robot", "", *_observed_lines(metrics["observed"])]
    if metrics["timing"] is not None:
        lines += ["", "## Timing", "", *_timing_lines(metrics["timing"])]
    if metrics["timeline"]:
        lines += ["", "## Timeline", "", *_timeline_table(metrics["timeline"])]
    lines += ["", "## Messages", "", *_arrivals_table(metrics["arrivals"])]
    lines += ["", "## Figures"]
    for name, caption in captions.items():
        lines += ["", f"![{caption}]({name})", "", f"*{caption}*"]
    return lines


def segment_rows(metrics: Mapping[str, Any], view: str, keys: Iterable[str]) -> list[list[str]]:
    """A row a segment: gait, command, begin, and metrics, as text.

    Args:
        metrics: of an :class:`Analysis`.
        view: ``robot`` or ``truth``.
        keys: of hardware.logs.metrics.KEYS.
    """
    rows = []
    for segment in metrics["segments"]:
        command = f"{segment['command'][0]:.2f}" if segment["steady"] else "varies"
        values = segment[view]
        cells = ["-" if values is None else number(values[key]) for key in keys]
        rows.append([label(segment["gait"]), command, f"{segment['begin']:.1f}", *cells])
    return rows


def struck(metrics: Mapping[str, Any]) -> list[tuple[float, str]]:
    """Time and text of each fault that sent the robot into damping."""
    before, found = "", []
    for moment in metrics["timeline"]:
        fault = moment["fault"] if moment["state"] == State.DAMP else ""
        if fault and not before:
            found.append((moment["time"], fault))
        before = fault
    return found


def _fault_lines(metrics: Mapping[str, Any]) -> list[str]:
    rows = []
    for time, text in struck(metrics):
        kind = FAULTS.get(text.partition(":")[0])
        rows.append([f"{time:.2f}", text, *((kind.means, kind.help) if kind else ("-", "-"))])
    return ["", "## Faults", "", *table(["time, s", "fault", "usually means", "what to do"], rows)] if rows else []


def _segment_lines(metrics: Mapping[str, Any]) -> list[str]:
    if not metrics["segments"]:
        return []
    head = ["gait", "command, m/s", "from, s", *_COLUMNS.values()]
    lines = [
        "",
        "## Gaits",
        "",
        f"One row per commanded gait and velocity. The first {metrics['settle_s']:g} s of each count only for the "
        "settling time. A dash means that less than "
        f"{log_metrics.LEAST_S:g} s remain. Every key is explained in `metrics.json` under `keys`. {_PAPER}",
    ]
    views = {
        "robot": "Contacts and velocity as estimated on the robot:",
        "truth": "True contacts and velocity of the simulated robot:",
    }
    for view, text in views.items():
        if view == "robot" or any(segment["truth"] for segment in metrics["segments"]):
            lines += ["", text, "", *table(head, segment_rows(metrics, view, _COLUMNS))]
    estimators = [segment for segment in metrics["segments"] if segment["estimator"] is not None]
    if estimators:
        rows = [
            [label(s["gait"]), f"{s['begin']:.1f}", *(number(s["estimator"][key]) for key in _ESTIMATOR)]
            for s in estimators
        ]
        text = "Root mean square error of the estimated velocity, and share of wrong contacts, over whole segments:"
        lines += ["", text, "", *table(["gait", "from, s", *_ESTIMATOR.values()], rows)]
    return lines


def _observed_lines(observed: Mapping[str, Any]) -> list[str]:
    rows = [[leg, number(observed["stride_s"][leg]), number(observed["duty"][leg])] for leg in LEGS]
    return [
        f"It moved for {observed['moving_s']:.1f} s, at {number(observed['speed'])} m/s on average, with a cost of "
        f"transport of {number(observed['cot'])}. In that time:",
        "",
        *table(["leg", "stride, s", "duty factor"], rows),
    ]


def _timing_lines(timing: Mapping[str, Any]) -> list[str]:
    names = {"state_age": "age of the state when used", "interval": "from tick to tick", "compute": "compute"}
    rows = [[text, *(_ms(value) for value in timing[key].values())] for key, text in names.items()]
    return [
        f"{timing['ticks']} ticks of Stand and Run. In all, {timing['overruns']} began more than a tick late.",
        "",
        *table(["ms", *timing["interval"]], rows),
    ]


def _timeline_table(timeline: Sequence[Mapping[str, Any]]) -> list[str]:
    rows = [
        [
            f"{moment['time']:.2f}",
            moment["state"],
            label(moment["gait"]) or "-",
            moment["fault"] or "-",
            "-" if moment["gap"] is None else f"{1e3 * moment['gap']:.0f} ms without a tick",
        ]
        for moment in timeline
    ]
    return table(["time, s", "state", "gait", "fault", "remark"], rows)


def _arrivals_table(arrivals: Mapping[str, Any]) -> list[str]:
    rows = [
        [f"`{channel}`", str(found["messages"]), *(_ms(value) for value in found["interval"].values())]
        for channel, found in arrivals.items()
    ]
    return table(["channel", "messages", "apart, ms: p50", "p99", "max"], rows)


def _ms(seconds: float | None) -> str:
    return "-" if seconds is None else f"{1e3 * seconds:.2f}"
