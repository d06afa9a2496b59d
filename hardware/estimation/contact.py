"""Which feet bear load: from the force sensors in the feet, or from the torques of the joints."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hardware.estimation.ground_force import GroundForce
from hardware.estimation.kinematics import LegKinematics
from hardware.wire.readings import Imu, Joints
from symdyn.errors import InvalidValue
from symdyn.robot.legs import LEGS


@dataclass(frozen=True)
class ContactConfig:
    """When a foot counts as bearing load.

    Attributes:
        source: "force": the sensors in the feet. "torque": the vertical force that the joints' torques tell of; for a
            robot whose feet have no sensors, or bad ones. "auto": the sensors, unless all four have shown 0 from the
            start, as without sensors (unitree_mujoco's); then the torques, until one shows something else.
        thresholds: raw foot force above which a foot bears load, LH LF RF RH. Users of the Go2 report that 20 to 60
            parts stance from swing; ``symdyn calibrate-feet`` measures it.
        vertical_force: the same for "torque", N. A standing Go2 has 40 N on each foot.
        release: share of the threshold below which a foot is off the ground again.
        bandwidth: of the observer of "torque", rad/s. Slower, it is late; faster, swinging legs seem to push.
    """

    source: Literal["auto", "force", "torque"] = "auto"
    thresholds: tuple[float, float, float, float] = (30.0, 30.0, 30.0, 30.0)
    vertical_force: float = 20.0
    release: float = 0.7
    bandwidth: float = 150.0

    def __post_init__(self) -> None:
        if self.source not in ("auto", "force", "torque"):
            raise InvalidValue("contact.source", self.source, "'auto', 'force' or 'torque'")
        if len(self.thresholds) != len(LEGS):
            raise InvalidValue("contact.thresholds", self.thresholds, f"{len(LEGS)} numbers: {', '.join(LEGS)}")
        named = [("thresholds", value) for value in self.thresholds]
        named += [(name, getattr(self, name)) for name in ("vertical_force", "bandwidth")]
        for name, value in named:
            if not 0.0 < value < math.inf:
                raise InvalidValue(f"contact.{name}", value, "a finite number > 0")
        if not 0.0 < self.release <= 1.0:
            raise InvalidValue("contact.release", self.release, "in (0, 1]")


class FootContact:
    """Contacts with hysteresis.

    Args:
        config: source and thresholds.
        kinematics: of the robot; for torques.
    """

    def __init__(self, config: ContactConfig, kinematics: LegKinematics) -> None:
        self._config = config
        self._observer = None if config.source == "force" else GroundForce(kinematics, config.bandwidth)
        self._contact = np.zeros(len(LEGS), dtype=bool)

    @property
    def source(self) -> Literal["force", "torque"]:
        """What tells of contacts now."""
        return "force" if self._observer is None else "torque"

    def update(self, imu: Imu, joints: Joints, dt: float) -> NDArray[np.bool_]:
        """Which feet bear load, (4,), in the order of symdyn.robot.legs.LEGS. What is not a number is no load.

        Args:
            imu: newest.
            joints: newest.
            dt: since the sample before, s.
        """
        if self._config.source == "auto" and imu.foot_force.any():
            self._observer = None
        config = self._config
        if self._observer is None:
            force, thresholds = imu.foot_force, np.array(config.thresholds)
        else:
            force, thresholds = self._observer.update(dt, imu, joints), np.full(len(LEGS), config.vertical_force)
        self._contact = force > np.where(self._contact, config.release * thresholds, thresholds)
        return self._contact.copy()
