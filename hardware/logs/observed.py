"""What a robot did, from what it said alone: for logs that hold no ticks of symdyn's deployer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from hardware.control.settings import TICK_HZ
from hardware.estimation.contact import FootContact
from hardware.estimation.kinematics import LegKinematics
from hardware.estimation.settings import ContactConfig
from hardware.estimation.velocity import VelocityEstimator
from hardware.logs.contents import Bools, Floats, LogContents
from hardware.wire.channels import IMU, JOINTS
from symdyn.analysis.footfall import debounce, touchdowns
from symdyn.analysis.metrics import cost_of_transport
from symdyn.gait.timing import GRAVITY
from symdyn.robot.legs import LEGS

MOVING = 0.1
"""m/s; slower, averaged over a second, the robot counts as standing."""

KEYS: Mapping[str, str] = MappingProxyType(
    {
        "moving_s": f"s: time in which the robot was faster than {MOVING:g} m/s",
        "speed": "m/s: mean forward velocity in that time",
        "cot": "1: cost of transport in that time, positive mechanical work per weight and distance",
        "stride_s": "s: median time from touchdown to touchdown in that time, by leg",
        "duty": "1: share of that time in contact, by leg",
    }
)
"""What :func:`summarise` returns, as ``unit: meaning``."""


@dataclass(frozen=True, eq=False)
class Observed:
    """M samples, as many a second as the deployer has ticks. Legs in the order of symdyn.robot.legs.LEGS.

    Attributes:
        time: (M,) s from the first event of the log.
        velocity_h: (M, 3) v_x, v_y (m/s) in the heading frame, yaw rate (rad/s): estimated.
        contact: (M, 4) which feet bear load, by the threshold.
        joint_vel: (M, 12) rad/s.
        joint_torque: (M, 12) N m.
    """

    time: Floats
    velocity_h: Floats
    contact: Bools
    joint_vel: Floats
    joint_torque: Floats

    @property
    def dt(self) -> float:
        """Between samples, on average, s."""
        return float(self.time[-1] - self.time[0]) / max(len(self.time) - 1, 1)

    @property
    def moving(self) -> Bools:
        """(M,) whether the robot is on its way."""
        width = max(1, min(round(TICK_HZ), len(self.time)))
        average = np.convolve(self.velocity_h[:, 0], np.full(width, 1.0 / width), mode="same")
        return np.abs(average) > MOVING


def observe(log: LogContents, kinematics: LegKinematics, config: ContactConfig) -> Observed | None:
    """Put what the robot said through the deployer's contact and velocity estimates.

    Args:
        log: with all joint and IMU messages, as hardware.logs.contents reads them where there are no ticks.
        kinematics: of the robot.
        config: when a foot bears load.

    Returns:
        None without at least two joint messages with IMU messages before them.
    """
    contacts, estimator = FootContact(config, kinematics), VelocityEstimator(kinematics)
    imu_numbers = np.array(sorted(log.imu))
    imu_times = log.arrivals.get(IMU, np.zeros(0))[imu_numbers.astype(int) - 1]
    rows = []
    last, last_tick = -np.inf, -1
    for number, joints in log.joints.items():
        time = float(log.arrivals[JOINTS][number - 1])
        before = int(np.searchsorted(imu_times, time, side="right")) - 1
        # the first message of every tick that the deployer would have had
        tick = int(time * TICK_HZ + 1e-3)
        if before < 0 or tick == last_tick:
            continue
        last_tick = tick
        imu = log.imu[int(imu_numbers[before])]
        dt = time - last if np.isfinite(last) else 1.0 / TICK_HZ
        contact = contacts.update(imu, joints, dt)
        estimate = estimator.update(dt, imu, joints, contact)
        rows.append((time, estimate.velocity_h, contact, joints.vel, joints.torque))
        last = time
    if len(rows) < 2:
        return None
    return Observed(*(np.array(column) for column in zip(*rows, strict=True)))


def summarise(observed: Observed, mass: float) -> dict[str, Any]:
    """The numbers of :data:`KEYS`; nan where the robot did not move."""
    moving, dt = observed.moving, observed.dt
    speed = float(observed.velocity_h[moving, 0].mean()) if moving.any() else float("nan")
    seconds = float(moving.sum()) * dt
    contact = debounce(observed.contact, dt)
    landings = {leg: observed.time[touchdowns(contact & moving[:, None], leg)] for leg in LEGS}
    cot = cost_of_transport(
        observed.joint_torque[moving], observed.joint_vel[moving], dt, mass, GRAVITY, speed * seconds
    )
    return {
        "moving_s": seconds,
        "speed": speed,
        "cot": cot,
        "stride_s": {leg: float(np.median(np.diff(t))) if len(t) > 1 else float("nan") for leg, t in landings.items()},
        "duty": {leg: float(contact[moving, k].mean()) if moving.any() else float("nan") for k, leg in enumerate(LEGS)},
    }
