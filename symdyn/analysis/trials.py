"""The table of trials from which timing curves are calibrated: what was commanded, what it cost, how well it went.

``symdyn evaluate --sweep-timing`` writes it, ``symdyn fit-curves --trials`` reads it; a table of one's own will do if
it has the columns of :data:`REQUIRED`. CSV with a head line, or JSON with the rows under ``rows``. Other columns are
ignored. An empty cell (null in JSON) says that there is no such number: the robot fell, or did not move.
"""

from __future__ import annotations

import csv
import hashlib
import io
import math
import reprlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from symdyn.errors import FileProblem
from symdyn.io.files import read_json

FORMAT_VERSION = 1

COLUMNS: Mapping[str, str] = MappingProxyType(
    {
        "v": "m/s: commanded forward velocity",
        "T": "s: commanded stride period",
        "beta": "1: commanded duty factor",
        "cost_of_transport": "1: positive mechanical work per weight and distance; empty if there is no such number",
        "tracking_error": "m/s: distance of the mean forward velocity from the command; empty alike",
        "weight": "1: how much the row counts in a fit, >= 0",
        "gait": "name of the commanded gait; rows of different gaits are never compared in cost",
        "seed": "of the initial stride phase",
        "fell": "1 if the robot fell, 0 if it did not",
        "gc_stance": "1: share of time that feet are in the wrong contact state; 0 is perfect",
        "gait_identity": "1: share of strides that show the commanded gait",
        "samples": "number of recorded samples (physics steps) behind the row",
        "leg_length": "m: the length that makes v and T non-dimensional",
    }
)
"""Columns in their order, as ``unit: meaning``."""

REQUIRED = ("v", "T", "beta", "cost_of_transport", "tracking_error", "weight")

_TRUTHS = {"0": False, "false": False, "no": False, "1": True, "true": True, "yes": True}
_ALIASES = {"cot": "cost_of_transport"}


@dataclass(frozen=True)
class Trial:
    """A row of the table: one robot under one constant command. Units as in :data:`COLUMNS`.

    Attributes:
        v: commanded forward velocity, m/s.
        T: commanded stride period, s.
        beta: commanded duty factor.
        cost_of_transport: None if there is no such number.
        tracking_error: m/s, or None.
        weight: of the row in a fit.
        gait: name of the commanded gait, or empty.
        seed: of the initial stride phase, or None.
        fell: whether the robot fell.
        gc_stance: or None.
        gait_identity: or None.
        samples: recorded samples behind the row, or None.
        leg_length: m, or None if the table does not say.
    """

    v: float
    T: float
    beta: float
    cost_of_transport: float | None
    tracking_error: float | None
    weight: float
    gait: str = ""
    seed: int | None = None
    fell: bool = False
    gc_stance: float | None = None
    gait_identity: float | None = None
    samples: int | None = None
    leg_length: float | None = None

    def as_dict(self) -> dict[str, Any]:
        """By column, as JSON holds it."""
        return asdict(self)


def as_csv(rows: Sequence[Mapping[str, Any]]) -> str:
    """Rows as CSV text: the columns of :data:`COLUMNS`, then what else the first row has. Numbers are exact."""
    names = [*COLUMNS, *(key for key in (rows[0] if rows else {}) if key not in COLUMNS)]
    stream = io.StringIO()
    writer = csv.DictWriter(stream, names, lineterminator="\n")
    writer.writeheader()
    writer.writerows({name: _cell(row[name]) for name in names} for row in rows)
    return stream.getvalue()


def read(path: Path) -> list[Trial]:
    """The trials of a table, CSV or (by its suffix) JSON.

    Raises:
        FileProblem: if the file is missing or no table, lacks a required column, holds no row, or a cell is no sound
            number; it names line (in JSON: row) and column.
    """
    records = _json_records(path) if path.suffix.lower() == ".json" else _csv_records(path)
    trials = [_Record(record, place, path).trial() for place, record in records]
    if not trials:
        raise FileProblem(path, "contains no trials.")
    return trials


def provenance(path: Path) -> dict[str, Any]:
    """Where a table that :func:`read` has read comes from: its name and digest, and the policy if it is JSON that says.

    Raises:
        FileProblem: if the file cannot be read.
    """
    try:
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError as error:
        raise FileProblem(path, f"cannot be read: {error.strerror or error}.") from error
    found: dict[str, Any] = {"table": str(path), "table_sha256": digest}
    settings = read_json(path).get("settings") if path.suffix.lower() == ".json" else None
    if isinstance(settings, dict):
        found |= {
            key: settings[key] for key in ("robot", "policy", "policy_sha256", "policy_samples") if key in settings
        }
    return found


def _cell(value: Any) -> str:
    if value is None:
        return ""
    return str(int(value)) if isinstance(value, bool) else str(value)


