"""Run a policy file through scripted commands on the nominal robot or on one machine, and record it at the rate
of the physics.

Nothing of the task is restated here: clock, observation, timing, model, falls and frames are the functions that
training calls.
"""

# mujoco is a compiled module without stubs
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import TypeVar

import mujoco
import numpy as np
import torch
from numpy.typing import NDArray

from rl.physics import fitted
from rl.physics.batch import BatchPhysics
from rl.physics.model import build_model
from rl.physics.protocol import Pose, RobotState, heading_velocity
from rl.physics.terrain import Terrain
from rl.task.settings import TerminationConfig
from rl.task.termination import fallen
from symdyn.analysis.recording import Recording
from symdyn.errors import InvalidValue
from symdyn.gait.library import Gait
from symdyn.gait.timing import GRAVITY
from symdyn.policy.driver import PolicyDriver
from symdyn.policy.file import Policy
from symdyn.policy.observation import Sensed
from symdyn.robot.definition import Robot
from symdyn.robot.fit import Fit
from symdyn.robot.frames import projected_gravity, yaw

CONTACT_FORCE = 1.0
"""N; a foot that bears more is in contact."""

_AT_ONCE = 96

K = TypeVar("K")

Build = Callable[[Robot, Terrain | None], mujoco.MjModel]
"""Makes the model of a robot on a terrain, such as :func:`rl.physics.model.build_model`."""


@dataclass(frozen=True)
class Segment:
    """From ``start`` on (s), run this gait at this velocity (v_x, v_y in m/s, yaw rate in rad/s)."""

    start: float
    gait: Gait
    velocity: tuple[float, float, float]


@dataclass(frozen=True)
class Script:
    """Commands of one episode.

    Attributes:
        name: what to call it.
        segments: in order of time; the first starts at 0.
        duration: s.
        seed: decides the initial stride phase.
        position: where the robot starts, x and y in m.
        heading: direction that it starts in, rad from the x axis.
    """

    name: str
    segments: tuple[Segment, ...]
    duration: float
    seed: int = 0
    position: tuple[float, float] = (0.0, 0.0)
    heading: float = 0.0

    def __post_init__(self) -> None:
        starts = [segment.start for segment in self.segments]
        if not starts or starts[0] != 0.0 or starts != sorted(set(starts)) or self.duration <= starts[-1]:
            raise InvalidValue(
                f"The segments of script {self.name!r}", starts, "rising times from 0 to below the duration"
            )


@dataclass(frozen=True)
class Episode:
    """A script and what came of it.

    Attributes:
        script: the commands.
        recording: until the end or the fall.
        fell_at: time of the fall, s, or None.
    """

    script: Script
    recording: Recording
    fell_at: float | None


def run(
    policy: Policy,
    scripts: Sequence[Script],
    on_progress: Callable[[int], None] | None = None,
    terrain: Terrain | None = None,
    build: Build = build_model,
    fit: Fit | None = None,
) -> list[Episode]:
    """Run every script; the results are in the order of the scripts and do not depend on how they are grouped.

    Args:
        policy: to run.
        scripts: any number.
        on_progress: called with the number of scripts done.
        terrain: what the robots run on; a flat floor if None.
        build: the model that they are.
        fit: the machine that runs; the nominal robot if None.
    """
    order = sorted(range(len(scripts)), key=lambda i: scripts[i].duration)
    found: dict[int, Episode] = {}
    for group in _groups(order):
        episodes = _run_together(policy, [scripts[i] for i in group], terrain, build, fit)
        found.update(zip(group, episodes, strict=True))
        if on_progress is not None:
            on_progress(len(found))
    return [found[i] for i in range(len(scripts))]


def run_grouped(
    policy: Policy,
    groups: Mapping[K, Sequence[Script]],
    on_progress: Callable[[int, int], None] | None = None,
    terrain: Terrain | None = None,
    build: Build = build_model,
    fit: Fit | None = None,
) -> dict[K, list[Episode]]:
    """Run groups of scripts all together: the episodes of each group, in the order of its scripts.

    Args:
        policy: to run.
        groups: of scripts.
        on_progress: called with the number of scripts done and that of all.
        terrain: as for :func:`run`.
        build: as for :func:`run`.
        fit: likewise.
    """
    scripts = [script for group in groups.values() for script in group]
    watch = None if on_progress is None else lambda done: on_progress(done, len(scripts))
    episodes = iter(run(policy, scripts, watch, terrain, build, fit))
    return {key: list(islice(episodes, len(group))) for key, group in groups.items()}


def _groups(order: list[int]) -> Iterator[list[int]]:
    for start in range(0, len(order), _AT_ONCE):
        yield order[start : start + _AT_ONCE]


class _Commands:
    """The scripts of several robots, told to their driver when it is time."""

    def __init__(self, scripts: Sequence[Script], driver: PolicyDriver) -> None:
        self._scripts = scripts
        self._driver = driver
        self._next = [0] * len(scripts)

    def at(self, time: float) -> None:
        """Take over all segments that have started."""
        for i, script in enumerate(self._scripts):
            while self._next[i] < len(script.segments) and script.segments[self._next[i]].start <= time + 1e-9:
                segment = script.segments[self._next[i]]
                self._driver.offsets[i] = segment.gait.theta
                self._driver.velocity[i] = segment.velocity
                self._next[i] += 1


