"""The branch diagram: speed at the apex against stride period, apex height, pitch rate and duty factor.

Left the whole range of speeds, right the neighbourhood of the junctions. Hues are those of Okabe & Ito, which the
colour-blind tell apart: bounds vermilion, half-bounds yellow and purple, gallops green; gathered suspension is the dark
tone of a family, extended suspension the light one. Stable parts are solid and thick, unstable ones thin and dashed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from slip.families.branch import Branch, Diagram, Junction
from slip.model.naming import FAMILIES
from slip.model.parameters import SlipParameters
from slip.model.unknowns import DPHI, DX, LIFTOFF, PERIOD, TOUCHDOWN, Y
from slip.robot.units import Units

Vector = NDArray[np.float64]

FAMILY_COLOURS: Mapping[str, str] = {
    "PK": "#000000",
    "BG": "#C04A00",
    "BE": "#F5905C",
    "FG": "#B08800",
    "FE": "#EBCB3B",
    "HG": "#9B3F86",
    "HE": "#DF9CCB",
    "GG": "#007A58",
    "GE": "#5CCDAA",
    "TR": "#0072B2",
    "PC": "#332288",
    # torso still at the apex: the darkest tone of the family
    "B": "#5E2400",
    "F": "#5A4600",
    "H": "#4A1C40",
    "G": "#003D2C",
}
"""Colour of each family of slip.model.naming.FAMILIES; the hue is the gait's in symdyn.figures.plots."""

_STABLE = {"linewidth": 2.4, "linestyle": "-", "zorder": 3}
_UNSTABLE = {"linewidth": 1.1, "linestyle": (0, (4, 1.6)), "zorder": 2}
_MOST = 0.75
"""Share of the junctions that the neighbourhood shows."""

_AT_REST = 0.05
_MARGIN = 0.12
"""Of the neighbourhood of the junctions, on either side, as a share of their range."""


_LONGEST_COLUMN = 11


@dataclass(frozen=True)
class Quantity:
    """What a row of the diagram shows.

    Attributes:
        label: of the axis.
        unit: symbol of the model's unit.
        si_unit: symbol of the SI unit, for a given scale.
        si_name: name of that unit of slip.robot.units.Units; "" for a number, "rate" for one over time.
    """

    label: str
    unit: str
    si_unit: str
    si_name: str

    def of(self, unknowns: Vector) -> Vector:
        """Its values for gaits (n, 22), (n,)."""
        if self.label == "duty factor":
            period = unknowns[:, [PERIOD]]
            stance = np.mod(unknowns[:, list(LIFTOFF)] - unknowns[:, list(TOUCHDOWN)], period)
            return (stance / period).mean(axis=1)
        return unknowns[:, {"stride period": PERIOD, "apex height": Y, "pitch rate at the apex": DPHI}[self.label]]

    def scale(self, units: Units) -> float:
        """What one unit of the model is in SI."""
        return {"time": units.time, "length": units.length, "rate": 1.0 / units.time, "": 1.0}[self.si_name]


QUANTITIES = (
    Quantity("stride period", r"$\sqrt{D/g}$", "s", "time"),
    Quantity("apex height", "$D$", "m", "length"),
    Quantity("pitch rate at the apex", r"$\sqrt{g/D}$", "rad/s", "rate"),
    Quantity("duty factor", "", "", ""),
)
"""The rows of the diagram. D is the torso length, hind hip to front hip."""


