"""The simulated robot under the shipped policy: what its messages said at 200 Hz, and what was true."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import cycle

import numpy as np

from hardware.robot_sim.settings import PERIOD
from hardware.wire.readings import Imu, Joints, Targets
from hardware.wire.sdk_order import LEGS_FROM_SDK
from rl.physics.model import force_sensor
from rl.pretrained import policy_path
from symdyn.gait.library import get
from symdyn.policy.driver import PolicyDriver
from symdyn.policy.file import Policy
from symdyn.policy.observation import Sensed
from symdyn.robot.frames import projected_gravity, to_heading
from symdyn.robot.legs import LEGS
from tests.hardware.robot_sim.simulated import go2

SECONDS, START, RAMP = 5.0, 0.3, 1.0
_EVERY = (2, 3)  # of the robot's 2 ms between samples, in turn: 200 Hz


@dataclass(frozen=True)
class TrueSample:
    """What the messages said, and the truth. Legs in the order of symdyn.robot.legs.LEGS.

    Attributes:
        dt: since the sample before, s.
        imu: noisy.
        joints: noisy.
        position_w: (3,) of the trunk, m.
        velocity_w: (3,) m/s.
        velocity_h: (3,) forward, lateral (m/s), yaw rate (rad/s).
        contact: (4,) whether a foot bears more than 1 N.
        vertical_force: (4,) of the ground on each foot, N.
    """

    dt: float
    imu: Imu
    joints: Joints
    position_w: np.ndarray
    velocity_w: np.ndarray
    velocity_h: np.ndarray
    contact: np.ndarray
    vertical_force: np.ndarray


@dataclass(frozen=True)
class Run:
    """A run from a stand.

    Attributes:
        samples: from the start.
        running: those at the commanded velocity.
    """

    samples: tuple[TrueSample, ...]
    running: slice


@cache
def driven(gait: str, command: tuple[float, float, float], seed: int) -> Run:
    """The robot in a gait, its command ramped up over a second."""
    policy = Policy.load(policy_path())
    robot, driver, meta = go2(seed=seed, start="standing"), PolicyDriver(policy), policy.metadata
    driver.offsets[0] = get(gait).theta
    gains = np.ones(len(meta.joint_names))
    every, since, samples = cycle(_EVERY), 0, []
    due = next(every)
    for step in range(round(SECONDS / PERIOD)):
        joints, imu = Joints.of(robot.joints()), Imu.of(robot.imu())
        if step % round(meta.control_dt / PERIOD) == 0:
            driver.velocity[0] = np.array(command) * np.clip((step * PERIOD - START) / RAMP, 0.0, 1.0)
            targets = driver.act(
                Sensed(
                    projected_gravity(imu.quat_w)[None],
                    joints.pos[None],
                    joints.vel[None],
                    imu.angular_velocity_b[None],
                )
            )[0]
            robot.command(Targets(targets, meta.kp * gains, meta.kd * gains).message(step, 1))
        robot.step()
        driver.advance(PERIOD)
        since += 1
        if since == due:
            truth = robot.truth()
            velocity_w, quat_w = np.array(truth.vWorld), np.array(truth.quat)
            samples.append(
                TrueSample(
                    dt=since * PERIOD,
                    imu=Imu.of(robot.imu()),
                    joints=Joints.of(robot.joints()),
                    position_w=np.array(truth.p),
                    velocity_w=velocity_w,
                    velocity_h=np.append(to_heading(quat_w, velocity_w)[:2], truth.omegaWorld[2]),
                    contact=np.array(truth.contact_estimate)[list(LEGS_FROM_SDK)] > 0.5,
                    # the sensor's is the force of the foot on the ground
                    vertical_force=np.array([-robot.data.sensor(force_sensor(leg)).data[2] for leg in LEGS]),
                )
            )
            since, due = 0, next(every)
    first = int(np.searchsorted(np.cumsum([s.dt for s in samples]), START + RAMP + 0.5))
    return Run(tuple(samples), slice(first, None))
