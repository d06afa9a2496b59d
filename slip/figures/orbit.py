"""A periodic gait in one figure: footfalls, ground reaction forces, torso and legs over time; phase plots and paths.

Everything over time is shown for two strides, from apex to apex. Left legs are solid, right legs dashed, so that legs
which move together both show.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase, SubFigure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from slip.figures.diagram import described
from slip.model.unknowns import ALPHA, DALPHA, DPHI, DY, PHI, SLIP_LEGS, Y
from slip.orbits.orbit import TO_LEGS, Orbit
from slip.orbits.trajectory import Trajectory, sample
from slip.robot.units import Units
from symdyn.figures.plots import LEG_COLOURS, stance_bars
from symdyn.robot.legs import LEGS, is_left

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

STRIDES = 2
SAMPLES = 400
"""Of a stride."""

_SECOND = "#7F7F7F"
"""Colour of what has its scale on the right."""


@dataclass(frozen=True)
class Scale:
    """What the figure's axes are in: the model's units, or SI.

    Attributes:
        units: None for the model's own.
    """

    units: Units | None

    @property
    def time(self) -> tuple[float, str]:
        """Factor and unit."""
        return (self.units.time, "s") if self.units else (1.0, r"$\sqrt{D/g}$")

    @property
    def rate(self) -> tuple[float, str]:
        """Factor and unit."""
        return (1.0 / self.units.time, "rad/s") if self.units else (1.0, r"$\sqrt{g/D}$")

    @property
    def length(self) -> tuple[float, str]:
        """Factor and unit."""
        return (self.units.length, "m") if self.units else (1.0, "$D$")

    @property
    def speed(self) -> tuple[float, str]:
        """Factor and unit."""
        return (self.units.speed, "m/s") if self.units else (1.0, r"$\sqrt{gD}$")

    @property
    def force(self) -> tuple[float, str]:
        """Factor and unit."""
        return (self.units.force, "N") if self.units else (1.0, "$Mg$")


def orbit_figure(orbit: Orbit, name: str, note: str = "", units: Units | None = None) -> Figure:
    """Everything about one gait.

    Args:
        orbit: it.
        name: of its family, and whatever else the title should say.
        note: what else the caption should say, how the orbit was checked for one.
        units: scale of a robot: all axes are in SI units then.
    """
    path, scale = sample(orbit, SAMPLES + 1), Scale(units)
    figure = Figure(figsize=(12.0, 10.5), layout="constrained")
    upper, lower = _halves(figure, 2, 1, height_ratios=(5.2, 1.3))
    left, right = _halves(upper, 1, 2, width_ratios=(3.0, 1.0))
    footfalls, *over_time = left.subplots(5, 1, sharex=True, height_ratios=(0.9, 1.0, 1.0, 1.0, 1.0))
    factor, unit = scale.time
    stances = orbit.duty_factors * orbit.period
    stance_bars(footfalls, orbit.touchdowns * factor, stances * factor, orbit.period * factor, STRIDES)
    _forces(over_time[0], path, orbit, scale, 1, "vertical force")
    _forces(over_time[1], path, orbit, scale, 0, "horizontal force")
    _torso(over_time[2], path, orbit, scale)
    _legs(over_time[3], path, orbit, scale)
    for axes in over_time:
        for stride in range(1, STRIDES):
            axes.axvline(stride * orbit.period * factor, color="black", linestyle=":", linewidth=1.2)
        _tidy(axes)
    over_time[-1].set_xlabel(f"time [{unit}], {STRIDES} strides of {orbit.period * factor:.4g}")
    footfalls.set_title("stance of each leg", fontsize=10)
    _phase_plots(list(right.subplots(3, 1)), path, scale)
    _paths(lower.subplots(), path, orbit, scale)
    handles = [Line2D([], [], **_style(leg), label=leg) for leg in LEGS]
    left.legend(handles=handles, loc="outside upper right", ncols=4, frameon=False)
    figure.suptitle(f"{name}: {_speed(orbit, scale)}", wrap=True)
    figure.supxlabel(caption(orbit, note), fontsize=9, wrap=True)
    return figure


def _halves(figure: FigureBase, rows: int, columns: int, **ratios: Any) -> tuple[SubFigure, SubFigure]:
    first, second = cast(Any, figure.subfigures(rows, columns, **ratios))
    return first, second


def caption(orbit: Orbit, note: str = "") -> str:
    """What was computed and how well, in two lines."""
    return (
        f"Quadrupedal SLIP, {described(orbit.parameters)}. Unit of length D: the torso, hind hip to front hip. "
        f"Duty factor {orbit.duty_factor:.3f}; energy {orbit.energy:.6g} $MgD$.\n"
        f"Largest residual {orbit.residual_norm:.1e}, energy drift over the stride {orbit.energy_drift:.1e}, "
        f"least force of a standing leg {orbit.least_force:.1e} $Mg$." + (f" {note}" if note else "")
    )


def _speed(orbit: Orbit, scale: Scale) -> str:
    factor, unit = scale.speed
    return f"{orbit.apex_speed * factor:.4g} {unit} at the apex, {orbit.mean_speed * factor:.4g} {unit} on average"


def _style(leg: str) -> dict[str, Any]:
    return {"color": LEG_COLOURS[leg], "linestyle": "-" if is_left(leg) else (0, (4, 2)), "linewidth": 1.7}


def _repeated(time: Vector, values: Matrix, period: float) -> tuple[Vector, Matrix]:
    """Strides one after the other; a gap in between would hide nothing, since apex meets apex."""
    times = np.concatenate([time + k * period for k in range(STRIDES)])
    return times, np.concatenate([values] * STRIDES)


def _forces(axes: Axes, path: Trajectory, orbit: Orbit, scale: Scale, component: int, label: str) -> None:
    time, values = _repeated(path.time, path.force_w[:, list(TO_LEGS), component], orbit.period)
    contact = np.concatenate([path.contact[:, list(TO_LEGS)]] * STRIDES)
    for i, leg in enumerate(LEGS):
        shown = np.where(contact[:, i], values[:, i], np.nan) * scale.force[0]
        axes.plot(time * scale.time[0], shown, **_style(leg))
    axes.axhline(0.0, color="0.6", linewidth=0.8)
    axes.set_ylabel(f"{label}\n[{scale.force[1]}]")


def _torso(axes: Axes, path: Trajectory, orbit: Orbit, scale: Scale) -> None:
    time, state = _repeated(path.time, path.state, orbit.period)
    axes.plot(time * scale.time[0], state[:, Y] * scale.length[0], color="black", linewidth=1.8)
    axes.set_ylabel(f"torso height\n[{scale.length[1]}]")
    other = axes.twinx()
    other.plot(time * scale.time[0], np.degrees(state[:, PHI]), color=_SECOND, linewidth=1.4, linestyle="-.")
    other.set_ylabel("pitch [deg], grey", color=_SECOND)
    other.tick_params(axis="y", colors=_SECOND)
    other.spines["top"].set_visible(False)
    _not_flat(other, 0.1)
    _not_flat(axes, 1e-3)


def _legs(axes: Axes, path: Trajectory, orbit: Orbit, scale: Scale) -> None:
    time, state = _repeated(path.time, path.state, orbit.period)
    for i, leg in enumerate(LEGS):
        theta = np.degrees(state[:, ALPHA[TO_LEGS[i]]] + state[:, PHI])
        axes.plot(time * scale.time[0], theta, **_style(leg))
    axes.set_ylabel("leg to the vertical\n[deg]")
    _not_flat(axes, 0.1)


def _phase_plots(panels: list[Axes], path: Trajectory, scale: Scale) -> None:
    factor, unit = scale.rate
    torso, legs, height = panels
    torso.plot(np.degrees(path.state[:, PHI]), path.state[:, DPHI] * factor, color="black", linewidth=1.6)
    torso.plot(np.degrees(path.state[0, PHI]), path.state[0, DPHI] * factor, "ko", ms=5)
    torso.set_xlabel("pitch [deg]")
    torso.set_ylabel(f"pitch rate [{unit}]")
    torso.set_title("phase plots (dot: apex)", fontsize=10)
    _not_flat(torso, 0.1, "x")
    _not_flat(torso, 0.01 * factor)
    for i, leg in enumerate(LEGS):
        angle, rate = path.state[:, ALPHA[TO_LEGS[i]]], path.state[:, DALPHA[TO_LEGS[i]]]
        legs.plot(np.degrees(angle), rate * factor, **_style(leg))
        legs.plot(np.degrees(angle[0]), rate[0] * factor, "o", color=LEG_COLOURS[leg], ms=5)
    legs.set_xlabel("leg to the torso's normal [deg]")
    legs.set_ylabel(f"its rate [{unit}]")
    _not_flat(legs, 0.1, "x")
    _not_flat(legs, 0.01 * factor)
    height.plot(path.state[:, Y] * scale.length[0], path.state[:, DY] * scale.speed[0], color="black", linewidth=1.6)
    height.plot(path.state[0, Y] * scale.length[0], 0.0, "ko", ms=5)
    height.set_xlabel(f"height [{scale.length[1]}]")
    height.set_ylabel(f"its rate [{scale.speed[1]}]")
    for axes in panels:
        _tidy(axes)
        axes.margins(0.08)
        axes.xaxis.set_major_locator(MaxNLocator(4))
        axes.yaxis.set_label_position("right")
        axes.yaxis.tick_right()
        axes.spines["right"].set_visible(True)
        axes.spines["left"].set_visible(False)


def _paths(axes: Axes, path: Trajectory, orbit: Orbit, scale: Scale) -> None:
    """The torso as a bar at even times, the legs that stand then, and where their feet stand."""
    factor, unit = scale.length
    front, hind = path.hip_w[:, SLIP_LEGS.index("LF")], path.hip_w[:, SLIP_LEGS.index("LH")]
    for i in range(0, len(path.time), SAMPLES // 20):
        torso = np.stack((hind[i], front[i])) * factor
        axes.plot(*torso.T, color="0.35" if i % SAMPLES == 0 else "0.75", linewidth=2.5, solid_capstyle="round")
    for i in range(0, len(path.time), SAMPLES // 40):
        for leg in np.flatnonzero(path.contact[i]):
            line = np.stack((path.hip_w[i, leg], path.foot_w[i, leg])) * factor
            axes.plot(*line.T, color=LEG_COLOURS[SLIP_LEGS[leg]], linewidth=0.9, alpha=0.55, zorder=3)
    axes.plot(path.x * factor, path.state[:, Y] * factor, color="black", linewidth=1.4, zorder=4)
    axes.axhline(0.0, color="0.4", linewidth=1.0, zorder=0)
    lowest, highest = -0.08 * factor, (float(path.hip_w[..., 1].max()) + 0.08) * factor
    middle, reach = 0.5 * orbit.stride_length * factor, (0.5 * abs(orbit.stride_length) + 1.0) * factor
    reach = max(reach, 4.5 * (highest - lowest))
    axes.set_xlim(middle - reach, middle + reach)
    axes.set_ylim(lowest, highest)
    axes.set_aspect("equal")
    axes.set_ylabel(f"height [{unit}]")
    axes.set_xlabel(
        f"one stride of {orbit.stride_length * factor:.4g} {unit}: torso at even times and the legs that stand [{unit}]"
    )
    axes.spines[["top", "right"]].set_visible(False)


def _tidy(axes: Axes) -> None:
    axes.grid(color="0.92")
    axes.set_axisbelow(True)
    axes.spines["top"].set_visible(False)


def _not_flat(axes: Axes, least: float, axis: str = "y") -> None:
    """Limits that do not blow up rounding errors: a range of at least ``least``."""
    low, high = axes.get_ylim() if axis == "y" else axes.get_xlim()
    if high - low < least:
        middle = 0.5 * (low + high)
        set_limits = axes.set_ylim if axis == "y" else axes.set_xlim
        set_limits(middle - 0.5 * least, middle + 0.5 * least)