def _csv_records(path: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise FileProblem(path, f"cannot be read: {error.strerror or error}.") from error
    except ValueError as error:
        raise FileProblem(path, f"is not a text file ({error}).") from error
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    try:
        head = _names(next(reader, []), path)
        for row in reader:
            if not row or not any(cell.strip() for cell in row):
                continue
            if len(row) != len(head):
                raise FileProblem(path, f"line {reader.line_num} has {len(row)} cells, but the header has {len(head)}.")
            yield f"line {reader.line_num}", dict(zip(head, row, strict=True))
    except csv.Error as error:
        raise FileProblem(path, f"line {reader.line_num} is not valid CSV ({error}).") from error


def _json_records(path: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    data = read_json(path)
    if not isinstance(data, dict) or data.get("format_version") != FORMAT_VERSION:
        raise FileProblem(path, f"is not a table of trials with format_version {FORMAT_VERSION}.")
    rows = data.get("rows")
    if not isinstance(rows, list):
        raise FileProblem(path, "has no list of rows under 'rows'.")
    for number, row in enumerate(rows, 1):
        if not isinstance(row, dict):
            raise FileProblem(path, f"row {number} is {reprlib.repr(row)}, but must be a table of columns.")
        _names(list(row), path)
        yield f"row {number}", row


def _names(head: Sequence[str], path: Path) -> list[str]:
    """Column names as this module spells them. Raises FileProblem if one is missing or there twice."""
    names = []
    for cell in head:
        name = "_".join(cell.split())
        close = [known for known in COLUMNS if known.lower() == name.lower()]
        name = close[0] if close else _ALIASES.get(name.lower(), name)
        if name in names:
            raise FileProblem(path, f"has the column {name!r} twice.")
        names.append(name)
    missing = [name for name in REQUIRED if name not in names]
    if missing:
        raise FileProblem(path, f"lacks the columns {', '.join(missing)}; it has {', '.join(names) or 'none'}.")
    return names


class _Record:
    """One row of whatever a file holds, read with the place of what is wrong."""

    def __init__(self, cells: Mapping[str, Any], place: str, path: Path) -> None:
        self._cells, self._place, self._path = cells, place, path

    def trial(self) -> Trial:
        return Trial(
            v=self._needed("v", "a finite number"),
            T=self._needed("T", "> 0 (s)", above=0.0),
            beta=self._needed("beta", "in (0, 1)", above=0.0, below=1.0),
            cost_of_transport=self._number("cost_of_transport", "> 0, or empty", above=0.0),
            tracking_error=self._number("tracking_error", ">= 0 (m/s), or empty", least=0.0),
            weight=self._needed("weight", ">= 0", least=0.0),
            gait=self._text("gait"),
            seed=self._whole("seed"),
            fell=self._truth("fell"),
            gc_stance=self._number("gc_stance", ">= 0, or empty", least=0.0),
            gait_identity=self._number("gait_identity", ">= 0, or empty", least=0.0),
            samples=self._whole("samples"),
            leg_length=self._number("leg_length", "> 0 (m), or empty", above=0.0),
        )

    def _wrong(self, name: str, allowed: str) -> FileProblem:
        shown = reprlib.repr(self._cells.get(name))
        return FileProblem(self._path, f"{self._place}, column {name!r}: {shown} is not {allowed}.")

    def _number(
        self,
        name: str,
        allowed: str,
        least: float = -math.inf,
        above: float = -math.inf,
        below: float = math.inf,
    ) -> float | None:
        value = self._cells.get(name)
        if value is None or (isinstance(value, str) and not value.strip()):
            return None
        try:
            number = float(value) if isinstance(value, str | int | float) and not isinstance(value, bool) else math.nan
        except (ValueError, OverflowError):
            number = math.nan
        if not (math.isfinite(number) and least <= number and above < number < below):
            raise self._wrong(name, allowed)
        return number

    def _needed(self, name: str, allowed: str, **bounds: float) -> float:
        number = self._number(name, allowed, **bounds)
        if number is None:
            raise self._wrong(name, allowed)
        return number

    def _whole(self, name: str) -> int | None:
        number = self._number(name, "a whole number, or empty")
        if number is not None and number != int(number):
            raise self._wrong(name, "a whole number, or empty")
        return None if number is None else int(number)

    def _truth(self, name: str) -> bool:
        value = self._cells.get(name)
        if value is None or isinstance(value, bool):
            return bool(value)
        text = str(value).strip().lower()
        if text and text not in _TRUTHS:
            raise self._wrong(name, "0 or 1")
        return _TRUTHS[text] if text else False

    def _text(self, name: str) -> str:
        value = self._cells.get(name)
        if not (value is None or isinstance(value, str)):
            raise self._wrong(name, "text")
        return (value or "").strip()
