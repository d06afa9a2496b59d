"""What several packages' tests share: one thread a process, reproducible properties, the robot and its mirror image."""

from __future__ import annotations

import os

# before anything imports torch: the tests' tensors are small, and idle threads that spin slow everything else down
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

import signal
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import HealthCheck, settings

from tests.symdyn.robot.mirrored_by_hand import MirroredByHand

if TYPE_CHECKING:
    import mujoco

    from tests.rl.physics.real_states import RealStates

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
        "test_realtime.py",
        "test_robot_sim_command.py",
        "test_robot_sim_session.py",
        "test_runner.py",
    }
)
"""Files whose tests run processes by the clock: marked ``realtime``, for ``make test`` to run them alone."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.path.name in REAL_TIME:
            item.add_marker(pytest.mark.realtime)


@pytest.fixture(scope="session")
def slip_cache() -> Iterator[Path]:
    """The cache of explored families that tests share (tests/slip/families/reference.py)."""
    from tests.slip.families.reference import SLIP_CACHE

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SYMDYN_CACHE", str(SLIP_CACHE))
        yield SLIP_CACHE


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


@pytest.fixture(scope="session")
def real_states(go2_model: mujoco.MjModel) -> RealStates:
    """24 robots in motion, some on their feet, some falling; turned about all axes."""
    from tests.rl.physics.real_states import shaken

    return shaken(go2_model)
