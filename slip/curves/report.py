"""What a fit of the curves found, as Markdown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any


def markdown(document: Mapping[str, Any], title: str, figure: str | None = None) -> str:
    """The report of a curves file.

    Args:
        document: :func:`slip.curves.file.document`.
        title: of what.
        figure: file name of the figure, beside the report.
    """
    curves = document["curves"]
    lines = [
        f"# Timing curves: {title}",
        "",
        document["note"],
        "",
        "T* = a_T (1 + b_T delta |v*|) exp(-c_T |v*|), beta alike;",
    ]
    lines += ["v* = v / sqrt(g l), T* = T / sqrt(l / g). Intervals of 95% in brackets.", ""]
    names = [name for name in ("passive", "calibrated", "paper") if name in curves]
    lines += [_row(["", *(_marked(name, document["active"]) for name in names)]), _row(["---"] * (len(names) + 1))]
    for constant in ("a_T", "b_T", "c_T", "a_beta", "b_beta", "c_beta"):
        lines.append(_row([constant, *(_constant(curves[name], constant) for name in names)]))
    for key, label in (
        ("r_squared", "R^2"),
        ("rms", "rms residual"),
        ("largest", "largest residual"),
        ("inside", "points within the spread"),
    ):
        for curve in ("T", "beta"):
            lines.append(_row([f"{label}, {curve}", *(_quality(curves[name], curve, key) for name in names)]))
    lines.append(_row(["points", *(_of_fit(curves[name], "points") for name in names)]))
    lines.append(_row(["of", *(_groups(curves[name]) for name in names)]))
    lines.append(_row(["v* from, to", *(_range(curves[name]) for name in names)]))
    for name in names:
        lines += ["", f"## {name}", "", f"Source: {curves[name]['source']}."]
        fit = curves[name]["fit"]
        if fit is not None:
            lines += ["", f"Intervals: {fit['intervals']}."]
            lines += ["", *(f"- {key}: {_value(value)}" for key, value in curves[name]["data"].items())]
    if figure is not None:
        lines += ["", f"![Points, fits and the paper's curve]({figure})"]
    return "\n".join(lines) + "\n"


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _marked(name: str, active: str) -> str:
    return f"{name} (active)" if name == active else name


def _constant(curve: Mapping[str, Any], name: str) -> str:
    if curve["fit"] is None:
        return f"{curve[name]:.4g}"
    letter, which = name.split("_")
    found = curve["fit"][which][letter]
    return f"{found['value']:.4g} [{found['low']:.4g}, {found['high']:.4g}]"


def _quality(curve: Mapping[str, Any], which: str, key: str) -> str:
    if curve["fit"] is None:
        return "not published"
    value = curve["fit"][which][key]
    return "-" if value is None else f"{value:.3g}"


def _of_fit(curve: Mapping[str, Any], key: str) -> str:
    return "not published" if curve["fit"] is None else str(curve["fit"][key])


def _groups(curve: Mapping[str, Any]) -> str:
    if curve["fit"] is None:
        return "not published"
    return ", ".join(f"{name} {count}" for name, count in curve["fit"]["groups"].items())


def _range(curve: Mapping[str, Any]) -> str:
    if curve["fit"] is None:
        return "not published"
    return "{:.3g}, {:.3g}".format(*curve["fit"]["v_star_range"])


def _value(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.5g}"
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {_value(item)}" for key, item in value.items())
    if isinstance(value, list | tuple):
        return ", ".join(map(_value, value)) or "none"
    return str(value)
