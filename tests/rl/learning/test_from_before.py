"""Runs and policy files from before robots and observations were data: ``runs/go2-f`` is one, and must still load."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from rl.learning import checkpoint, config_file, run_dir
from rl.learning.export import export_policy
from symdyn.errors import FileProblem
from symdyn.gait.timing import TimingCurve
from symdyn.io.files import read_json
from symdyn.policy.file import Policy
from symdyn.policy.observation import LAYOUTS
from tests.robots import GO2

RUN = Path(__file__).parents[3] / "runs" / "go2-f"


def test_the_run_is_one_from_before() -> None:
    settings = yaml.safe_load((RUN / run_dir.CONFIG).read_text())
    assert "robot" not in settings
    assert "observation" not in settings["env"]
    assert "robot" not in checkpoint.load_newest(RUN)
    assert "robot" not in read_json(RUN / run_dir.TIMING)
    assert not (RUN / run_dir.ROBOT).exists()


def test_settings_that_its_file_lacks_take_their_defaults() -> None:
    config = config_file.load(RUN / run_dir.CONFIG)
    assert (config.robot, config.env.observation) == ("go2", "paper")
    assert run_dir.robot(RUN, config.robot) == GO2
    assert run_dir.timing(RUN, config.timing, GO2) == TimingCurve.load(RUN / run_dir.TIMING)


def test_its_checkpoint_is_exported_as_it_was_then(tmp_path: Path) -> None:
    now, then = Policy.load(export_policy(RUN, tmp_path / "policy.onnx")), Policy.load(RUN / run_dir.POLICY)
    assert now.metadata.observation == then.metadata.observation == LAYOUTS["paper"]
    assert now.robot == then.robot == GO2
    assert now.metadata.training["samples"] == then.metadata.training["samples"]
    obs = np.random.default_rng(0).normal(size=(64, 52))
    assert np.array_equal(now.act(obs), then.act(obs))


def test_a_checkpoint_of_another_robot_is_refused() -> None:
    checkpoint.check_robot({"iteration": 3}, "go2", "run")
    checkpoint.check_robot({"iteration": 3, "robot": "go2"}, "go2", "run")
    with pytest.raises(FileProblem, match=r"^run: holds a checkpoint of the robot 'solo12', not of 'go2'"):
        checkpoint.check_robot({"iteration": 3, "robot": "solo12"}, "go2", "run")
