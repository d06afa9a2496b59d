"""Figures: footfalls, velocities, learning curves, metrics.

Every function returns a :class:`matplotlib.figure.Figure` of its own. There is no pyplot, hence no global state and no
display; a figure goes into a file through :func:`save`. Colours are those of Okabe & Ito (gaits beyond the paper's have
some of Tol's), which the colour-blind tell apart; a gait has the same colour in every figure.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter
from numpy.typing import NDArray

from symdyn.analysis.metrics import KEYS, stride_average
from symdyn.analysis.recording import Recording
from symdyn.errors import InvalidValue, UnknownName
from symdyn.gait.library import LIBRARY, Gait, nearest, pattern_distance
from symdyn.gait.symmetry import TOLERANCE
from symdyn.io.files import write_with
from symdyn.robot.legs import LEGS

LEG_COLOURS: Mapping[str, str] = dict(zip(LEGS, ("#0072B2", "#E69F00", "#D55E00", "#56B4E9"), strict=True))
"""Left hind blue, left front orange, right front vermilion, right hind light blue: hind legs cold, front legs warm."""

GAIT_STYLES: Mapping[str, tuple[str, str]] = {
    "trot": ("#117733", "-"),
    "bound": ("#882255", "-"),
    "half_bound_left": ("#AA4499", "-"),
    "half_bound_right": ("#E8A6CF", "--"),
    "rotary_gallop": ("#44AA99", "-"),
    "transverse_gallop": ("#A6C36F", "--"),
    "pronk": ("#7F7F7F", "-"),
    "pace": ("#332288", "-"),
    "walk": ("#999933", "-"),
}
"""Colour and line of each gait of the library; the second member of a family is dashed, or hatched, as well."""

_OTHER_COLOURS = ("#332288", "#882255", "#117733", "#AA4499", "#44AA99", "#999933", "#7F7F7F")
_OTHER_LINES = ("-", "--", ":")
_BAR = 0.72
"""Height of a hollow bar, rows; a solid one is half as high."""


def save(figure: Figure, path: Path, dpi: int = 150) -> None:
    """Write a figure, whole or not at all, in the format of the path's suffix.

    Raises:
        InvalidValue: if there is no such format.
        FileProblem: if the file cannot be written.
    """
    formats = figure.canvas.get_supported_filetypes()
    if path.suffix[1:].lower() not in formats:
        raise InvalidValue("The suffix of a figure's path", path.suffix, "one of " + ", ".join(sorted(formats)))
    write_with(path, lambda temporary: figure.savefig(temporary, dpi=dpi))


def footfall_diagram(recording: Recording, title: str) -> Figure:
    """Desired stance as hollow bars, contacts as solid bars inside them, a row a leg, over time.

    Where the commanded gait changes, a line says so and the gait is named above.

    Args:
        recording: what to show, some seconds of it (:meth:`symdyn.analysis.recording.Recording.between`).
        title: what was run.
    """
    figure = Figure(figsize=(10.0, 2.9), layout="constrained")
    axes = figure.add_subplot()
    changes = footfall_bars(axes, recording)
    if changes:
        for start, stop in pairwise([0, *changes, len(recording.time)]):
            middle = (start + stop) / 2 * recording.dt
            axes.text(middle, -0.62, _gait_label(recording.offsets[start]), ha="center", va="bottom", fontsize=9)
        _leg_rows(axes, above=0.45)
    axes.set_xlabel("time [s]   (hollow: desired stance, solid: contact)")
    axes.set_title(title, wrap=True)
    return figure


def footfall_bars(axes: Axes, recording: Recording) -> list[int]:
    """Draw desired stance as hollow bars, contacts as solid bars inside them, a row a leg, over time in s.

    A dotted line stands where the commanded gait changes.

    Args:
        axes: to draw into; its limits are set to the whole recording.
        recording: what to show.

    Returns:
        The first sample of every gait but the first.
    """

    def bars(state: NDArray[np.bool_]) -> list[tuple[float, float]]:
        return [(start * recording.dt, (stop - start) * recording.dt) for start, stop in _runs(state)]

    for row, leg in enumerate(LEGS):
        desired, realised = bars(recording.desired_stance[:, row]), bars(recording.contact[:, row])
        axes.broken_barh(desired, (row - _BAR / 2, _BAR), facecolors="none", edgecolors="black", linewidth=1.0)
        axes.broken_barh(realised, (row - _BAR / 4, _BAR / 2), facecolors=LEG_COLOURS[leg], linewidth=0)
    changes = np.flatnonzero((np.diff(recording.offsets, axis=0) != 0.0).any(axis=1)) + 1
    for change in changes:
        axes.axvline(change * recording.dt, color="black", linestyle=":", linewidth=1.2)
    _leg_rows(axes)
    axes.set_xlim(0.0, len(recording.time) * recording.dt)
    return changes.tolist()


def gait_diagram(gait: Gait, duty: float, strides: int = 2) -> Figure:
    """When each leg stands, over the stride phase, for a robot that moves forwards.

    Args:
        gait: any.
        duty: duty factor in (0, 1).
        strides: how many to show.

    Raises:
        InvalidValue: if the duty factor is not in (0, 1).
    """
    if not 0.0 < duty < 1.0:
        raise InvalidValue("The duty factor", duty, "in (0, 1)")
    figure = Figure(figsize=(5.0, 2.4), layout="constrained")
    axes = figure.add_subplot()
    # stance is where the leg phase phi + theta is in [1 - beta, 1)
    stance_bars(axes, 1.0 - duty - gait.theta, np.full(len(LEGS), duty), strides=strides)
    axes.set_xlabel("stride phase [strides]")
    axes.set_title(f"{_label(gait.name)}, duty factor {duty:.3g}: stance of each leg", wrap=True)
    return figure


def stance_bars(
    axes: Axes, touchdowns: NDArray[np.float64], stances: NDArray[np.float64], period: float = 1.0, strides: int = 2
) -> None:
    """Bars where each leg stands, a row a leg, repeated every stride; a dotted line between strides.

    Args:
        axes: to draw into; its limits are set to 0 and the end of the last stride.
        touchdowns: of each leg, in the order of LEGS, within the first stride or one before it, (4,).
        stances: how long each leg stands, (4,).
        period: of the stride, in the unit of both.
        strides: how many to show.
    """
    for row, (leg, touchdown, stance) in enumerate(zip(LEGS, touchdowns, stances, strict=True)):
        bars = [(touchdown + k * period, stance) for k in range(-1, strides + 1)]
        axes.broken_barh(bars, (row - _BAR / 2, _BAR), facecolors=LEG_COLOURS[leg], linewidth=0)
    for stride in range(1, strides):
        axes.axvline(stride * period, color="black", linestyle=":", linewidth=1.2)
    _leg_rows(axes)
    axes.set_xlim(0.0, strides * period)


def velocity_tracking(recordings: Mapping[str, Recording], title: str) -> Figure:
    """Commanded and realised forward and lateral velocity over time, a colour a gait.

    The thick lines are averages over the last stride, the thin ones the velocity itself.

    Args:
        recordings: by the gait's name, all of the same commanded velocities.
        title: what was run.

    Raises:
        InvalidValue: if there are none.
    """
    if not recordings:
        raise InvalidValue("The number of recordings in a figure", 0, "at least one")
    figure = Figure(figsize=(10.0, 5.6), layout="constrained")
    panels = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    longest = max(recordings.values(), key=lambda recording: len(recording.time))
    handles = []
    for component, (axes, symbol) in enumerate(zip(panels, ("$v_x$", "$v_y$"), strict=True)):
        for rank, (name, recording) in enumerate(recordings.items()):
            colour, line = _style(name, rank)
            velocity = recording.velocity_h[:, component]
            axes.plot(recording.time, velocity, color=colour, linewidth=0.5, alpha=0.35)
            average = stride_average(velocity, recording.period, recording.dt)
            (handle,) = axes.plot(recording.time, average, color=colour, linestyle=line, label=_label(name), zorder=3)
            handles.append(handle)
        command = longest.velocity_command[:, component]
        (handle,) = axes.step(
            longest.time, command, "k--", where="post", linewidth=1.8, label="command", zorder=4, dashes=(4, 2)
        )
        handles.append(handle)
        axes.set_ylabel(f"{symbol} [m/s]")
        axes.grid(color="0.9")
        axes.set_axisbelow(True)
    panels[1].set_xlabel("time [s]   (thick: mean over the last stride, thin: as measured)")
    panels[1].set_xlim(0.0, float(longest.time[-1]))
    figure.legend(handles=handles[: len(recordings) + 1], loc="outside lower center", ncols=4, frameon=False)
    figure.suptitle(title, wrap=True)
    return figure


def learning_curves(records: Sequence[Mapping[str, Any]], title: str = "Training") -> Figure:
    """Reward, velocity error, episode length, action noise and every reward term over the samples seen.

    Args:
        records: one an update, as ``progress.jsonl`` has them: ``samples`` and any of ``reward/total``,
            ``task/x_velocity_error``, ``episode/seconds``, ``learn/action_std`` and ``reward/TERM``.
        title: which run.
    """
    figure = Figure(figsize=(10.0, 8.4), layout="constrained")
    grid = figure.add_gridspec(3, 2, height_ratios=(1, 1, 1.5))
    panels = {
        "reward/total": "reward a step",
        "task/x_velocity_error": r"$|v_x - v_x^\mathrm{cmd}|$ [m/s]",
        "episode/seconds": "episode [s]",
        "learn/action_std": "std. dev. of actions",
    }
    for place, (key, label) in enumerate(panels.items()):
        axes = figure.add_subplot(grid[place // 2, place % 2])
        _curve(axes, records, key, color="black", linewidth=1.2)
        axes.set_ylabel(label)
    axes = figure.add_subplot(grid[2, :])
    terms = sorted({key for record in records for key in record if key.startswith("reward/")} - {"reward/total"})
    for rank, key in enumerate(terms):
        colour, line = _other_style(rank)
        label = _label(key.removeprefix("reward/"))
        _curve(axes, records, key, color=colour, linestyle=line, linewidth=1.2, label=label)
    axes.set_ylabel("weighted reward terms")
    axes.set_xlabel("samples")
    if terms:
        figure.legend(loc="outside lower center", ncols=5, frameon=False)
    last = max((record["samples"] for record in records), default=0)
    for axes in figure.axes:
        axes.set_xlim(0, max(last, 1))
        axes.xaxis.set_major_formatter(EngFormatter(sep=""))
        axes.grid(color="0.9")
        axes.set_axisbelow(True)
    updates = "1 update" if len(records) == 1 else f"{len(records)} updates"
    figure.suptitle(f"{title}: {updates}, {EngFormatter(places=1, sep='')(last)} samples", wrap=True)
    return figure


def metric_bars(
    metrics: Mapping[str, Mapping[Any, Mapping[str, float | None]]], key: str, title: str | None = None
) -> Figure:
    """One metric, a group of bars a commanded speed, a bar a gait.

    A value that is infinite, nan or None has no bar but is written out.

    Args:
        metrics: by gait, by commanded speed in m/s, what :func:`symdyn.analysis.metrics.summarise` returns. Speeds may
            be text, as they are when read from JSON.
        key: of :data:`symdyn.analysis.metrics.KEYS`.
        title: what was run; the metric's meaning if None.

    Raises:
        UnknownName: if there is no such metric.
    """
    if key not in KEYS:
        raise UnknownName("metric", key, KEYS)
    unit, _, meaning = KEYS[key].partition(": ")
    values_of = {gait: {float(v): found for v, found in by_speed.items()} for gait, by_speed in metrics.items()}
    speeds = sorted({speed for by_speed in values_of.values() for speed in by_speed})
    figure = Figure(figsize=(max(6.0, 1.5 + 0.22 * len(metrics) * len(speeds)), 4.2), layout="constrained")
    axes = figure.add_subplot()
    width = 0.8 / max(len(metrics), 1)
    for rank, (gait, by_speed) in enumerate(values_of.items()):
        colour, line = _style(gait, rank)
        places = np.array([k + (rank - (len(metrics) - 1) / 2) * width for k in range(len(speeds))])
        values = np.array([by_speed.get(speed, {}).get(key) for speed in speeds], dtype=np.float64)  # None is nan
        shown = np.isfinite(values)
        hatch = "" if line == "-" else "////"
        axes.bar(places[shown], values[shown], width, color=colour, hatch=hatch, edgecolor="white", label=_label(gait))
        for place, value in zip(places[~shown], values[~shown], strict=True):
            text = "n/a" if math.isnan(value) else "inf"
            style = {"color": colour, "fontsize": 8, "rotation": 90, "ha": "center", "va": "bottom"}
            axes.annotate(text, (place, 0.0), xytext=(0, 3), textcoords="offset points", **style)
    axes.axhline(0.0, color="black", linewidth=0.8)
    axes.set_xticks(range(len(speeds)), [f"{speed:g}" for speed in speeds])
    axes.set_xlim(-0.55, max(len(speeds), 1) - 0.45)
    axes.set_xlabel("commanded forward velocity [m/s]")
    axes.set_ylabel(key if unit == "1" else f"{key} [{unit}]")
    axes.grid(axis="y", color="0.9")
    axes.set_axisbelow(True)
    if metrics:
        figure.legend(loc="outside lower center", ncols=3, frameon=False)
    axes.set_title(title or f"{key}: {meaning}", fontsize=10, wrap=True)
    return figure


def _runs(state: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Where a state, (S,), holds: first sample and sample after the last of every run."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], state, [False]])))
    return [(int(start), int(stop)) for start, stop in edges.reshape(-1, 2)]


def _leg_rows(axes: Axes, above: float = 0.0) -> None:
    axes.set_yticks(range(len(LEGS)), LEGS)
    axes.set_ylim(len(LEGS) - 0.5, -0.5 - above)
    axes.tick_params(axis="y", length=0)
    axes.spines[["top", "right"]].set_visible(False)


def _label(name: str) -> str:
    return name.replace("_", " ")


def _style(gait: str, rank: int) -> tuple[str, str]:
    return GAIT_STYLES[gait] if gait in LIBRARY else _other_style(rank)


def _other_style(rank: int) -> tuple[str, str]:
    lines, colours = len(_OTHER_LINES), len(_OTHER_COLOURS)
    return _OTHER_COLOURS[rank % colours], _OTHER_LINES[rank // colours % lines]


def _gait_label(offsets: NDArray[np.float64]) -> str:
    """What to call offsets, (4,)."""
    name = nearest(offsets[None])[0]
    close = pattern_distance(offsets, LIBRARY[name].theta) <= TOLERANCE
    return _label(name) if close else "(no gait of the library)"


def _curve(axes: Axes, records: Sequence[Mapping[str, Any]], key: str, **style: Any) -> None:
    having = [record for record in records if key in record]
    marker = "o" if len(having) == 1 else ""
    axes.plot([r["samples"] for r in having], [r[key] for r in having], marker=marker, clip_on=not marker, **style)
