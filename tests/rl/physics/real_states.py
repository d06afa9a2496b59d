"""States of robots in motion, and their mirror images."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
import torch

from rl.physics.batch import BatchPhysics
from rl.physics.protocol import Pose, RobotState
from tests.robots import GO2
from tests.symdyn.robot.mirrored_by_hand import MirroredByHand


@dataclass(frozen=True)
class RealStates:
    """States of robots that were shaken by random joint targets, and their mirror images by hand.

    Attributes:
        qpos: (n, 19).
        qvel: (n, 18).
        ctrl: (n, 12) joint targets in symdyn's order.
        state: as the physics reads them.
        image: as the physics reads their mirror images.
    """

    qpos: np.ndarray
    qvel: np.ndarray
    ctrl: np.ndarray
    state: RobotState
    image: RobotState


def shaken(model: mujoco.MjModel) -> RealStates:
    """24 robots in motion, some on their feet, some falling; turned about all axes."""
    n, rng = 24, np.random.default_rng(7)
    physics = BatchPhysics(model, GO2, n, num_threads=1)
    yaw = rng.uniform(-np.pi, np.pi, n)
    pose = Pose(
        base_pos_w=np.column_stack([rng.normal(size=(n, 2)), np.full(n, 0.36)]),
        base_quat_w=np.column_stack([np.cos(yaw / 2), np.zeros((n, 2)), np.sin(yaw / 2)]),
        base_vel_w=rng.uniform(-0.5, 0.5, (n, 3)),
        joint_pos=GO2.default_joint_pos + rng.uniform(-0.1, 0.1, (n, 12)),
    )
    physics.reset(np.arange(n), pose)
    targets = np.zeros((n, 12))
    for _ in range(12):
        targets = GO2.default_joint_pos + rng.uniform(-0.3, 0.3, (n, 12))
        physics.step(torch.from_numpy(targets))
    qpos, qvel = physics.batch.qpos.copy(), physics.batch.qvel.copy()

    def read(qpos: np.ndarray, qvel: np.ndarray, targets: np.ndarray) -> RobotState:
        physics.batch.qpos = qpos
        physics.batch.qvel = qvel
        # cold, for both alike: a warm start would carry the solver's last iterate from a state into its image
        physics.batch.qacc_warmstart = 0.0
        physics.set_targets(targets)
        physics.batch.forward()
        return physics.read()

    return RealStates(
        qpos,
        qvel,
        targets,
        state=read(qpos, qvel, targets),
        image=read(MirroredByHand.qpos(qpos), MirroredByHand.qvel(qvel), MirroredByHand.joints(targets)),
    )
