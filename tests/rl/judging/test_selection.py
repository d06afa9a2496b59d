"""The policy of a run is the best of its late checkpoints and their mean, as the validation sees it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rl.judging.selection import select
from rl.judging.validation import Validation
from rl.learning import checkpoint, config_file, run_dir
from rl.learning.export import export_policy
from rl.learning.presets import preset
from rl.learning.trainer import Trainer
from symdyn.errors import FileProblem
from symdyn.policy.file import Policy
from tests.robots import GO2

OBS = np.random.default_rng(0).normal(size=(5, 59))


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run with four checkpoints."""
    path = tmp_path_factory.mktemp("run")
    config = replace(preset("smoke"), iterations=4, keep_every=1, stages=())
    config_file.save(config, path / run_dir.CONFIG)
    assert Trainer(config, path).train()
    assert len(checkpoint.list_checkpoints(path)) == 4
    return path


def close_to(wanted: np.ndarray):
    """A judge that likes a policy the better the closer its actions are to these."""

    def judge(policy: Policy) -> Validation:
        return Validation(float(np.abs(policy.act(OBS) - wanted).max()), 1.0, 0.0, 0.0, 0.0, 0.0)

    return judge


@pytest.mark.parametrize("which", [1, 2, 3, "mean"])
def test_the_candidate_with_the_least_cost_is_exported(run: Path, tmp_path: Path, which: int | str) -> None:
    paths = checkpoint.list_checkpoints(run)
    taken = paths[1:] if which == "mean" else [paths[int(which)]]
    wanted = Policy.load(export_policy(run, tmp_path / "wanted.onnx", taken), GO2).act(OBS)
    best = select(run, GO2, late=3, judge=close_to(wanted))
    assert list(best.checkpoints) == taken
    assert np.array_equal(Policy.load(run / run_dir.POLICY, GO2).act(OBS), wanted)
    said = json.loads((run / run_dir.SELECTION).read_text())
    assert said["chosen"] == best.name
    assert len(said["candidates"]) == 4
    assert min(entry["cost"] for entry in said["candidates"].values()) == said["candidates"][best.name]["cost"]


def test_a_run_without_checkpoints_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileProblem, match="contains no checkpoint"):
        select(tmp_path, GO2, late=3)


def test_a_worse_number_never_costs_less() -> None:
    good = Validation(0.05, 0.98, 0.05, 0.05, 0.05, 0.0)
    worse = {
        "gc_stance": 0.1,
        "identity": 0.9,
        "speed_error": 0.1,
        "yaw_error": 0.1,
        "lateral_error": 0.1,
        "fell": 0.02,
    }
    for name, value in worse.items():
        assert replace(good, **{name: value}).cost > good.cost
