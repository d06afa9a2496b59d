"""Torque of every joint over the phase of its leg: what a stride looks like, and how much strides differ."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from hardware.control.controller import State
from hardware.estimation.kinematics import JointLimits
from hardware.logs.contents import Floats, Ticks
from hardware.wire.readings import Joints
from symdyn.figures.plots import LEG_COLOURS
from symdyn.gait.phase import leg_phase
from symdyn.gait.symmetry import gait_by_name
from symdyn.robot.legs import LEG_JOINTS, LEGS

_BINS = 50
_QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
_FEWEST = 5
"""Samples of a bin from which quantiles are drawn."""


def torques(time: Floats, joints: Sequence[Joints], ticks: Ticks | None, limits: JointLimits, title: str) -> Figure:
    """Median, half and nine tenths of the torques, a row a kind of joint, a column a leg.

    Args:
        time: (M,) s.
        joints: M readings, at the ticks if there are any.
        ticks: for gait and phase; None if there are none.
        limits: of the robot.
        title: what was run.
    """
    torque = np.array([joint.torque for joint in joints]).reshape(len(time), len(LEGS), len(LEG_JOINTS))
    limit = limits.torque.reshape(len(LEGS), len(LEG_JOINTS))
    over, which = _abscissa(time, ticks)
    across = "phase of the leg [strides]" if over.ndim == 2 else "time [s]"
    figure = Figure(figsize=(11.0, 7.0), layout="constrained")
    panels = figure.subplots(len(LEG_JOINTS), len(LEGS), sharex=True, sharey="row", squeeze=False)
    for column, leg in enumerate(LEGS):
        place = (over[:, column] if over.ndim == 2 else over)[which]
        for row, name in enumerate(LEG_JOINTS):
            axes = panels[row, column]
            _bands(axes, place, torque[which, column, row], LEG_COLOURS[leg])
            bound = limit[column, row]
            for value in (-bound, bound):
                axes.axhline(value, color="black", linestyle="--", linewidth=1.0)
            beyond = float((np.abs(torque[which, column, row]) > bound).mean())
            axes.set_title(f"{leg} {name}: {beyond:.2%} beyond the limit", fontsize=9)
            axes.grid(color="0.9")
            axes.set_axisbelow(True)
            if column == 0:
                axes.set_ylabel(f"{name} [N m]")
            if row == len(LEG_JOINTS) - 1:
                axes.set_xlabel(across)
    legend = "line: median; dark: half of the samples; light: nine tenths; dashed: limit"
    figure.suptitle(f"{title}\n{legend}", fontsize=10)
    return figure


def _abscissa(time: Floats, ticks: Ticks | None) -> tuple[Floats, NDArray[np.bool_]]:
    """Where the samples stand: the phases of the legs, (M, 4), while the policy ran, or else the time, (M,)."""
    running = None if ticks is None else np.array(ticks.state) == State.RUN
    if ticks is None or running is None or not running.any():
        return time, np.ones(len(time), dtype=np.bool_)
    # readings are those of the ticks that name a known one, so that each is at a tick's time
    place = np.searchsorted(ticks.time, time).clip(0, len(ticks) - 1)
    offsets = np.array([gait_by_name(ticks.gait[k]).theta if running[k] else np.zeros(len(LEGS)) for k in place])
    phases = leg_phase(np.asarray(ticks.phase)[place] % 1.0, offsets, np.asarray(ticks.velocity_command)[place, 0])
    return np.asarray(phases), running[place]


def _bands(axes: Axes, place: Floats, values: Floats, colour: str) -> None:
    low, high = float(place.min()), float(place.max())
    edges = np.linspace(low, max(high, low + 1e-9), _BINS + 1)
    number = np.digitize(place, edges[1:-1])
    full = [k for k in range(_BINS) if (number == k).sum() >= _FEWEST]
    if not full:
        axes.plot(place, values, ".", color=colour, markersize=2)
        return
    bands = np.array([np.quantile(values[number == k], _QUANTILES) for k in full]).T
    middle = 0.5 * (edges[:-1] + edges[1:])[full]
    axes.fill_between(middle, bands[0], bands[4], color=colour, alpha=0.25, linewidth=0)
    axes.fill_between(middle, bands[1], bands[3], color=colour, alpha=0.5, linewidth=0)
    axes.plot(middle, bands[2], color=colour, linewidth=1.5)
