"""What several packages' tests share: one thread a process, reproducible properties, the robot and its mirror image."""

from __future__ import annotations

import os

# before anything imports torch: the tests' tensors are small, and idle threads that spin slow everything else down
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
# and a process that the tests start would otherwise compile torch anew, which takes it 15 s
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

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
        "test_bridge_command.py",
        "test_deploy_command.py",
        "test_realtime.py",
        "test_robot_sim_command.py",
        "test_robot_sim_session.py",
    }
)
"""Files whose tests run processes by the clock: marked ``realtime``, for ``make test`` to run them alone."""

LONGEST = (
    "test_docs.py",
    "test_controller.py",
    "test_notebooks.py",
    "test_experiments.py",
    "test_explore.py",
    "test_identify.py",
    "test_leg_order.py",
    "test_velocity.py",
    "test_export.py",
    "test_trainer.py",
)
"""Slow files that take longest, the longest first: begun last, one of them would keep a single process busy."""

SLOW = frozenset(
    {
        "robot_sim/test_faults.py",
        "test_analyze_command.py",
        "test_animation.py",
        "test_bad_input.py::test_a_process_of_its_own_says_it_on_standard_error_with_exit_code_2",
        "test_command_line.py",
        "test_contact.py",
        "test_controller.py",
        "test_curves_commands.py",
        "test_docs.py",
        "test_experiments.py::test_gaits_has_a_number_for_every_gait_and_speed_and_its_targets_are_their_extremes",
        "test_experiments.py::test_reversal_compares_the_same_speeds_both_ways",
        "test_experiments.py::test_terrain_and_robustness_see_a_policy_that_falls_and_one_that_does_not",
        "test_experiments.py::test_the_ablation_takes_every_policy_and_policies_that_are_alike_come_out_alike",
        "test_experiments.py::test_the_cost_of_transport_is_a_mean_over_gaits_at_the_papers_speeds",
        "test_experiments.py::test_the_path_of_mixtures_passes_through_the_named_gaits",
        "test_experiments.py::test_transitions_try_every_ordered_pair_and_the_table_counts_them",
        "test_experiments.py::test_velocity_and_gaits_agree_with_the_evaluation_of_the_same_episodes",
        "test_excitation.py",
        "test_explore.py",
        "test_export.py",
        "test_figures.py",
        "test_film.py",
        "test_gaits.py",
        "test_headless_gl.py",
        "test_identification.py",
        "test_identify.py",
        "test_leg_order.py::test_no_other_order_of_the_legs_passes_the_stand",
        "test_live.py",
        "test_morphology.py",
        "test_notebooks.py",
        "test_own_robot.py",
        "test_parallel.py",
        "test_play_command.py",
        "test_plots.py",
        "test_points.py",
        "test_record_command.py",
        "test_runner.py",
        "test_scene.py",
        "test_second_model.py::test_its_targets_are_the_extremes_of_its_table",
        "test_seeds.py::test_each_run_is_what_it_is_alone_and_an_interrupted_one_goes_on",
        "test_selection.py",
        "test_simulated_robot.py",
        "test_slip_commands.py",
        "test_sweep.py",
        "test_sweep_command.py",
        "test_symmetry_command.py",
        "test_trainer.py",
        "test_trial_choice.py",
        "test_velocity.py",
    }
)
"""Files and tests that ``make test-quick`` leaves out: marked ``slow``. A file takes a dozen seconds or more, or needs
a browser, a renderer or other processes."""


def among(item: pytest.Item, names: frozenset[str]) -> bool:
    """Whether the names have the file of a test, with its folder or without, or the test as ``file::test``."""
    file, test = item.path.name, item.name.partition("[")[0]
    return not names.isdisjoint((file, f"{item.path.parent.name}/{file}", f"{file}::{test}"))


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if among(item, REAL_TIME):
            item.add_marker(pytest.mark.realtime)
        if among(item, SLOW):
            item.add_marker(pytest.mark.slow)
    # slow files first: where files go to processes, the last ones are then short, and no process waits for another
    files = frozenset(name.partition("::")[0] for name in SLOW)
    rank = {name: place for place, name in enumerate(LONGEST)}
    items.sort(key=lambda item: rank.get(item.path.name, len(rank) + (not among(item, files))))


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
