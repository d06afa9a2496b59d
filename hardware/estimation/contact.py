"""Which feet bear load: from the force sensors in the feet, or from the torques of the joints."""

from __future__ import annotations

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
        kinematics: of the robot; for "torque".
    """

    def __init__(self, config: ContactConfig, kinematics: LegKinematics) -> None:
        self._force = GroundForce(kinematics, config.bandwidth) if config.source == "torque" else None
        self._thresholds = np.array(config.thresholds)
        if config.source == "torque":
            self._thresholds = np.full(len(LEGS), config.vertical_force)
        self._release = config.release * self._thresholds
        self._contact = np.zeros(len(LEGS), dtype=bool)

    def update(self, imu: Imu, joints: Joints, dt: float) -> NDArray[np.bool_]:
        """Which feet bear load, (4,), in the order of symdyn.robot.legs.LEGS. What is not a number is no load.

        Args:
            imu: newest.
            joints: newest.
            dt: since the sample before, s.
        """
        force = imu.foot_force if self._force is None else self._force.update(dt, imu, joints)
        self._contact = force > np.where(self._contact, self._release, self._thresholds)
        return self._contact.copy()
