"""The panel that says what the robot does: HTML, made anew some times a second."""

from __future__ import annotations

import math
from collections.abc import Iterable
from html import escape

import numpy as np

from rl.viewer.panel import strips
from rl.viewer.panel.last_stride import LastStride
from rl.viewer.panel.strips import Trace
from symdyn.analysis.footfall import NO_GAIT
from symdyn.policy.file import Policy

_FRAME = "padding:2px 12px 8px;font:13px/1.35 system-ui,sans-serif;color:#222;background:#fff"
_TITLE = "font-size:17px;font-weight:600"
_SMALL = "font-size:11.5px;color:#666"
_NOTICE = "min-height:2.7em;margin:4px 0;padding:3px 8px;border-radius:4px"
_CALM, _ALERT = "background:#f1f3f5;color:#444", "background:#fff0ec;color:#9c2a10"


def page(*parts: str) -> str:
    """Parts below each other."""
    return f'<div data-report style="{_FRAME}">{"".join(parts)}</div>'


def paragraph(content: str) -> str:
    """Some words in a panel; ``content`` is HTML."""
    return f'<div style="{_FRAME}">{content}</div>'


def headline(name: str, below: str) -> str:
    """The large line, and a small one."""
    return f'<div style="{_TITLE}">{escape(name)}</div><div style="{_SMALL}">{escape(below)}</div>'


def notice(words: str, alert: bool = False) -> str:
    """What has just happened. It keeps its place when there is nothing to say."""
    return f'<div data-notice style="{_NOTICE};{_ALERT if alert else _CALM}">{escape(words)}</div>'


def footfalls(trace: Trace) -> str:
    """The strip of footfalls, with its legend."""
    legend = "hollow: should stand; solid: stands" if trace.desired is not None else "solid: stands"
    return _part("Footfalls", legend, strips.footfalls(trace))


def velocity(trace: Trace) -> str:
    """The strip of the forward velocity, with its legend."""
    command = "dashed: command; " if trace.command is not None else ""
    legend = f"{command}thick: {trace.averaged}"
    return _part("Speed [m/s]", legend, strips.velocity(trace))


def timing(policy: Policy, command: float, stride: LastStride | None) -> str:
    """The stride on the timing curve, with its legend."""
    picture = strips.timing(policy, command, stride)
    return _part("Timing", "hollow: command; solid: last stride", picture)


def numbers(policy: Policy, gait: str, command: float, stride: LastStride | None) -> str:
    """The last stride beside what was commanded."""
    leg, at = policy.metadata.leg_length, np.array([command])
    period, duty = float(policy.timing.period(at, leg)[0]), float(policy.timing.duty(at, leg)[0])
    found = LastStride(NO_GAIT, *(math.nan,) * 5) if stride is None else stride
    gait_found = "-" if found.gait == NO_GAIT else readable(found.gait)
    rows = (
        (
            "gait",
            "mixture" if ":" in gait else readable(gait),
            gait_found,
            "the gait nearest to the touchdowns",
        ),
        ("speed", f"{command:.2f} m/s", _or_dash(found.speed, ".2f", " m/s"), "mean forward velocity"),
        ("stride period", f"{period:.3f} s", _or_dash(found.period, ".3f", " s"), "from touchdown to touchdown"),
        ("duty factor", f"{duty:.2f}", _or_dash(found.duty, ".2f"), "share of the stride that a foot stands"),
        (
            "GC_stance",
            "0",
            _or_dash(found.gc_stance, ".2f"),
            "share of the time that a foot wrongly stands or swings",
        ),
        ("cost of transport", "", _or_dash(found.cot, ".2f"), "positive mechanical work per weight and distance"),
    )
    return table("Last stride", ("", "command", "measured"), rows)


def table(title: str, head: Iterable[str], rows: Iterable[tuple[str, ...]]) -> str:
    """Rows of words; the last word of each is what it means, for those who let the mouse rest on it."""
    return _part(title, "", _table(head, rows))


def readable(name: str) -> str:
    """A gait's name for people; of a mixture, both gaits and the share."""
    first, *mixed = name.replace("_", " ").split(":")
    if not mixed:
        return first
    second, weight = mixed
    return f"{first} + {float(weight):.0%} {second}"


def _part(title: str, legend: str, content: str) -> str:
    small = f' <span style="{_SMALL}">{escape(legend)}</span>' if legend else ""
    return f'<div style="margin-top:8px"><b>{escape(title)}</b>{small}</div>{content}'


def _table(head: Iterable[str], rows: Iterable[tuple[str, ...]]) -> str:
    cell = "padding:0 6px 0 0;white-space:nowrap"
    top = "".join(f'<td style="{cell};{_SMALL}">{escape(word)}</td>' for word in head)
    body = "".join(
        f'<tr title="{escape(meaning)}">'
        + "".join(f'<td style="{cell}">{escape(word)}</td>' for word in words)
        + "</tr>"
        for *words, meaning in rows
    )
    style = "width:100%;border-collapse:collapse;font-variant-numeric:tabular-nums"
    return f'<table style="{style}"><tr>{top}</tr>{body}</table>'


def _or_dash(value: float, form: str, unit: str = "") -> str:
    return f"{value:{form}}{unit}" if math.isfinite(value) else "-"
