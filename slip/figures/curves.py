"""The figure of the curves: points by family, each fit with its spread, and the paper's curve, in both units."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from slip.curves.fit import CurveFit, DecayFit, Floats, TimingPoints
from symdyn.figures.plots import GAIT_STYLES
from symdyn.gait.timing import GRAVITY, TimingCurve

FAMILY_STYLES: dict[str, tuple[str, str]] = {
    "PK": ("#7F7F7F", "o"),
    "BG": ("#D55E00", "o"),
    "BE": ("#D55E00", "s"),
    "FG": ("#E69F00", "o"),
    "FE": ("#E69F00", "s"),
    "HG": ("#CC79A7", "o"),
    "HE": ("#CC79A7", "s"),
    "GG": ("#009E73", "o"),
    "GE": ("#009E73", "s"),
    "B": ("#D55E00", "D"),
    "F": ("#E69F00", "D"),
    "H": ("#CC79A7", "D"),
    "G": ("#009E73", "D"),
    "TR": ("#0072B2", "o"),
    "PC": ("#332288", "o"),
}
"""Colour (that of the gait in every other figure) and marker: round (gathered), square (extended) or
on its corner (a torso that does not turn at the apex)."""

_PASSIVE, _CALIBRATED, _PAPER = "black", "#882255", "black"
_OTHER = "#999933"


def curve_figure(
    passive: CurveFit,
    passive_points: TimingPoints,
    calibrated: CurveFit | None = None,
    calibrated_points: TimingPoints | None = None,
    leg_length: float | None = None,
    title: str = "Timing curves",
) -> Figure:
    """Two panels, T* and beta over v*.

    Args:
        passive: fit to orbits.
        passive_points: the orbits, by family.
        calibrated: fit to trials, if there is one.
        calibrated_points: the chosen trials, by gait.
        leg_length: m; adds axes in m/s and s.
        title: of what.
    """
    figure = Figure(figsize=(11.0, 5.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    every = [passive_points] if calibrated_points is None else [passive_points, calibrated_points]
    fastest = max(1.0, *(float(np.abs(points.v_star).max()) for points in every))
    speed = np.linspace(0.0, fastest, 200)
    paper = TimingCurve()
    panels: tuple[tuple[Axes, str, DecayFit, DecayFit | None, Callable[[TimingPoints], Floats], Floats], ...] = (
        (
            left,
            r"stride period $T^*$  [$\sqrt{l/g}$]",
            passive.period,
            None if calibrated is None else calibrated.period,
            lambda points: points.period_star,
            paper.a_T * np.exp(-paper.c_T * speed),
        ),
        (
            right,
            r"duty factor $\beta$  [1]",
            passive.duty,
            None if calibrated is None else calibrated.duty,
            lambda points: points.duty,
            paper.a_beta * np.exp(-paper.c_beta * speed),
        ),
    )
    for axes, label, passive_fit, calibrated_fit, values, papers in panels:
        _points(axes, passive_points, values, family=True)
        _curve(axes, speed, passive_fit, _PASSIVE, "passive fit: orbits of the SLIP")
        if calibrated_fit is not None and calibrated_points is not None:
            _points(axes, calibrated_points, values, family=False)
            _curve(axes, speed, calibrated_fit, _CALIBRATED, "calibrated fit: chosen trials")
        axes.plot(speed, papers, "--", color=_PAPER, linewidth=1.8, label="paper: its own calibration", zorder=4)
        axes.set_xlabel(r"forward speed $|v^*|$  [$\sqrt{g\,l}$]")
        axes.set_ylabel(label)
        axes.set_xlim(0.0, fastest)
        axes.set_ylim(bottom=0.0)
        axes.grid(color="0.9")
        axes.set_axisbelow(True)
        if leg_length is not None:
            unit = math.sqrt(GRAVITY * leg_length)
            _second(axes, "top", unit, f"$|v|$ [m/s] for l = {leg_length:g} m")
    if leg_length is not None:
        _second(left, "right", math.sqrt(leg_length / GRAVITY), "T [s]")
    handles, labels = left.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5, frameon=False, fontsize=9)
    figure.suptitle(f"{title}   (bands: spread $\\pm b|v^*|$)", wrap=True)
    return figure


def _points(axes: Axes, points: TimingPoints, values: Callable[[TimingPoints], Floats], family: bool) -> None:
    for group in dict.fromkeys(points.group):
        some = points.take(np.array([other == group for other in points.group]))
        if family:
            colour, marker = FAMILY_STYLES.get(group, (_OTHER, "o"))
            style = {"marker": marker, "s": 14, "facecolor": colour, "linewidth": 0}
        else:
            colour = GAIT_STYLES.get(group, (_OTHER, "-"))[0]
            style = {"marker": "x", "s": 26, "color": colour, "linewidth": 1.2}
        label = group.replace("_", " ") if family else f"trial: {group.replace('_', ' ')}"
        axes.scatter(np.abs(some.v_star), values(some), label=label, zorder=3, **style)


def _curve(axes: Axes, speed: Floats, fit: DecayFit, colour: str, label: str) -> None:
    axes.fill_between(speed, fit.at(speed, -1.0), fit.at(speed, 1.0), color=colour, alpha=0.12, linewidth=0)
    axes.plot(speed, fit.at(speed), color=colour, linewidth=1.8, label=label, zorder=4)


def _second(axes: Axes, side: Literal["top", "right"], unit: float, label: str) -> None:
    """Another axis on top or right, in units of which the first's have so many."""
    there_and_back = (lambda x: np.multiply(x, unit), lambda x: np.divide(x, unit))
    if side == "top":
        axes.secondary_xaxis("top", functions=there_and_back).set_xlabel(label)
    else:
        axes.secondary_yaxis("right", functions=there_and_back).set_ylabel(label)
