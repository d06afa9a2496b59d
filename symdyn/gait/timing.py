"""Stride period and duty factor as functions of the commanded speed: eq. (1) of the paper.

    T* = a_T (1 + b_T delta |v*|) exp(-c_T |v*|),   v* = v / sqrt(g l),   T* = T / sqrt(l / g),

and the duty factor beta alike, with a delta of its own. ``l`` is the leg length of the robot.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from array_api_compat import array_namespace

from symdyn.arrays import Array
from symdyn.errors import FileProblem, InvalidValue
from symdyn.io.files import read_json, write_json

GRAVITY = 9.81
"""m/s^2; the value of the paper's simulators."""

PERIOD_MIN = 0.1
"""s; a shorter stride is asked of no motor."""

DUTY_RANGE = (0.1, 0.9)

FORMAT_VERSION = 1

_ALLOWED = {
    "a_T": (1e-3, 20.0),
    "b_T": (0.0, 1.0),
    "c_T": (-1.0, 10.0),
    "a_beta": (1e-3, 1.0),
    "b_beta": (0.0, 1.0),
    "c_beta": (-1.0, 10.0),
}


@dataclass(frozen=True)
class TimingCurve:
    """Constants of the two curves and where they came from.

    The defaults are the paper's (section III-E). They are calibrated from RL trials, not derived from a passive model.

    Raises:
        InvalidValue: if a constant is not finite or absurd.
    """

    a_T: float = 2.55
    b_T: float = 0.20
    c_T: float = 0.975
    a_beta: float = 0.5588
    b_beta: float = 0.20
    c_beta: float = 0.681
    source: str = "paper (Ding, Chen, Katz, Gan), section III-E: calibrated from RL trials"

    def __post_init__(self) -> None:
        for name, (low, high) in _ALLOWED.items():
            value = getattr(self, name)
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if not number or not low <= value <= high:  # nan is in no range
                raise InvalidValue(f"Timing constant {name}", value, f"a number in [{low:g}, {high:g}]")

    def period(self, velocity_x: Array, leg_length: float, delta: Array | float = 0.0) -> Array:
        """Stride period T, s.

        Args:
            velocity_x: (...,) commanded forward velocity, m/s.
            leg_length: m.
            delta: (...,) or scalar in [-1, 1], the perturbation of the paper's eq. (1).

        Returns:
            (...,) s, at least :data:`PERIOD_MIN`.
        """
        xp = array_namespace(velocity_x)
        time_unit = math.sqrt(leg_length / GRAVITY)
        curve = _curve(velocity_x, leg_length, self.a_T, self.b_T, self.c_T, delta)
        return xp.clip(curve * time_unit, PERIOD_MIN, None)

    def duty(self, velocity_x: Array, leg_length: float, delta: Array | float = 0.0) -> Array:
        """Duty factor beta, clamped to :data:`DUTY_RANGE`; arguments as for :meth:`period`."""
        xp = array_namespace(velocity_x)
        return xp.clip(_curve(velocity_x, leg_length, self.a_beta, self.b_beta, self.c_beta, delta), *DUTY_RANGE)

    def as_dict(self) -> dict[str, Any]:
        """The constants and their source, as the policy file and JSON hold them."""
        return asdict(self)

    @classmethod
    def from_dict(cls, data: Any, origin: object) -> TimingCurve:
        """From :meth:`as_dict`.

        Raises:
            FileProblem: if constants are missing or absurd; ``origin`` says of what.
        """
        if not isinstance(data, dict):
            raise FileProblem(origin, f"contains {type(data).__name__} instead of timing constants.")
        missing = [name for name in (*_ALLOWED, "source") if name not in data]
        if missing:
            raise FileProblem(origin, f"lacks the timing constants {', '.join(missing)}.")
        try:
            return cls(**{name: data[name] for name in _ALLOWED}, source=str(data["source"]))
        except InvalidValue as error:
            raise FileProblem(origin, f"contains a timing constant that is out of range. {error}") from error

    def save(self, path: Path, name: str = "curve", robot: str | None = None) -> None:
        """Write a curves file whose only, and active, curve is this one. Raises FileProblem.

        Args:
            path: of the file.
            name: of the curve.
            robot: name of the robot that it is for, or None if it is for no robot in particular.
        """
        curves = {name: self.as_dict()}
        write_json(path, {"format_version": FORMAT_VERSION, "robot": robot, "active": name, "curves": curves})

    @classmethod
    def load(cls, path: Path, robot: str | None = None) -> TimingCurve:
        """The active curve of a curves file.

        The file is ``{"format_version": 1, "robot": NAME, "active": NAME, "curves": {NAME: constants}}``. A file
        without ``robot``, or with null, is for no robot in particular.

        Args:
            path: of the file.
            robot: name of the robot that the curve is wanted for; None takes that of any.

        Raises:
            FileProblem: if the file is missing or malformed, its active curve is, or it was made for another robot.
        """
        data = read_json(path)
        if not isinstance(data, dict) or data.get("format_version") != FORMAT_VERSION:
            raise FileProblem(path, f"is not a curves file with format_version {FORMAT_VERSION}.")
        its = data.get("robot")
        if None not in (its, robot) and its != robot:
            raise FileProblem(path, f"holds timing curves of the robot {its!r}, not of {robot!r}.")
        curves, active = data.get("curves"), data.get("active")
        if not isinstance(curves, dict) or not isinstance(active, str) or active not in curves:
            raise FileProblem(path, f"names {active!r} as its active curve, but contains no such curve.")
        return cls.from_dict(curves[active], path)


def _curve(velocity_x: Array, leg_length: float, a: float, b: float, c: float, delta: Array | float) -> Array:
    xp = array_namespace(velocity_x)
    speed = xp.abs(velocity_x) / math.sqrt(GRAVITY * leg_length)
    return a * (1.0 + b * delta * speed) * xp.exp(-c * speed)
