"""A study over parameters: a grid of models, the families of each, and their timing curves in one table.

Tracing is the work of a cell (slip.curves.cells), kept in a file of its own; the curves are fitted afterwards from all
files, so that another selection of orbits needs no new tracing.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from slip.curves.cells import cell
from slip.curves.fit import fit_curves
from slip.curves.parallel import Outcome
from slip.curves.points import PassiveOrbits
from slip.curves.settings import SYMBOLS, Grid, Selection
from slip.model.parameters import SlipParameters
from symdyn.errors import SymdynError
from symdyn.io.files import write_text

COLUMNS = (
    "name", *SYMBOLS, "status", "reason", "seconds", "families", "orbits", "stable", "points",
    "a_T", "b_T", "c_T", "r2_T", "a_beta", "b_beta", "c_beta", "r2_beta", "T_slowest", "beta_slowest",
)  # fmt: skip
"""Of the summary table. ``slowest`` is the slowest of the selected orbits."""


def cells(grid: Grid, base: SlipParameters, fastest: float, trot: bool, carry: bool) -> dict[str, dict[str, Any]]:
    """The work of a study, by name. Raises InvalidValue."""
    return {name: cell(model, fastest, trot, carry) for name, model in grid.models(base).items()}


def summary(outcomes: Mapping[str, Outcome], selection: Selection) -> list[dict[str, Any]]:
    """A row a cell, with the columns of :data:`COLUMNS`.

    Args:
        outcomes: of :func:`slip.curves.cells.trace_cell`.
        selection: orbits that the curves are fitted to.
    """
    return [{"name": name, **_row(outcome, selection)} for name, outcome in outcomes.items()]


def write(path: Path, rows: list[dict[str, Any]]) -> None:
    """The summary as CSV, whole or not at all; what does not exist is empty. Raises FileProblem."""
    stream = io.StringIO()
    writer = csv.DictWriter(stream, COLUMNS, restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_text(path, stream.getvalue())


def _row(outcome: Outcome, selection: Selection) -> dict[str, Any]:
    parameters = outcome.cell["parameters"]
    row: dict[str, Any] = {symbol: parameters[name] for symbol, name in SYMBOLS.items()}
    row |= {"status": outcome.status, "seconds": round(outcome.seconds, 3)}
    if outcome.result is None:
        return {**row, "reason": outcome.reason}
    orbits = PassiveOrbits.from_dict(outcome.result["orbits"])
    row |= {
        "families": " ".join(dict.fromkeys(orbits.family)),
        "orbits": len(orbits.family),
        "stable": int(orbits.stable.sum()),
    }
    try:
        points = orbits.select(selection)
        row["points"] = len(points)
        slowest = abs(points.v_star).argmin()
        row |= {"T_slowest": float(points.period_star[slowest]), "beta_slowest": float(points.duty[slowest])}
        fit = fit_curves(points)
    except SymdynError as error:
        return {**row, "reason": f"no fit: {error}"}
    for curve, name in ((fit.period, "T"), (fit.duty, "beta")):
        row |= {f"{letter}_{name}": getattr(curve, letter).value for letter in "abc"}
        row[f"r2_{name}"] = "" if curve.r_squared is None else curve.r_squared
    return row
