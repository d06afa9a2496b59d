"""Which feet bear load: from the force sensors in the feet, or from the torques of the joints."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hardware.estimation.ground_force import GroundForce
from hardware.estimation.kinematics import LegKinematics
from hardware.estimation.settings import ContactConfig
from hardware.wire.readings import Imu, Joints
from symdyn.robot.legs import LEGS


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
