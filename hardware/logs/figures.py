"""The paper's hardware figures from a log, and what a robot's user wants to see besides."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hardware.control.controller import State
from hardware.logs.contents import Bools, Floats, Ticks, Truth
from hardware.logs.metrics import Segment
from hardware.logs.observed import Observed
from hardware.logs.recording import LONGEST_HOLD_S, Run
from symdyn.analysis.metrics import gc_stance, stride_average
from symdyn.figures.plots import GAIT_STYLES, LEG_COLOURS, footfall_bars
from symdyn.gait.symmetry import MIRRORED
from symdyn.robot.legs import LEGS

SHOWN_S = 2.0
"""s of each gait in the figure of contacts."""

_VELOCITIES = ("$v_x$ [m/s]", "$v_y$ [m/s]", "yaw rate [rad/s]")
_TRUE = "#009E73"
_ESTIMATED = "#0072B2"
_SHADE = 0.12
_PLAIN = {"color": "white", "alpha": 0.8, "pad": 1}
_NOTE: dict[str, Any] = {"ha": "right", "va": "bottom", "fontsize": 8, "bbox": _PLAIN}
_THICK, _THIN = 0.36, 0.1
_LETTERS = 130
"""Of the size of gaits' names that fit the width of a figure."""


def label(gait: str) -> str:
    """What to call a gait in a figure or a report."""
    return gait.replace("_", " ")


def contacts(segments: Sequence[Segment], title: str) -> Figure | None:
    """Desired stance (hollow) and contacts (solid), a panel a gait: the last two seconds of its fastest segment.

    Where the truth is known, a black line within the solid bars shows it.

    Args:
        segments: of the log.
        title: what was run.

    Returns:
        None if there is no steady segment.
    """
    shown: dict[str, Segment] = {}
    for segment in (s for s in segments if s.steady):
        so_far = shown.get(segment.gait)
        if so_far is None or _rank(segment) > _rank(so_far):
            shown[segment.gait] = segment
    if not shown:
        return None
    columns = 1 if len(shown) == 1 else 2
    rows = -(-len(shown) // columns)
    figure = Figure(figsize=(6.0 * columns + 0.5, 1.75 * rows + 0.9), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False)
    for axes, (gait, segment) in zip(panels.flat, shown.items(), strict=False):
        run = segment.run
        first = max(0, len(run.gaits) - round(SHOWN_S / run.recording.dt))
        part = run.between(first, len(run.gaits))
        footfall_bars(axes, part.recording)
        if part.truth is not None:
            _bars(axes, part.truth.contact, part.recording.dt, _THIN, ["black"] * len(LEGS))
        wrong = gc_stance(part.recording.contact, part.recording.desired_stance)
        axes.set_title(
            f"{label(gait)}, {segment.command[0]:.1f} m/s, from {part.begin:.1f} s: {wrong:.0%} in the wrong state",
            fontsize=9,
        )
    for axes in panels.flat[len(shown) :]:
        axes.set_axis_off()
    true = ", black line: true contact" if any(s.run.truth is not None for s in shown.values()) else ""
    figure.supxlabel(f"time [s]   (hollow: desired stance, solid: contact as sensed{true})", fontsize=10)
    figure.suptitle(title, wrap=True)
    return figure


def velocity(runs: Sequence[Run], title: str) -> Figure | None:
    """Commanded, estimated and, where it is known, true velocity over time, with the gaits.

    Args:
        runs: of the log.
        title: what was run.

    Returns:
        None if there is no run.
    """
    if not runs:
        return None
    figure = Figure(figsize=(11.0, 6.4), layout="constrained")
    panels = figure.subplots(3, 1, sharex=True, height_ratios=(2, 1, 1))
    for component, (axes, text) in enumerate(zip(panels, _VELOCITIES, strict=True)):
        for run in runs:
            _velocity_lines(axes, run, component)
        axes.set_ylabel(text)
        axes.grid(color="0.9")
        axes.set_axisbelow(True)
    spans = [span for run in runs for span in _gait_spans(run.begin + run.recording.time, run.gaits)]
    _shade(panels, spans)
    panels[-1].set_xlabel("time [s]   (thick: mean over the last stride, thin: as estimated)")
    handles = dict(zip(*reversed(panels[0].get_legend_handles_labels()), strict=True))
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=4, frameon=False)
    figure.suptitle(title, wrap=True)
    return figure


