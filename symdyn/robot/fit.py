"""One machine as it is: what its joints and motors were measured to be, as a file that lies over its robot file.

``symdyn identify`` writes such files (``robot_fit.toml``); ``--fit FILE`` of other commands reads them.
"""

from __future__ import annotations

import math
import tomllib
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from symdyn.errors import FileProblem, InvalidValue, SymdynError
from symdyn.io.files import write_text
from symdyn.io.settings_data import rebuild
from symdyn.robot.definition import Robot
from symdyn.robot.legs import JOINTS

LONGEST_DELAY = 0.1
"""s; a motor that answers later is no motor of a robot that runs."""


@dataclass(frozen=True)
class Measured:
    """A number with its interval.

    Attributes:
        value: the estimate; where the data do not determine it, what the model has.
        low: lower end of the interval that holds the true value with 95% confidence.
        high: upper end.
        determined: whether the data determine it well enough to be used.
    """

    value: float
    low: float
    high: float
    determined: bool = True

    def __post_init__(self) -> None:
        if not -math.inf < self.low <= self.value <= self.high < math.inf:
            raise InvalidValue("low, value, high", (self.low, self.value, self.high), "finite numbers in rising order")


@dataclass(frozen=True)
class JointFit:
    """One joint and its motor.

    Its torque is strength (kp_factor kp (target - shown) - kd_factor kd velocity), of the target of ``delay`` ago. The
    motor reports that torque without ``strength``. Friction and damping act against the motion.

    Attributes:
        joint: of :data:`symdyn.robot.legs.JOINTS`.
        delay: from the sending of a target to the torque, as the sender sees it, s.
        strength: torque at the joint by the torque that the motor reports.
        kp: factor on the proportional gain that is commanded, of the torque that the motor reports.
        kd: factor on the derivative gain, likewise.
        friction: Coulomb friction, N m.
        damping: viscous, N m s/rad.
        armature: rotor inertia seen at the joint, kg m^2.
        offset: what the encoder shows too much, rad.

    Raises:
        InvalidValue: if a number is out of range.
    """

    joint: str
    delay: Measured
    strength: Measured
    kp: Measured
    kd: Measured
    friction: Measured
    damping: Measured
    armature: Measured
    offset: Measured

    def __post_init__(self) -> None:
        if self.joint not in JOINTS:
            raise InvalidValue("joint", self.joint, f"one of {', '.join(JOINTS)}")
        for name in ("strength", "kp"):
            if not getattr(self, name).low > 0.0:
                raise InvalidValue(f"{name} of {self.joint}", getattr(self, name).low, "a factor > 0")
        for name in ("delay", "kd", "friction", "damping", "armature"):
            if not getattr(self, name).low >= 0.0:
                raise InvalidValue(f"{name} of {self.joint}", getattr(self, name).low, "a number >= 0")
        if not self.delay.high <= LONGEST_DELAY:
            raise InvalidValue(f"delay of {self.joint}", self.delay.high, f"at most {LONGEST_DELAY} s")
        if not max(abs(self.offset.low), abs(self.offset.high)) < 1.0:
            raise InvalidValue(f"offset of {self.joint}", self.offset.value, "within 1 rad of 0")


QUANTITIES: tuple[str, ...] = tuple(item.name for item in fields(JointFit) if item.name != "joint")
"""Names of what is measured of a joint, in order."""

UNITS = {
    "delay": "s",
    "strength": "",
    "kp": "",
    "kd": "",
    "friction": "N m",
    "damping": "N m s/rad",
    "armature": "kg m^2",
    "offset": "rad",
}
"""Of each of :data:`QUANTITIES`; factors have none."""


@dataclass(frozen=True)
class Fit:
    """A machine.

    Attributes:
        robot: name of the robot that it is one of.
        source: which log it was measured from.
        source_sha256: of the log, in hexadecimal digits.
        place: how the robot was held then, ``hung`` or ``standing``.
        commit: of symdyn, when it was measured.
        joints: every one of JOINTS once, in order.

    Raises:
        InvalidValue: if a joint is missing or in another place.
    """

    robot: str
    source: str
    source_sha256: str
    place: str
    commit: str
    joints: tuple[JointFit, ...]

    def __post_init__(self) -> None:
        names = tuple(joint.joint for joint in self.joints)
        if names != JOINTS:
            raise InvalidValue("The joints of the fit", ", ".join(names), f"{', '.join(JOINTS)}, in this order")

    def values(self, quantity: str) -> NDArray[np.float64]:
        """Of one of :data:`QUANTITIES`, (12,) in the order of JOINTS."""
        return np.array([getattr(joint, quantity).value for joint in self.joints])

    def range(self, *quantities: str) -> tuple[float, float] | None:
        """From the lowest to the highest end of the intervals of all joints; None if the data determine none."""
        found = [getattr(joint, name) for joint in self.joints for name in quantities]
        known = [measured for measured in found if measured.determined]
        return (min(m.low for m in known), max(m.high for m in known)) if known else None

    def check_robot(self, robot: Robot, path: object) -> None:
        """Raise FileProblem, in the name of the file ``path``, if it is of another robot."""
        if self.robot != robot.name:
            raise FileProblem(path, f"is the fit of a {self.robot}, not of a {robot.name}.")


def load_fit(path: Path, robot: Robot | None = None) -> Fit:
    """Read a fit.

    Args:
        path: of the file.
        robot: that it must be of; any if None.

    Raises:
        FileProblem: if it is missing, no TOML, a key is unknown, missing or out of range, or it is of another robot.
    """
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise FileProblem(path, f"cannot be read: {error.strerror or error}.") from error
    except (ValueError, RecursionError) as error:
        raise FileProblem(path, f"is no fit of a robot: not valid TOML ({error}).") from error
    fit = rebuild(Fit, data, path)
    if robot is not None:
        fit.check_robot(robot, path)
    return fit


def save_fit(fit: Fit, path: Path) -> None:
    """Write a fit as TOML that :func:`load_fit` reads. Raises FileProblem."""
    lines = [
        "# What symdyn identify measured of one machine; it lies over the file of its robot.",
        "# low and high: 95% interval. determined = false: the log does not tell, and the value is the model's.",
        "# strength, kp, kd are factors; delay in s, friction in N m, damping in N m s/rad, armature in kg m^2,",
        "# offset in rad.",
    ]
    lines += [f"{item.name} = {_text(getattr(fit, item.name))}" for item in fields(fit) if item.name != "joints"]
    for joint in fit.joints:
        lines += ["", "[[joints]]", f"joint = {_text(joint.joint)}"]
        for name in QUANTITIES:
            m: Measured = getattr(joint, name)
            known = "true" if m.determined else "false"
            lines.append(
                f"{name} = {{value = {m.value:.6g}, low = {m.low:.6g}, high = {m.high:.6g}, determined = {known}}}"
            )
    write_text(path, "\n".join(lines) + "\n")


def _text(value: str) -> str:
    escaped = value.replace("\\", "\\\\").replace('"', '\\"')
    if not escaped.isprintable():
        raise SymdynError(f"{value!r} cannot be written to a fit: it has control characters.")
    return f'"{escaped}"'
