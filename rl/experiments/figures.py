"""Figures of the experiments, in the style of :mod:`symdyn.figures.plots`: a gait has the same colour everywhere."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import EngFormatter
from numpy.typing import NDArray

from symdyn.figures.plots import GAIT_STYLES

Floats = NDArray[np.float64]

VARIANT_STYLES: Mapping[str, tuple[str, str, str]] = {
    "full": ("#0072B2", "-", "o"),
    "no-morphology": ("#D55E00", "--", "s"),
    "no-time-reversal": ("#009E73", "-.", "^"),
}
"""Colour, line and marker of the policies of the ablation."""


def grid_map(
    values: Floats, gaits: Sequence[str], speeds: Sequence[float], label: str, limit: float, at_least: bool
) -> Figure:
    """A number for every gait and speed, as a coloured table (dark is bad); what misses the limit is framed.

    Args:
        values: (gaits, speeds); nan is left white.
        gaits: of the rows.
        speeds: of the columns, m/s.
        label: what the numbers are.
        limit: what each should reach.
        at_least: whether a number should be at least the limit; at most if False.
    """
    figure = Figure(figsize=(1.6 + 0.72 * len(speeds), 1.3 + 0.42 * len(gaits)), layout="constrained")
    axes = figure.add_subplot()
    missing, worst = (1.0 - values, 1.0) if at_least else (values, max(2.0 * limit, float(np.nanmax(values))))
    axes.imshow(missing, cmap="Blues", vmin=0.0, vmax=1.6 * worst, aspect="auto")  # dark is bad, and text stays legible
    for (row, column), value in np.ndenumerate(values):
        missed = not (value >= limit if at_least else value <= limit)
        weight = "bold" if missed else "normal"
        axes.text(column, row, f"{value:.2f}", ha="center", va="center", fontsize=9, fontweight=weight)
        if missed:
            corner = (column - 0.47, row - 0.46)
            axes.add_patch(Rectangle(corner, 0.94, 0.92, fill=False, edgecolor="#D55E00", linewidth=1.8))
    _gait_rows(axes, gaits)
    axes.set_xticks(range(len(speeds)), [f"{speed:g}" for speed in speeds])
    axes.set_xlabel("commanded forward velocity [m/s]")
    axes.set_title(label, fontsize=10, wrap=True)
    return figure


def switch_maps(shares: Mapping[float, Floats], gaits: Sequence[str], title: str) -> Figure:
    """A square for every ordered pair of gaits, a panel a speed.

    Args:
        shares: by speed in m/s, (from, to) share in [0, 1]; nan on the diagonal.
        gaits: of rows and columns.
        title: what was run.
    """
    figure = Figure(figsize=(2.2 + 3.2 * len(shares), 4.6), layout="constrained")
    panels = np.atleast_1d(figure.subplots(1, len(shares), sharey=True))
    for axes, (speed, share) in zip(panels, shares.items(), strict=True):
        axes.imshow(1.0 - share, cmap="Blues", vmin=0.0, vmax=1.6, aspect="auto")
        for (row, column), value in np.ndenumerate(share):
            if np.isfinite(value):
                weight = "normal" if value == 1.0 else "bold"
                axes.text(column, row, f"{value:.1f}", ha="center", va="center", fontsize=9, fontweight=weight)
        axes.set_xticks(range(len(gaits)), [_label(gait) for gait in gaits], rotation=45, ha="right")
        axes.set_title(f"to, at {speed:g} m/s", fontsize=10)
    _gait_rows(panels[0], gaits)
    panels[0].set_ylabel("from")
    figure.suptitle(title, fontsize=11)
    return figure


def cost_curves(
    speeds: Sequence[float], costs: Mapping[str, Floats], paper: Mapping[float, float], title: str
) -> Figure:
    """Cost of transport over speed, a line a gait, with the paper's points.

    Args:
        speeds: m/s.
        costs: by gait, (speeds,).
        paper: by speed in m/s.
        title: what was run.
    """
    figure = Figure(figsize=(8.0, 4.4), layout="constrained")
    axes = figure.add_subplot()
    places, order = np.array(speeds), np.argsort(speeds)
    for gait, cost in costs.items():
        colour, line = GAIT_STYLES[gait]
        for side in (places[order] < 0.0, places[order] > 0.0):
            x, y = places[order][side], cost[order][side]
            label = _label(gait) if side[-1] else None
            axes.plot(x, y, color=colour, linestyle=line, marker="o", markersize=3.5, label=label)
    mean = np.mean(list(costs.values()), axis=0)
    axes.plot(places, mean, "k_", markersize=14, markeredgewidth=2, label="mean over gaits")
    axes.plot(list(paper), list(paper.values()), "kx", markersize=9, markeredgewidth=2, label="paper, mean over gaits")
    axes.set_ylim(0.0)
    axes.set_xlabel("commanded forward velocity [m/s]")
    axes.set_ylabel("cost of transport")
    axes.set_title(title, fontsize=11)
    _finish(axes)
    figure.legend(loc="outside lower center", ncols=4, frameon=False)
    return figure


def ablation_panels(
    speeds: Sequence[float], curves: Mapping[str, Mapping[str, Floats]], labels: Mapping[str, str], title: str
) -> Figure:
    """A panel a metric: each variant's mean over its seeds as a line, each seed as a point.

    Args:
        speeds: m/s.
        curves: by metric, by variant, (seeds, speeds).
        labels: of the metrics.
        title: what was run.
    """
    figure = Figure(figsize=(12.0, 4.0), layout="constrained")
    panels = figure.subplots(1, len(curves))
    handles = {}
    for axes, (key, by_variant) in zip(panels, curves.items(), strict=True):
        for variant, values in by_variant.items():
            colour, line, marker = VARIANT_STYLES[variant]
            (handles[variant],) = axes.plot(speeds, values.mean(axis=0), color=colour, linestyle=line, linewidth=1.8)
            for seed in values:
                axes.plot(speeds, seed, marker, color=colour, markersize=3.5, alpha=0.6)
        axes.set_ylim(0.0)
        axes.set_xlabel("commanded forward velocity [m/s]")
        axes.set_ylabel(labels[key])
        _finish(axes)
    names = [_label(name.replace("-", " ")) for name in handles]
    figure.legend(list(handles.values()), names, loc="outside lower center", ncols=len(handles), frameon=False)
    figure.suptitle(title, fontsize=11)
    return figure


def rate_bars(rates: Mapping[str, float], title: str, what: str) -> Figure:
    """A horizontal bar for each share in [0, 1], with the number at its end."""
    figure = Figure(figsize=(7.5, 1.2 + 0.4 * len(rates)), layout="constrained")
    axes = figure.add_subplot()
    for row, (name, rate) in enumerate(rates.items()):
        axes.barh(row, rate, 0.65, color=GAIT_STYLES[name][0] if name in GAIT_STYLES else "#0072B2")
        axes.text(min(rate, 1.0) + 0.01, row, f"{rate:.1%}", va="center", fontsize=9)
    axes.set_yticks(range(len(rates)), [_label(name) for name in rates])
    axes.invert_yaxis()
    axes.set_xlim(0.0, 1.12)
    axes.set_xlabel(f"share that {what}")
    axes.set_title(title, fontsize=11)
    _finish(axes)
    return figure


def both_ways(shown: Mapping[str, Mapping[str, Mapping[str, float]]], gaits: Sequence[str], title: str) -> Figure:
    """A panel a metric, a pair of bars a gait: forwards and backwards.

    Args:
        shown: by metric's label, by ``forward`` and ``backward``, by gait.
        gaits: in order.
        title: what was run.
    """
    figure = Figure(figsize=(11.0, 4.0), layout="constrained")
    panels = figure.subplots(1, len(shown))
    places = np.arange(len(gaits))
    handles = []
    for axes, (label, ways) in zip(panels, shown.items(), strict=True):
        handles = [
            axes.bar(places + shift, [ways[way][gait] for gait in gaits], 0.38, color=colour, label=way)
            for way, shift, colour in (("forward", -0.2, "#0072B2"), ("backward", 0.2, "#E69F00"))
        ]
        axes.set_xticks(places, [_label(gait) for gait in gaits], rotation=45, ha="right")
        axes.set_ylabel(label)
        _finish(axes)
    figure.legend(handles=handles, loc="outside lower center", ncols=2, frameon=False)
    figure.suptitle(title, fontsize=11)
    return figure


def along_path(rows: Sequence[Mapping[str, Any]], named: Mapping[int, str], title: str) -> Figure:
    """GC stance and touchdown phase error along a path of gaits.

    Args:
        rows: each with ``place``, ``gc_stance``, ``phase_error``.
        named: the gaits at whole places.
        title: what was run.
    """
    figure = Figure(figsize=(7.5, 3.8), layout="constrained")
    axes = figure.add_subplot()
    places = [row["place"] for row in rows]
    axes.plot(places, [row["gc_stance"] for row in rows], "o-", color="#0072B2", label="GC stance")
    axes.plot(
        places, [row["phase_error"] for row in rows], "s--", color="#D55E00", label="touchdown phase error [strides]"
    )
    axes.set_xticks(list(named), [_label(name) for name in named.values()])
    axes.set_ylim(0.0)
    axes.set_xlabel("offsets, from gait to gait")
    axes.set_title(title, fontsize=11)
    axes.legend(frameon=False)
    _finish(axes)
    return figure


def learning(curves: Mapping[str, Sequence[Mapping[str, float]]], title: str) -> Figure:
    """What a budget buys: speed error, GC stance and identity of the deterministic policy over the samples seen.

    Args:
        curves: by run, rows with ``samples``, ``speed_error``, ``gc_stance``, ``gait_identity``.
        title: what was run.
    """
    figure = Figure(figsize=(11.0, 3.8), layout="constrained")
    labels = {"speed_error": "speed error [m/s]", "gc_stance": "GC stance", "gait_identity": "strides in the gait"}
    panels = figure.subplots(1, len(labels))
    colours = list(GAIT_STYLES.values())
    handles = []
    for axes, (key, label) in zip(panels, labels.items(), strict=True):
        handles = [
            axes.plot(
                [row["samples"] for row in rows],
                [row[key] for row in rows],
                "o-",
                color=colours[rank % len(colours)][0],
                markersize=3.5,
                label=name,
            )[0]
            for rank, (name, rows) in enumerate(curves.items())
        ]
        axes.set_ylim(0.0, 1.05 if key == "gait_identity" else None)
        axes.margins(x=0.05)
        axes.xaxis.set_major_formatter(EngFormatter(sep=""))
        axes.set_xlabel("samples")
        axes.set_ylabel(label)
        _finish(axes)
    figure.legend(handles=handles, loc="outside lower center", ncols=4, frameon=False)
    figure.suptitle(title, fontsize=11)
    return figure


def _gait_rows(axes: Axes, gaits: Sequence[str]) -> None:
    axes.set_yticks(range(len(gaits)), [_label(gait) for gait in gaits])


def _finish(axes: Axes) -> None:
    axes.grid(color="0.9")
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def _label(name: str) -> str:
    return name.replace("_", " ")
