"""The command line of ``symdyn symmetry``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from slip.robot.tolerances import Tolerances
from symdyn.io.command_line import parsed
from symdyn.io.options import RobotOption


@dataclass(frozen=True)
class SymmetryArguments:
    """Compute the symmetry group of a robot from its URDF, and its parameters as a spring-loaded model.

    Every leg is compared with every other one, with every combination of joint signs. Each candidate is rated by the
    errors of foot kinematics, mass matrix and joint limits.

    Attributes:
        robot: go2 (the default), go1, a1, b1, solo12, anymal_b, anymal_c or hyq, or a robot file.
        urdf: URDF of any robot with four legs, instead of --robot.
        feet: the four foot links of --urdf, in any order; the ends of the kinematic tree if left out.
        srdf: SRDF with the nominal stance of --urdf, a group state called 'standing'; all joints at zero if left out.
        kp: position gain of every joint, N m/rad. Default: that of the robot file; without one, dynamically similar to
            the Go2's.
        kd: velocity gain of every joint, N m s/rad; needs --kp.
        tolerances: largest errors that count as a symmetry.
        out: also write all results to this JSON file.
    """

    robot: RobotOption = None
    urdf: Path | None = None
    feet: tuple[str, ...] | None = None
    srdf: Path | None = None
    kp: float | None = None
    kd: float | None = None
    tolerances: Tolerances = field(default_factory=Tolerances)
    out: Path | None = None


def parse(arguments: Sequence[str]) -> SymmetryArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(SymmetryArguments, arguments, "symdyn symmetry")