def branch_diagram(diagram: Diagram, title: str | None = None, units: Units | None = None) -> Figure:
    """All branches and junctions.

    Args:
        diagram: it.
        title: what it is of; the parameters if None.
        units: scale of a robot: further axes then show SI units.
    """
    figure = Figure(figsize=(11.0, 12.5), layout="constrained")
    marks = _grouped(diagram.junctions)
    zoom = _neighbourhood(marks, diagram)
    panels = figure.subplots(len(QUANTITIES), 2 if zoom else 1, sharex="col", squeeze=False)
    for row, quantity in enumerate(QUANTITIES):
        for column, axes in enumerate(panels[row]):
            for branch in diagram.branches:
                _draw(axes, branch, quantity)
            for mark in marks:
                axes.plot(*mark.place(quantity), "o", ms=6, mfc="white", mec="black", mew=1.2, zorder=5)
            axes.grid(color="0.92")
            axes.set_axisbelow(True)
            if column == 1:
                _zoom(axes, diagram, quantity, zoom)
            else:
                axes.set_xlim(left=min(0.0, float(axes.get_xlim()[0])))
                axes.set_ylabel(f"{quantity.label}" + (f" [{quantity.unit}]" if quantity.unit else ""))
            if units is not None:
                _si_axes(axes, quantity, units, top=row == 0, right=column == panels.shape[1] - 1)
    for axes in panels[-1]:
        axes.set_xlabel(r"forward speed at the apex [$\sqrt{g D}$]")
    panels[0, 0].set_title("all speeds", fontsize=10)
    if zoom:
        panels[0, 1].set_title("around the junctions", fontsize=10)
    _legend(figure, diagram, marks)
    figure.suptitle(title or f"Gait families of the quadrupedal SLIP: {described(diagram.parameters)}", wrap=True)
    figure.draw_without_rendering()  # places are needed to put the numbers beside the marks
    for row, quantity in enumerate(QUANTITIES):
        shown = _number(panels[row, -1], marks, quantity)
        _number(panels[row, 0], [mark for mark in marks if mark not in shown], quantity)
    return figure


def described(parameters: SlipParameters) -> str:
    """The parameters in a line; those at their neutral value are left out."""
    text = f"k = {parameters.stiffness:.4g}, ks = {parameters.swing_stiffness:.4g}, J = {parameters.pitch_inertia:.4g}"
    for symbol, value, neutral in (
        ("l", parameters.rest_length, 1.0),
        ("lb", parameters.hind_distance, 0.5),
        ("kr", parameters.stiffness_ratio, 1.0),
        ("resting angle", parameters.resting_angle, 0.0),
    ):
        if f"{value:.4g}" != f"{neutral:.4g}":
            text += f", {symbol} = {value:.4g}"
    return text


@dataclass(frozen=True)
class _Mark:
    """Junctions at one orbit."""

    number: int
    junctions: tuple[Junction, ...]

    def place(self, quantity: Quantity) -> tuple[float, float]:
        unknowns = np.array([self.junctions[0].unknowns])
        return float(unknowns[0, DX]), float(quantity.of(unknowns)[0])

    @property
    def text(self) -> str:
        leaving = ", ".join(dict.fromkeys(junction.to for junction in self.junctions))
        return (
            f"{self.number}: {self.junctions[0].on} \N{RIGHTWARDS ARROW} {leaving} at {abs(self.junctions[0].dx):.4f}"
        )


def _grouped(junctions: Sequence[Junction]) -> list[_Mark]:
    groups: list[list[Junction]] = []
    for junction in sorted(junctions, key=lambda j: (j.dx, j.on)):
        for group in groups:
            if np.abs(np.subtract(group[0].unknowns, junction.unknowns)).max() < 1e-5:
                group.append(junction)
                break
        else:
            groups.append([junction])
    return [_Mark(number, tuple(group)) for number, group in enumerate(groups, start=1)]


def _neighbourhood(marks: list[_Mark], diagram: Diagram) -> tuple[float, float] | None:
    """The narrowest range of speeds with most of the junctions, or None if it is nearly everything."""
    speeds = sorted(mark.junctions[0].dx for mark in marks if mark.junctions[0].dx > _AT_REST)
    if not speeds:
        return None
    count = math.ceil(_MOST * len(speeds))
    low, high = min(
        ((speeds[i], speeds[i + count - 1]) for i in range(len(speeds) - count + 1)), key=lambda ends: ends[1] - ends[0]
    )
    margin = max(_MARGIN * (high - low), 0.1)
    whole = max(float(branch.speeds.max()) for branch in diagram.branches)
    return (max(0.0, low - margin), high + margin) if high - low + 2 * margin < 0.8 * whole else None