def observed_contacts(observed: Observed, truth: Truth | None, title: str) -> Figure:
    """Contacts of the last two seconds in which the robot moved, or of the log if it never did.

    Args:
        observed: of the log.
        truth: of a simulated robot, or None.
        title: what was run.
    """
    figure = Figure(figsize=(10.0, 2.9), layout="constrained")
    axes = figure.add_subplot()
    moving = np.flatnonzero(observed.moving)
    stop = int(moving[-1]) + 1 if len(moving) else len(observed.time)
    first = max(0, stop - round(SHOWN_S / observed.dt))
    _bars(axes, observed.contact[first:stop], observed.dt, _THICK, list(LEG_COLOURS.values()))
    text = "time [s]   (contact as the robot sensed it"
    if truth is not None:
        nearest = truth.nearest(observed.time[first:stop])
        _bars(axes, truth.contact[nearest], observed.dt, _THIN, ["black"] * len(LEGS))
        text += "; black line: true contact"
    axes.set_yticks(range(len(LEGS)), LEGS)
    axes.set_ylim(len(LEGS) - 0.5, -0.5)
    axes.set_xlim(0.0, (stop - first) * observed.dt)
    axes.set_xlabel(f"{text})")
    axes.set_title(f"{title}, from {observed.time[first]:.1f} s", wrap=True)
    return figure


def observed_velocity(observed: Observed, truth: Truth | None, title: str) -> Figure:
    """Estimated and, where it is known, true velocity over time.

    Args:
        observed: of the log.
        truth: of a simulated robot, or None.
        title: what was run.
    """
    figure = Figure(figsize=(11.0, 6.4), layout="constrained")
    panels = figure.subplots(3, 1, sharex=True, height_ratios=(2, 1, 1))
    for component, (axes, text) in enumerate(zip(panels, _VELOCITIES, strict=True)):
        values = observed.velocity_h[:, component]
        axes.plot(observed.time, values, color=_ESTIMATED, linewidth=0.7, label="estimated")
        if truth is not None:
            axes.plot(truth.time, truth.velocity_h[:, component], color=_TRUE, linewidth=0.7, label="true")
        axes.set_ylabel(text)
        axes.grid(color="0.9")
        axes.set_axisbelow(True)
    panels[-1].set_xlabel("time [s]")
    panels[0].legend(loc="upper left", frameon=False)
    figure.suptitle(title, wrap=True)
    return figure


def timing(ticks: Ticks, found: dict[str, Any], title: str) -> Figure:
    """Age of the state, time between ticks and compute time over time.

    Args:
        ticks: of the log.
        found: hardware.logs.metrics.timing of them.
        title: what was run.
    """
    figure = Figure(figsize=(11.0, 6.0), layout="constrained")
    panels = figure.subplots(3, 1, sharex=True)
    series = {
        "state_age": (ticks.time, ticks.state_age, "state age [ms]"),
        "interval": (ticks.time[1:], np.diff(ticks.time), "tick to tick [ms]"),
        "compute": (ticks.time[:-1], ticks.compute[1:], "compute [ms]"),
    }
    for axes, (key, (time, values, text)) in zip(panels, series.items(), strict=True):
        numbers = found[key]
        axes.plot(time, 1e3 * values, ".", color=_ESTIMATED, markersize=1.5)
        if numbers["max"]:
            axes.set_ylim(0.0, 1.25e3 * numbers["max"])
            told = ", ".join(f"{name} {1e3 * value:.2f}" for name, value in numbers.items())
            axes.text(0.995, 0.95, f"{told} ms", transform=axes.transAxes, **(_NOTE | {"va": "top"}))
        axes.set_ylabel(text)
        axes.grid(color="0.9")
        axes.set_axisbelow(True)
    _shade(panels, _tick_spans(ticks))
    panels[-1].set_xlabel("time [s]")
    figure.suptitle(title, wrap=True)
    return figure


