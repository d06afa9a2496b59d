"""Simulations that diverge: reset alone, logged, and dumped."""

from __future__ import annotations

import json
import logging
import math
from pathlib import Path

import pytest
import torch

from rl.physics.randomization import NOMINAL
from rl.task.settings import CommandConfig
from tests.rl.task.envs import diverge, make, random_actions, trajectory


@pytest.mark.parametrize("value", [math.nan, math.inf, 1e30])
def test_a_diverged_simulation_is_reset_alone_and_logged(value: float, caplog: pytest.LogCaptureFixture) -> None:
    sick, well = (make(n=4, seed=1, randomization=NOMINAL) for _ in range(2))
    actions = random_actions(4, 10, scale=0.3)
    trajectory(sick, actions[:5])
    trajectory(well, actions[:5])
    diverge(sick, 2, value)
    with caplog.at_level(logging.WARNING, logger="rl.task.env"):
        obs, reward, done, extras = sick.step(actions[5].clone())
    assert "1 of 4 simulations diverged and are reset: [2]" in caplog.text
    expected_obs, expected_reward, _, _ = well.step(actions[5].clone())
    others = [0, 1, 3]
    for group in ("policy", "privileged"):
        assert torch.equal(obs[group][others], expected_obs[group][others])
        assert torch.isfinite(obs[group]).all()
    assert torch.equal(reward[others], expected_reward[others])
    assert float(reward[2]) == 0.0
    assert done.tolist() == [0, 0, 1, 0]
    assert not extras["time_outs"].any()
    assert all(math.isfinite(float(v)) for v in extras["log"].values())
    # and it goes on as a healthy robot
    for action in actions[6:]:
        obs, reward, done, _ = sick.step(action.clone())
        assert torch.isfinite(obs["policy"]).all()
        assert torch.isfinite(reward).all()
        assert not done.any()


def test_a_diverged_simulation_is_dumped_and_can_be_read_back(tmp_path: Path) -> None:
    env = make(n=3, dump_dir=tmp_path / "diverged")
    env.step(torch.zeros(3, 12))
    command, dynamics = env.commands.state_dict(), env.physics.dynamics
    diverge(env, 1)
    env.step(torch.zeros(3, 12))
    (file,) = (tmp_path / "diverged").iterdir()
    dump = json.loads(file.read_text())
    assert dump["env"] == 1
    assert dump["commands"]["offsets"] == command["offsets"][1].tolist()
    assert dump["commands"]["velocity"] == command["velocity"][1].tolist()
    assert {name: dump[name] for name in vars(dynamics)} == dynamics.of(1)
    assert {name: len(dump[name]) for name in ("qpos", "qvel", "ctrl")} == {"qpos": 19, "qvel": 18, "ctrl": 12}
    assert any(math.isnan(float(x)) for x in dump["qvel"])  # the culprit stands in it


def test_a_simulation_that_diverges_after_the_last_change_of_command_is_dumped(tmp_path: Path) -> None:
    # with the paper's schedule: any time after 10 s
    env = make(n=2, dump_dir=tmp_path / "diverged", commands=CommandConfig(velocity_first_s=(0.02, 0.02)))
    env.step(torch.zeros(2, 12))
    diverge(env, 1)
    env.step(torch.zeros(2, 12))
    (file,) = (tmp_path / "diverged").iterdir()
    assert json.loads(file.read_text())["env"] == 1


def test_an_action_that_is_no_number_ends_its_robots_episode_alone() -> None:
    env, actions = make(n=3), torch.zeros(3, 12)
    actions[1, 4] = math.nan
    obs, reward, done, extras = env.step(actions)
    assert done.tolist() == [0, 1, 0]
    assert torch.isfinite(reward).all()
    assert torch.isfinite(obs["policy"]).all()
    assert all(math.isfinite(float(v)) for v in extras["log"].values())
