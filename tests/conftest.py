"""What tests share: one thread a process, reproducible properties, and a mirror image of the robot made by hand."""

from __future__ import annotations

import os

# before anything imports torch: the tests' tensors are small, and idle threads that spin slow everything else down
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

import signal
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

from tests.slip.families.reference import SLIP_CACHE

if TYPE_CHECKING:
    import mujoco

    from rl.physics.protocol import RobotState

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # a shell has what it starts in the background ignore Ctrl-C, and so would whatever the tests start
    signal.signal(signal.SIGINT, signal.default_int_handler)

settings.register_profile(
    "symdyn",
    deadline=None,  # another process may want the core
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("symdyn")


REAL_TIME = frozenset(
    {
        "test_deploy_command.py",
        "test_play_command.py",
        "test_realtime.py",
        "test_robot_sim_command.py",
        "test_robot_sim_session.py",
        "test_viewer_time.py",
    }
)
"""Files whose tests run processes by the clock: marked ``realtime``, for ``make test`` to run them alone."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.path.name in REAL_TIME:
            item.add_marker(pytest.mark.realtime)


@pytest.fixture(scope="session")
def slip_cache() -> Iterator[Path]:
    """The cache of explored families that tests share (tests/slip_reference.py)."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SYMDYN_CACHE", str(SLIP_CACHE))
        yield SLIP_CACHE


class MirroredByHand:
    """The left-right mirror image of a Go2, written out. Nothing here comes from symdyn.gait.symmetry or
    symdyn.policy.observation.

    The mirror plane is y = 0 of the world. In MuJoCo's arrays the joints are hip, thigh, calf of FL, FR, RL, RR; in
    symdyn's of LH, LF, RF, RH. Hips turn about x and so change sign; thighs and calves turn about y and do not.
    """

    @staticmethod
    def qpos(qpos: np.ndarray) -> np.ndarray:
        """(..., 19): position, quaternion (w, x, y, z), joints."""
        image = qpos.copy()
        image[..., 1] = -qpos[..., 1]
        image[..., 4] = -qpos[..., 4]
        image[..., 6] = -qpos[..., 6]
        image[..., 7:] = MirroredByHand._swap(qpos[..., 7:])
        return image

    @staticmethod
    def qvel(qvel: np.ndarray) -> np.ndarray:
        """(..., 18): linear velocity in the world, angular velocity in the body, joints."""
        image = qvel.copy()
        image[..., 1] = -qvel[..., 1]
        image[..., 3] = -qvel[..., 3]
        image[..., 5] = -qvel[..., 5]
        image[..., 6:] = MirroredByHand._swap(qvel[..., 6:])
        return image

    @staticmethod
    def _swap(joints: np.ndarray) -> np.ndarray:
        fl, fr, rl, rr = (joints[..., k : k + 3] for k in (0, 3, 6, 9))
        sign = np.array([-1.0, 1.0, 1.0])
        return np.concatenate([sign * fr, sign * fl, sign * rr, sign * rl], axis=-1)

    @staticmethod
    def joints(values: Any) -> Any:
        """(..., 12) in symdyn's order LH, LF, RF, RH; numpy or torch."""
        image = values[..., [9, 10, 11, 6, 7, 8, 3, 4, 5, 0, 1, 2]] + 0.0
        image[..., [0, 3, 6, 9]] *= -1.0
        return image

    @staticmethod
    def legs(values: Any) -> Any:
        """(..., 4) in symdyn's order."""
        return values[..., [3, 2, 1, 0]]


@pytest.fixture(scope="session")
def by_hand() -> type[MirroredByHand]:
    """The mirror image written out."""
    return MirroredByHand


@pytest.fixture(scope="session")
def go2_model() -> mujoco.MjModel:
    """The compiled model. Not to be changed: make another with rl.physics.model.build_model for that."""
    from rl.physics.model import build_model
    from tests.robots import GO2

    return build_model(GO2)


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


@pytest.fixture(scope="session")
def real_states(go2_model: mujoco.MjModel) -> RealStates:
    """24 robots in motion, some on their feet, some falling; turned about all axes."""
    import torch

    from rl.physics.batch import BatchPhysics
    from rl.physics.protocol import Pose
    from tests.robots import GO2

    n, rng = 24, np.random.default_rng(7)
    physics = BatchPhysics(go2_model, GO2, n, num_threads=1)
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