_NOTE: dict[str, Any] = {
    "ha": "right",
    "va": "bottom",
    "fontsize": 8,
    "bbox": {"color": "white", "alpha": 0.8, "pad": 1},
}


def _rank(segment: Segment) -> tuple[float, float]:
    return round(abs(float(segment.command[0])), 1), segment.seconds


def _bars(axes: Axes, contact: Bools, dt: float, height: float, colours: Sequence[str]) -> None:
    """Bars where each leg is in contact, a row a leg."""
    for row, colour in enumerate(colours):
        edges = np.flatnonzero(np.diff(np.concatenate([[False], contact[:, row], [False]])))
        bars = [(first * dt, (last - first) * dt) for first, last in edges.reshape(-1, 2).tolist()]
        axes.broken_barh(bars, (row - height / 2, height), facecolors=colour, linewidth=0)


def _velocity_lines(axes: Axes, run: Run, component: int) -> None:
    estimated = run.recording
    time = run.begin + estimated.time
    views = [(estimated, _ESTIMATED, "estimated")]
    if run.truth is not None:
        views.append((run.truth, _TRUE, "true"))
    for recording, colour, name in views:
        values = recording.velocity_h[:, component]
        average = stride_average(values, recording.period, recording.dt)
        axes.plot(time, average, color=colour, linewidth=1.6, label=name, zorder=3)
    axes.plot(time, estimated.velocity_h[:, component], color=_ESTIMATED, linewidth=0.4, alpha=0.4)
    command = estimated.velocity_command[:, component]
    axes.plot(time, command, "k", linewidth=1.6, dashes=(4, 2), label="commanded", zorder=4)


def _gait_spans(time: Floats, gaits: Sequence[str]) -> Iterator[tuple[float, float, str]]:
    names = np.array(gaits)
    changes = (np.flatnonzero(names[1:] != names[:-1]) + 1).tolist()
    for first, last in pairwise([0, *changes, len(names)]):
        yield float(time[first]), float(time[min(last, len(time) - 1)]), gaits[first]


def _tick_spans(ticks: Ticks) -> list[tuple[float, float, str]]:
    running = np.array(ticks.state) == State.RUN
    return [
        (begin, end, name)
        for begin, end, name in _gait_spans(
            ticks.time, [gait if on else "" for gait, on in zip(ticks.gait, running, strict=True)]
        )
        if name
    ]


def _shade(panels: Sequence[Axes], spans: Sequence[tuple[float, float, str]]) -> None:
    """Colour the gaits' spans, and name them above the first panel."""
    low, high = panels[0].get_xlim()
    for begin, end, gait in spans:
        colour, _ = GAIT_STYLES.get(gait.removesuffix(MIRRORED), ("#7F7F7F", "-"))
        for axes in panels:
            axes.axvspan(begin, end, color=colour, alpha=_SHADE, linewidth=0, zorder=0)
        letters = int(_LETTERS * (end - begin) / (high - low))
        upright = letters < max(map(len, gait.split("_")))
        panels[0].annotate(
            label(gait) if upright else textwrap.fill(label(gait), letters),
            ((begin + end) / 2, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(0, 3),
            textcoords="offset points",
            ha="center",
            va="bottom",
            fontsize=8,
            rotation=90 if upright else 0,
        )


def _parted(time: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Time and values with a nan wherever nothing is known for longer than a line should be drawn across."""
    gaps = np.flatnonzero(np.diff(time) > LONGEST_HOLD_S) + 1
    return np.insert(time, gaps, np.nan), np.insert(values, gaps, np.nan)
