"""Strips of the last seconds as SVG: footfalls, forward velocity, and the stride on the timing curve.

SVG is sharp on every screen, and text of a few kilobytes costs less to make and to send than a picture. Hollow is what
is desired, solid is what is, as in :func:`symdyn.figures.plots.footfall_bars`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rl.viewer.panel import svg
from rl.viewer.panel.last_stride import LastStride
from symdyn.analysis.metrics import stride_average
from symdyn.analysis.recording import Floats, Recording
from symdyn.figures.plots import LEG_COLOURS
from symdyn.policy.file import Policy
from symdyn.robot.legs import LEGS

WINDOW_S = 2.0
"""s that a strip shows: four strides of the slowest, ten of the fastest."""

WIDTH = 320.0
"""Of every drawing, in pixels of a panel that is as wide."""

_LEFT, _RIGHT = 30.0, 4.0
_ROW, _BAR = 19.0, 14.0  # a hollow bar; a solid one is half as high
_SPEED_HEIGHT, _CURVE_HEIGHT = 74.0, 92.0
_LEAST_SPAN = 1.0  # m/s
_INK, _FAINT, _NOW = "#222", "#999", "#B2182B"
_MEASURED = "#0072B2"


@dataclass(frozen=True)
class Trace:
    """What the strips show of the last seconds; the last sample is now.

    Attributes:
        dt: time between samples, s.
        contact: (S, 4) whether a foot bears load.
        velocity: (S,) forward velocity, m/s; nan where nobody knows it.
        average: (S,) the same over the last stride; nan alike.
        desired: (S, 4) whether it should, or None if nobody knows.
        command: (S,) commanded forward velocity, m/s, or None if nobody knows.
        changes: samples at which another gait was commanded.
        averaged: what ``average`` is, for people.
    """

    dt: float
    contact: NDArray[np.bool_]
    velocity: Floats
    average: Floats
    desired: NDArray[np.bool_] | None = None
    command: Floats | None = None
    changes: tuple[int, ...] = ()
    averaged: str = "stride mean"

    @classmethod
    def of(cls, recording: Recording) -> Trace:
        """The last :data:`WINDOW_S` of a recording; longer ones make the first averages whole."""
        average = stride_average(recording.velocity_h[:, 0], recording.period, recording.dt)
        keep = slice(-round(WINDOW_S / recording.dt), None)
        offsets = recording.offsets[keep]
        return cls(
            dt=recording.dt,
            contact=recording.contact[keep],
            velocity=recording.velocity_h[keep, 0],
            average=average[keep],
            desired=recording.desired_stance[keep],
            command=recording.velocity_command[keep, 0],
            changes=tuple((np.flatnonzero((np.diff(offsets, axis=0) != 0.0).any(axis=1)) + 1).tolist()),
        )


def footfalls(trace: Trace) -> str:
    """Desired stance as hollow bars, contacts as solid bars inside them, a row a leg; the right edge is now."""
    parts = []
    height = _ROW * len(LEGS)
    for row, leg in enumerate(LEGS):
        middle = (row + 0.5) * _ROW
        parts.append(svg.text(4.0, middle + 4.0, leg, fill=LEG_COLOURS[leg], font_weight="bold"))
        solid = [_bar(trace, *run, middle, _BAR / 2.0) for run in _runs(trace.contact[:, row])]
        parts.append(svg.mark("g", "".join(solid), fill=LEG_COLOURS[leg]) if solid else "")
        if trace.desired is not None:
            hollow = [_bar(trace, *run, middle, _BAR) for run in _runs(trace.desired[:, row])]
            parts.append(svg.mark("g", "".join(hollow), fill="none", stroke=_INK) if hollow else "")
    for change in trace.changes:
        x = _at(trace, change)
        parts.append(svg.line([(x, 0.0), (x, height)], stroke=_INK, stroke_dasharray="2 2"))
    parts.append(_now(height))
    return svg.picture(WIDTH, height, "".join(parts), "footfalls of the last seconds")


def velocity(trace: Trace) -> str:
    """Commanded (dashed) and measured forward velocity; thick is the mean over the last stride."""
    shown = [v[np.isfinite(v)] for v in (trace.velocity, trace.command) if v is not None]
    low, high = _range(np.concatenate(shown))
    top, bottom = 9.0, _SPEED_HEIGHT - 5.0

    def y(v: float) -> float:
        return bottom - (v - low) / (high - low) * (bottom - top)

    def curve(values: Floats, every: int, **style: str | float) -> str:
        kept = [(i, float(v)) for i, v in enumerate(values) if i % every == 0 or i == len(values) - 1]
        return svg.line([(_at(trace, i + 1), y(v)) for i, v in kept if math.isfinite(v)], **style)

    parts = [_level(v, y(v), WIDTH - _RIGHT) for v in _ticks(low, high)]
    every = max(1, round(0.02 / trace.dt))
    parts.append(curve(trace.velocity, every, stroke=_MEASURED, stroke_width=0.8, opacity=0.45))
    parts.append(curve(trace.average, every, stroke=_MEASURED, stroke_width=2))
    if trace.command is not None:
        parts.append(curve(trace.command, 1, stroke=_INK, stroke_width=1.5, stroke_dasharray="5 3"))
    parts.append(_now(_SPEED_HEIGHT))
    return svg.picture(WIDTH, _SPEED_HEIGHT, "".join(parts), "forward velocity of the last seconds")


def timing(policy: Policy, command: float, stride: LastStride | None) -> str:
    """Stride period and duty factor over speed: the policy's curves, the command (hollow), the last stride (solid)."""
    leg = policy.metadata.leg_length
    low, high = policy.metadata.command_range["velocity_x"]
    speeds = np.linspace(low, high, 61)
    periods, duties = policy.timing.period(speeds, leg), policy.timing.duty(speeds, leg)
    at = np.array([command])
    half = WIDTH / 2.0
    shown = [(stride.speed, stride.period), (stride.speed, stride.duty)] if stride is not None else [None, None]
    panels = (
        ("stride period [s]", periods, float(policy.timing.period(at, leg)[0]), shown[0], 0.0),
        ("duty factor", duties, float(policy.timing.duty(at, leg)[0]), shown[1], half),
    )
    parts = [
        svg.mark("g", _curve(title, speeds, values, (command, wanted), point), transform=f"translate({x:g} 0)")
        for title, values, wanted, point, x in panels
    ]
    return svg.picture(WIDTH, _CURVE_HEIGHT, "".join(parts), "stride period and duty factor over speed")


