"""Which model ``symdyn families`` and ``symdyn orbit`` work on: the literature's, or a robot's with its scale."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from slip.model.parameters import REFERENCE, SlipParameters
from slip.robot.known import check_known
from symdyn.errors import InvalidValue
from symdyn.io.options import RobotOption

if TYPE_CHECKING:
    from slip.robot.units import Units


@dataclass(frozen=True)
class PassiveModel:
    """A model.

    Attributes:
        name: of the robot, or ``reference``; with what was changed.
        parameters: dimensionless.
        units: scale of the robot; None for the literature's model, which has none.
        robot: name of the robot that it is of, or None.
    """

    name: str
    parameters: SlipParameters
    units: Units | None
    robot: str | None = None


@dataclass(frozen=True)
class PassiveModelArguments:
    """The spring-loaded model: the literature's (k 10, ks 20, J 2) unless a robot is named.

    Attributes:
        robot: go2, go1, a1, b1, solo12, anymal_b, anymal_c or hyq, or a robot file: the model is computed from its
            URDF.
        urdf: URDF of any robot with four legs, instead of --robot.
        feet: the four foot links of --urdf, in any order; the ends of the kinematic tree if left out.
        srdf: SRDF with the nominal stance of --urdf, a group state called 'standing'; all joints at zero if left out.
        k: mean leg stiffness, M g / torso length.
        ks: stiffness of the swing spring; a leg swings with the frequency sqrt(ks) / l.
        J: pitch inertia of the torso, M torso length^2.
        rest_length: leg length, torso lengths.
        lb: distance of the centre of mass from the hind hip, torso lengths; 0.5 is a symmetric torso.
        kr: stiffness of a hind leg over that of a front leg.
        resting_angle: angle about which a leg swings, rad, positive forwards.
    """

    robot: RobotOption = None
    urdf: Path | None = None
    feet: tuple[str, ...] | None = None
    srdf: Path | None = None
    k: float | None = None
    ks: float | None = None
    J: float | None = None
    rest_length: Annotated[float | None, tyro.conf.arg(name="l")] = None
    lb: float | None = None
    kr: float | None = None
    resting_angle: float | None = None

    def load(self) -> PassiveModel:
        """The model. Raises SymdynError for an unknown robot, an unreadable description or absurd numbers."""
        base = self._base()
        flags = {
            "stiffness": self.k,
            "swing_stiffness": self.ks,
            "pitch_inertia": self.J,
            "rest_length": self.rest_length,
            "hind_distance": self.lb,
            "stiffness_ratio": self.kr,
            "resting_angle": self.resting_angle,
        }
        given = {name: value for name, value in flags.items() if value is not None}
        if not given:
            return base
        changed = replace(base.parameters, **given)
        name = base.name if changed == base.parameters else f"{base.name}, changed"
        return PassiveModel(name, changed, base.units, base.robot)

    def _base(self) -> PassiveModel:
        if self.urdf is not None and self.robot is not None:
            raise InvalidValue("--robot", self.robot, "left out when --urdf is given")
        for flag, value in (("--feet", self.feet), ("--srdf", self.srdf)):
            if value is not None and self.urdf is None:
                raise InvalidValue(flag, value if isinstance(value, tuple) else str(value), "used with --urdf")
        if self.robot is None and self.urdf is None:
            return PassiveModel("reference", REFERENCE, None)
        if self.robot is not None:
            check_known(self.robot)
        # Pinocchio takes a second to load, and the literature's model does not need it
        from slip.robot.body import measure
        from slip.robot.units import DimensionalSlip
        from slip.robot.urdf import load_robot, load_urdf

        if self.robot is not None:
            robot = load_robot(self.robot)
        else:
            assert self.urdf is not None
            robot = load_urdf(self.urdf, feet=self.feet, srdf=self.srdf)
        scaled = DimensionalSlip.of_body(measure(robot))
        return PassiveModel(robot.name, scaled.parameters(), scaled.units, robot.name)


def model_flags(given: PassiveModelArguments) -> list[tuple[str, object]]:
    """The options of the command line that choose this model, with their values."""
    names = {"rest_length": "l"}
    flags = [(names.get(item.name, item.name), getattr(given, item.name)) for item in fields(given)]
    return [(f"--{name.replace('_', '-')}", value) for name, value in flags if value is not None]