def _draw(axes: Axes, branch: Branch, quantity: Quantity) -> None:
    colour, values = FAMILY_COLOURS[branch.family], quantity.of(branch.unknowns)
    stable = np.where(branch.stable, values, np.nan)
    # a piece between a stable and an unstable orbit is unstable
    inside = branch.stable & np.append(branch.stable[1:], True) & np.append(True, branch.stable[:-1])
    axes.plot(branch.speeds, np.where(inside, np.nan, values), color=colour, **_UNSTABLE)
    axes.plot(branch.speeds, stable, color=colour, **_STABLE)


def _zoom(axes: Axes, diagram: Diagram, quantity: Quantity, limits: tuple[float, float] | None) -> None:
    if limits is None:
        return
    axes.set_xlim(limits)
    shown = []
    for branch in diagram.branches:
        inside = (branch.speeds >= limits[0]) & (branch.speeds <= limits[1])
        shown.append(quantity.of(branch.unknowns)[inside])
    values = np.concatenate(shown)
    if len(values):
        margin = 0.1 * max(float(np.ptp(values)), 1e-3)
        axes.set_ylim(float(values.min()) - margin, float(values.max()) + margin)


def _si_axes(axes: Axes, quantity: Quantity, units: Units, top: bool, right: bool) -> None:
    if top:
        speed = axes.secondary_xaxis("top", functions=_scaling(units.speed))
        speed.set_xlabel("forward speed at the apex [m/s]")
    if right and quantity.si_unit:
        side = axes.secondary_yaxis("right", functions=_scaling(quantity.scale(units)))
        side.set_ylabel(f"[{quantity.si_unit}]")


def _scaling(factor: float) -> tuple[Callable[[Any], Any], Callable[[Any], Any]]:
    return lambda value: value * factor, lambda value: value / factor


def _legend(figure: Figure, diagram: Diagram, marks: list[_Mark]) -> None:
    families = [
        Line2D([], [], color=FAMILY_COLOURS[name], linewidth=2.4, label=f"{name}: {FAMILIES[name]}")
        for name in diagram.names
    ]
    lines = [
        Line2D([], [], color="0.3", label="stable", **_STABLE),
        Line2D([], [], color="0.3", label="unstable", **_UNSTABLE),
    ]
    junctions = [Line2D([], [], linestyle="", label=mark.text) for mark in marks]
    # a legend fills column by column: two of families and lines, then those of junctions
    rows = max(
        -(-(len(families) + len(lines)) // 2),
        len(junctions) if len(junctions) <= _LONGEST_COLUMN else -(-len(junctions) // 2),
    )
    blank = [Line2D([], [], linestyle="", label="")]
    families += blank * max(0, rows - len(families))
    handles = [*families, *lines, *blank * (2 * rows - len(families) - len(lines)), *junctions]
    columns = -(-len(handles) // rows)
    handles += blank * (columns * rows - len(handles))
    figure.legend(
        handles=handles, loc="outside lower center", ncols=columns, frameon=False, fontsize=9, handlelength=2.2
    )


def _number(axes: Axes, marks: list[_Mark], quantity: Quantity) -> list[_Mark]:
    """Numbers beside the marks that the axes show, where they cover neither a mark nor each other. Returns those."""
    low, high = sorted(axes.get_xlim())
    inside = [mark for mark in marks if low <= mark.place(quantity)[0] <= high]
    places = {mark.number: axes.transData.transform(mark.place(quantity)) for mark in inside}
    scale = axes.figure.dpi / 72.0
    taken = list(places.values())
    for mark in inside:
        best = max(
            (
                (radius * np.cos(angle), radius * np.sin(angle))
                for radius in (9.0, 12.0, 16.0)
                for angle in np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False) + np.pi / 4
            ),
            key=lambda offset: (
                min(
                    11.0,
                    min(
                        float(np.hypot(*(places[mark.number] + np.multiply(offset, scale) - other))) / scale
                        for other in taken
                    ),
                )
                - 0.2 * float(np.hypot(*offset))
            ),
        )
        taken.append(places[mark.number] + np.multiply(best, scale))
        style = {"ha": "center", "va": "center", "fontsize": 9, "fontweight": "bold", "zorder": 6}
        axes.annotate(
            str(mark.number),
            mark.place(quantity),
            xytext=best,
            textcoords="offset points",
            annotation_clip=True,
            **style,
        )
    return inside