def _curve(
    title: str, speeds: Floats, values: Floats, wanted: tuple[float, float], point: tuple[float, float] | None
) -> str:
    left, right, top, bottom = _LEFT, WIDTH / 2.0 - 6.0, 16.0, _CURVE_HEIGHT - 16.0
    highest = 1.2 * float(values.max())
    low, high = float(speeds[0]), float(speeds[-1])

    def place(v: float, value: float) -> tuple[float, float]:
        x = left + (v - low) / (high - low) * (right - left)
        return x, bottom - min(value / highest, 1.0) * (bottom - top)

    parts = [svg.text(left, 10.0, title, fill=_INK)]
    parts += [_level(value, place(low, value)[1], right) for value in _ticks(0.0, highest)[1:]]
    parts.append(svg.line([(left, bottom), (right, bottom)], stroke=_FAINT))
    for v, anchor in ((low, "start"), (0.0, "middle"), (high, "end")):
        if low <= v <= high:
            parts.append(svg.text(place(v, 0.0)[0], bottom + 12.0, f"{v:g}", fill=_FAINT, text_anchor=anchor))
    parts.append(
        svg.line([place(float(v), float(value)) for v, value in zip(speeds, values, strict=True)], stroke=_INK)
    )
    if point is not None and all(map(math.isfinite, point)):
        x, y = place(min(max(point[0], low), high), point[1])
        parts.append(svg.mark("circle", cx=x, cy=y, r=4, fill=_MEASURED))
    x, y = place(*wanted)
    parts.append(svg.mark("circle", cx=x, cy=y, r=5.5, fill="none", stroke=_INK, stroke_width=1.5))
    return "".join(parts)


def _at(trace: Trace, sample: int) -> float:
    """Where a sample begins; the end of the last is the right edge, and the left edge is a window before it."""
    ago = (len(trace.contact) - sample) * trace.dt
    return WIDTH - _RIGHT - ago / WINDOW_S * (WIDTH - _RIGHT - _LEFT)


def _bar(trace: Trace, start: int, stop: int, middle: float, height: float) -> str:
    x = _at(trace, start)
    return svg.mark("rect", x=x, y=middle - height / 2.0, width=_at(trace, stop) - x, height=height)


def _now(height: float) -> str:
    x = WIDTH - _RIGHT
    return svg.line([(x, 0.0), (x, height)], stroke=_NOW, stroke_width=1.8)


def _level(value: float, y: float, right: float) -> str:
    grid = svg.line([(_LEFT, y), (right, y)], stroke="#e4e4e4")
    return grid + svg.text(_LEFT - 4.0, y + 3.5, f"{value:g}", fill=_FAINT, text_anchor="end")


def _runs(state: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Where a state, (S,), holds: first sample and sample after the last of every run."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], state, [False]])))
    return [(int(start), int(stop)) for start, stop in edges.reshape(-1, 2)]


def _range(values: Floats) -> tuple[float, float]:
    """Half metres per second around values, at least :data:`_LEAST_SPAN` apart."""
    if not len(values):
        return -_LEAST_SPAN / 2.0, _LEAST_SPAN / 2.0
    low, high = math.floor(2.0 * values.min()) / 2.0, math.ceil(2.0 * values.max()) / 2.0
    if high - low >= _LEAST_SPAN:
        return low, high
    if high <= 0.0:  # towards zero, but not beyond
        high = min(low + _LEAST_SPAN, 0.0)
        return high - _LEAST_SPAN, high
    low = max(high - _LEAST_SPAN, min(low, 0.0))
    return low, low + _LEAST_SPAN


def _ticks(low: float, high: float) -> list[float]:
    """Two to five round numbers in a range."""
    step = next(s for s in (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, math.inf) if (high - low) / s <= 4.0)
    if math.isinf(step):
        return [low, high]
    return [round(k * step, 6) for k in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]