def _run_together(
    policy: Policy, scripts: Sequence[Script], terrain: Terrain | None, build: Build, fit: Fit | None
) -> list[Episode]:
    robot = policy.robot
    n = len(scripts)
    model = build(robot, terrain)
    if fit is not None:
        fitted.fit_joints(model, robot, fit)
    physics = BatchPhysics(model, robot, n)
    if fit is not None:
        physics.set_dynamics(fitted.dynamics(fit, n))
    offset = physics.dynamics.joint_offset
    physics.reset(np.arange(n), standing(scripts, robot, terrain))
    driver = PolicyDriver(policy, [np.random.default_rng(script.seed).random() for script in scripts])
    commands = _Commands(scripts, driver)
    steps = round(max(script.duration for script in scripts) / robot.control_dt)
    at_rest = policy.targets(np.zeros_like(driver.action))
    samples: list[dict[str, NDArray]] = []
    fell_at = np.full(n, np.inf)
    limits = TerminationConfig()
    state = physics.read()
    for step in range(steps):
        time = step * robot.control_dt
        commands.at(time)
        targets = driver.act(sensed(state, offset))
        physics.set_targets(np.where(np.isfinite(fell_at)[:, None], at_rest, targets))
        for _ in range(physics.substeps):
            physics.substep()
            driver.advance(robot.control_dt / physics.substeps)
            state = physics.read()
            samples.append(sample(state, driver))
        ground = 0.0 if terrain is None else terrain.height(np.nan_to_num(_numpy(state.base_pos_w)[:, :2]))
        down = (fallen(state, limits, torch.as_tensor(ground)) | ~state.finite()).numpy() & np.isinf(fell_at)
        fell_at[down] = time + robot.control_dt
        if np.isfinite(fell_at).all():  # all that a recording would have is there
            break
    columns = {key: np.stack([sample[key] for sample in samples], axis=1) for key in samples[0]}
    dt = robot.control_dt / physics.substeps
    mass = float(physics.model.body_mass.sum())
    episodes = []
    for i, script in enumerate(scripts):
        fell = float(fell_at[i]) if fell_at[i] < script.duration else None
        last = round((script.duration if fell is None else fell) / dt)
        arrays = {key: column[i, :last] for key, column in columns.items()}
        episodes.append(Episode(script, Recording(dt=dt, mass=mass, gravity=GRAVITY, **arrays), fell))
    return episodes


def standing(scripts: Sequence[Script], robot: Robot, terrain: Terrain | None) -> Pose:
    """Where the robots of these scripts begin: in their nominal stance on the ground."""
    n = len(scripts)
    planar, half = np.array([s.position for s in scripts]), np.array([s.heading for s in scripts]) / 2.0
    ground = np.zeros(n) if terrain is None else terrain.highest_near(planar, robot.leg_length)
    position = np.column_stack([planar, ground + robot.base_height_range[0]])
    turned = np.column_stack([np.cos(half), np.zeros((n, 2)), np.sin(half)])
    return Pose(position, turned, np.zeros((n, 3)), np.tile(robot.default_joint_pos, (n, 1)))


def _numpy(tensor: torch.Tensor) -> NDArray[np.float64]:
    return tensor.double().numpy()


def sensed(state: RobotState, joint_offset: NDArray[np.float64] | float = 0.0) -> Sensed:
    """What the sensors of simulated robots say; encoders show ``joint_offset``, (N, 12) rad, too much.

    Numbers that are not finite, of a robot that diverged, become zero.
    """
    gravity_b = projected_gravity(_numpy(state.base_quat_w))
    told = (
        gravity_b,
        _numpy(state.joint_pos) + joint_offset,
        _numpy(state.joint_vel),
        _numpy(state.base_ang_vel_b),
        yaw(_numpy(state.base_quat_w)),
    )
    return Sensed(*(np.nan_to_num(array) for array in told))


def sample(state: RobotState, driver: PolicyDriver) -> dict[str, NDArray]:
    """One sample of a recording of n robots: the fields of :class:`symdyn.analysis.recording.Recording`, (n, ...)."""
    timing = driver.timing()
    return {
        "velocity_command": driver.command.copy(),
        "velocity_h": _numpy(heading_velocity(state)),
        "base_pos_w": _numpy(state.base_pos_w),
        "base_quat_w": _numpy(state.base_quat_w),
        "joint_pos": _numpy(state.joint_pos),
        "joint_vel": _numpy(state.joint_vel),
        "joint_torque": _numpy(state.joint_torque),
        "contact": (state.foot_force_w.norm(dim=-1) > CONTACT_FORCE).numpy(),
        "desired_stance": timing.desired_stance,
        "stride_phase": driver.phase,
        "offsets": driver.offsets.copy(),
        "period": timing.period,
        "duty": timing.duty,
    }
