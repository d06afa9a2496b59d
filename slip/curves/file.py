"""``curves.json``: the fit to passive orbits, the fit to trials, the paper's constants, and which of them is active.

A file of :mod:`symdyn.gait.timing` (``{"format_version": 1, "active": NAME, "curves": {NAME: constants}}``) with more
beside
the constants: ``fit`` (intervals, R^2, residuals, number of points) and ``data`` (what was fitted to). The trainer
reads the active curve's constants and its ``source``, which says in words what the constants are and goes into every
policy file.

The names are fixed, so that none of the three can pass for another: ``passive`` is fitted to orbits of the
spring-loaded model and to nothing else; ``calibrated`` to trials of a trained policy and to nothing else; ``paper`` is
the paper's, which were calibrated from its own trials. Without trials the active one is ``paper``, never ``passive``,
unless one asks for it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from slip.curves.fit import CurveFit
from slip.curves.settings import CurveName
from symdyn.errors import InvalidValue
from symdyn.gait.timing import FORMAT_VERSION, TimingCurve
from symdyn.io.files import write_json
from symdyn.io.origin import commit

WHAT: Mapping[CurveName, str] = {
    "passive": "fitted to passive orbits of the spring-loaded model (SLIP), to no trial of a policy",
    "calibrated": "fitted to trials of a trained policy, chosen by cost of transport; not derived from the SLIP",
    "paper": "constants of the paper, calibrated from RL trials of its own; not derived from the SLIP",
}


@dataclass(frozen=True)
class FittedCurve:
    """A fit and what it was made of.

    Attributes:
        fit: constants with intervals.
        data: where the points come from, for JSON: robot, parameters, families, number of orbits, ...
        summary: the same in a few words: "41 orbits of PK, BG".
        caveat: a sentence on what must not be read into the constants, or empty.
    """

    fit: CurveFit
    data: Mapping[str, Any]
    summary: str
    caveat: str = ""

    def what(self, name: CurveName) -> str:
        """What the constants are, in words."""
        return f"{WHAT[name]} ({self.summary})" + (f". {self.caveat}" if self.caveat else "")

    def timing(self, name: CurveName) -> TimingCurve:
        """The constants, with what they are. Raises InvalidValue."""
        return self.fit.timing(f"{name}: {self.what(name)}")


def document(
    passive: FittedCurve,
    calibrated: FittedCurve | None = None,
    active: CurveName | None = None,
    robot: str | None = None,
) -> dict[str, Any]:
    """The content of curves.json.

    Args:
        passive: of orbits.
        calibrated: of trials, if there are any.
        active: which one the trainer takes; ``calibrated`` if there are trials, else ``paper``.
        robot: name of the robot that they are for; symdyn train refuses them for another. None if for none in
            particular.

    Raises:
        InvalidValue: if the active one is ``calibrated`` and there is none, or constants are absurd.
    """
    chosen: CurveName = active or ("paper" if calibrated is None else "calibrated")
    fitted: dict[CurveName, FittedCurve] = {"passive": passive}
    if calibrated is not None:
        fitted["calibrated"] = calibrated
    if chosen not in (*fitted, "paper"):
        raise InvalidValue("The active curve", chosen, "passive or paper when no trials are given")
    curves: dict[str, Any] = {
        name: {**curve.timing(name).as_dict(), "fit": curve.fit.as_dict(), "data": dict(curve.data)}
        for name, curve in fitted.items()
    }
    curves["paper"] = {**TimingCurve().as_dict(), "fit": None, "data": {"note": WHAT["paper"]}}
    return {
        "format_version": FORMAT_VERSION,
        "robot": robot,
        "active": chosen,
        "note": note(chosen, calibrated is not None, asked=active is not None),
        "made": {"date": datetime.now(UTC).isoformat(timespec="seconds"), "commit": commit()},
        "curves": curves,
    }


def note(active: CurveName, has_trials: bool, asked: bool) -> str:
    """Which curve is active and what it is, in words."""
    sentences = [f"The active curve is '{active}'{' as asked for' if asked else ''}: {WHAT[active]}."]
    if not has_trials:
        sentences.append("No trials were given, so there is no calibrated curve of this robot.")
    if active != "passive":
        sentences.append("The fit to the spring-loaded model stands under 'passive' and is not what is trained with.")
    return " ".join(sentences)


def write(path: Path, content: Mapping[str, Any]) -> None:
    """Write :func:`document`'s result, whole or not at all. Raises FileProblem."""
    write_json(path, content)
