"""The environment against the bare physics under it."""

from __future__ import annotations

import resource
import subprocess
import sys
import time

import torch
from mujoco.batch import MODEL_FIELDS, Batch

from benchmarks.result import Result, in_turns
from rl.learning.presets import preset
from rl.physics.batch import BatchPhysics
from rl.physics.model import build_model
from rl.task.env import GaitEnv
from symdyn.gait.timing import TimingCurve
from symdyn.robot.robot_file import DEFAULT_ROBOT, get_robot

_ENVS = 1024
_STEPS = 15
_ROUNDS = 9
_MANY = 2048


def make_env(num_envs: int) -> GaitEnv:
    """The environment of the default preset."""
    robot, config = get_robot(DEFAULT_ROBOT), preset("cpu")
    physics = BatchPhysics(build_model(robot, engine=config.engine), robot, num_envs)
    return GaitEnv(config.env, physics, TimingCurve(), robot)


def bare_batch(env: GaitEnv) -> Batch:
    """The same model, threads and per-simulation dynamics with nothing around them."""
    physics = env.physics
    assert isinstance(physics, BatchPhysics)
    bare = Batch(physics.model, env.num_envs)
    for name in MODEL_FIELDS:
        if (values := physics.batch.expanded(name)) is not None:
            bare.expand(name)[:] = values
    return bare


def measure() -> list[Result]:
    """Throughput ratio at 1024 robots; memory and construction time of 2048."""
    env = make_env(_ENVS)
    bare = bare_batch(env)
    physics = env.physics
    assert isinstance(physics, BatchPhysics)
    actions = torch.randn(_ENVS, env.num_actions, generator=torch.Generator().manual_seed(0))

    def step_env() -> None:
        for _ in range(_STEPS):
            env.step(actions)

    def step_bare() -> None:
        bare.state[:] = physics.batch.state  # the same contacts, and so the same work
        for _ in range(_STEPS):
            bare.step(nstep=physics.substeps)

    env_s, bare_s = in_turns([step_env, step_bare], _ROUNDS)
    details = {"env_steps_per_s": _ENVS * _STEPS / env_s, "bare_steps_per_s": _ENVS * _STEPS / bare_s}
    ratio = Result(f"environment / bare Batch.step, {_ENVS} robots", bare_s / env_s, "", at_least=0.75, details=details)
    return [ratio, *_many()]


def _many() -> list[Result]:
    # in a process of its own: the peak of memory is the process's
    code = "import benchmarks.environment as e; e.report_many()"
    printed = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout
    seconds, peak = map(float, printed.split()[-2:])
    return [
        Result(f"memory of a process with {_MANY} robots", peak, "GiB", at_most=2.0),
        Result(f"construction of {_MANY} robots", seconds, "s", at_most=10.0),
    ]


def report_many() -> None:
    """Build and step many robots; print seconds of construction and peak memory, GiB."""
    start = time.perf_counter()
    env = make_env(_MANY)
    built = time.perf_counter() - start
    for _ in range(5):
        env.step(torch.zeros(_MANY, env.num_actions))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    sys.stdout.write(f"{built} {peak}\n")
