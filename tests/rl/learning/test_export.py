"""From a real, tiny training run to its policy file."""

from __future__ import annotations

import json
import logging
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import pytest
import torch
from tensordict import TensorDict

from rl.learning import checkpoint, config_file, export, run_dir
from rl.learning.config import TrainConfig
from rl.learning.export import export_policy
from rl.learning.presets import preset
from rl.learning.stages import Stage
from rl.learning.trainer import Trainer
from symdyn.errors import FileProblem
from symdyn.gait.library import LIBRARY, get
from symdyn.gait.timing import GRAVITY, TimingCurve
from symdyn.io.origin import commit
from symdyn.io.settings_data import rebuild
from symdyn.policy.file import GOLDEN_KEY, METADATA_KEY, Policy
from symdyn.policy.observation import get_layout
from tests.robots import GO2

LAYOUT = get_layout(preset("smoke").env.observation)
OBS = torch.randn(100, LAYOUT.size, generator=torch.Generator().manual_seed(1))
CURVE = TimingCurve(a_T=1.0 / 3.0 + 2.0, source="a test")


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Trainer]:
    """A run of three updates, with a timing curve of its own."""
    directory = tmp_path_factory.mktemp("trained")
    curves, run = directory / "curves.json", directory / "run"
    CURVE.save(curves)
    run.mkdir()
    config = replace(preset("smoke"), timing=curves, seed=11)
    config_file.save(config, run / run_dir.CONFIG)
    trainer = Trainer(config, run)
    assert trainer.train()
    return run, trainer


@pytest.fixture(scope="module")
def exported(trained: tuple[Path, Trainer], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The policy file of that run, in a folder that was not there before. Not to be changed."""
    out = tmp_path_factory.mktemp("exported") / "new folder" / "any name.onnx"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(export, "commit", lambda: "commit of rl")
        assert export_policy(trained[0], out) == out
    return out


@pytest.fixture
def run(trained: tuple[Path, Trainer], tmp_path: Path) -> Path:
    """A copy of the run, to be spoiled."""
    copy = tmp_path / "run"
    shutil.copytree(trained[0], copy)
    return copy


def files(directory: Path) -> set[Path]:
    """Everything below a directory, hidden files too."""
    return set(directory.rglob("*")) | set(directory.rglob(".*"))


def actions_of(trainer: Trainer) -> np.ndarray:
    """What the trained actor itself does on :data:`OBS`, (100, 12)."""
    with torch.inference_mode():
        return trainer.ppo.get_policy()(TensorDict({"policy": OBS}, batch_size=[len(OBS)])).numpy()


def spoil(run: Path, change: Callable[[dict[str, Any]], object]) -> Path:
    """Change the newest checkpoint of a run."""
    path = checkpoint.list_checkpoints(run)[-1]
    content = checkpoint.load(path)
    change(content)
    torch.save(content, path)
    return path


class TestGood:
    def test_gives_the_actors_actions(self, trained: tuple[Path, Trainer], exported: Path) -> None:
        actions = Policy.load(exported).act(OBS.numpy())
        np.testing.assert_allclose(actions, actions_of(trained[1]), rtol=0.0, atol=1e-5)

    @pytest.mark.parametrize("equivariant", [False, True])
    def test_gives_the_actions_of_either_kind_of_actor(self, tmp_path: Path, equivariant: bool) -> None:
        config = preset("smoke")
        ppo = replace(config.ppo, equivariant=equivariant, hidden=(32, 16))
        config = replace(config, num_envs=4, iterations=1, ppo=ppo)
        config_file.save(config, tmp_path / run_dir.CONFIG)
        trainer = Trainer(config, tmp_path)
        assert trainer.train()
        actions = Policy.load(export_policy(tmp_path)).act(OBS.numpy())
        np.testing.assert_allclose(actions, actions_of(trainer), rtol=0.0, atol=1e-5)

    def test_is_one_file(self, exported: Path) -> None:
        assert files(exported.parent) == {exported}

    def test_goes_into_the_run(self, run: Path) -> None:
        before = files(run)
        path = export_policy(run)
        assert path == run / "policy.onnx"
        assert files(run) - before == {path}
        assert path.stat().st_mode == (run / run_dir.CONFIG).stat().st_mode

    def test_metadata(self, trained: tuple[Path, Trainer], exported: Path) -> None:
        meta = Policy.load(exported).metadata
        config = config_file.load(trained[0] / run_dir.CONFIG)
        assert meta.joint_names == GO2.joint_names
        assert meta.default_joint_pos == tuple(GO2.default_joint_pos)
        assert (meta.action_scale, meta.kp, meta.kd, meta.control_dt) == (0.25, 30.0, 0.65, 0.02)
        assert (meta.leg_length, meta.gravity) == (GO2.leg_length, GRAVITY)
        assert meta.timing == CURVE
        assert dict(meta.gaits) == {name: get(name) for name in LIBRARY}
        commands = {"velocity_x": (-2.0, 2.0), "velocity_y": (-0.4, 0.4), "yaw_rate": (-1.0, 1.0)}
        assert dict(meta.command_range) == commands
        assert meta.steering is None
        assert meta.time_reversal is True
        assert meta.training["samples"] == 3 * 16 * 8
        assert meta.training["seed"] == 11
        assert meta.training["commit"] == "commit of rl"
        assert rebuild(TrainConfig, meta.training["config"], "the policy") == config

    def test_metadata_is_of_the_stage_that_the_run_has_reached(self, tmp_path: Path) -> None:
        steered = {"env.commands.steered": True, "env.commands.yaw_rate": [-0.5, 0.5]}
        stages = (Stage("a", samples=128.0), Stage("b", samples=128.0, settings=steered))
        config = replace(preset("smoke"), stages=stages)
        config_file.save(config, tmp_path / run_dir.CONFIG)
        assert Trainer(config, tmp_path).train()
        meta = Policy.load(export_policy(tmp_path)).metadata
        assert meta.steering == config.env.commands.steering
        assert meta.command_range["yaw_rate"] == (-0.5, 0.5)

    def test_metadata_has_the_keys_of_the_contract(self, exported: Path) -> None:
        props = {p.key: p.value for p in onnx.load(exported).metadata_props}
        assert set(props) == {METADATA_KEY, GOLDEN_KEY}
        data = json.loads(props[METADATA_KEY])
        assert set(data) == {
            "format_version", "robot", "joint_names", "default_joint_pos", "action_scale", "kp", "kd", "control_dt",
            "leg_length", "gravity", "observation", "gaits", "timing", "command_range", "time_reversal", "training",
        }  # fmt: skip
        assert set(data["training"]) == {"commit", "config", "samples", "seed"}
        assert data["format_version"] == 1
        assert data["gaits"]["half_bound_left"] == {"LH": 0.0, "LF": 0.63, "RF": 0.37, "RH": 0.0}

    def test_says_nothing_and_tells_no_paths(self, run: Path) -> None:
        # in a process of its own, as much of the exporter's chatter comes but once
        code = (
            f"from pathlib import Path; from rl.learning.export import export_policy; export_policy(Path({str(run)!r}))"
        )
        said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        assert (said.stdout, said.stderr) == ("", "")
        assert b"site-packages" not in (run / "policy.onnx").read_bytes()

    def test_leaves_logging_as_it_was(self, run: Path, caplog: pytest.LogCaptureFixture) -> None:
        export_policy(run)
        logging.getLogger("rl").warning("still heard")
        assert [record.getMessage() for record in caplog.records if record.name == "rl"] == ["still heard"]

    def test_is_reproducible(self, run: Path, exported: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(export, "commit", lambda: "commit of rl")
        assert export_policy(run).read_bytes() == exported.read_bytes()

    def test_a_given_checkpoint(self, run: Path, exported: Path) -> None:
        older = checkpoint.list_checkpoints(run)[-2]
        policy = Policy.load(export_policy(run, checkpoints=(older,)))
        assert policy.metadata.training["samples"] == 2 * 16 * 8
        obs = np.ones((1, LAYOUT.size))
        assert not np.array_equal(policy.act(obs), Policy.load(exported).act(obs))

    def test_of_several_checkpoints_the_mean_of_the_weights(self, run: Path) -> None:
        config = config_file.load(run / run_dir.CONFIG)
        chosen = tuple(checkpoint.list_checkpoints(run)[-2:])
        mixed = checkpoint.load(chosen[0])
        other = checkpoint.load(chosen[1])["ppo"]["actor_state_dict"]
        for name, value in mixed["ppo"]["actor_state_dict"].items():
            mixed["ppo"]["actor_state_dict"][name] = 0.5 * (value + other[name])
        wanted = export.build_actor(mixed, config, run)(OBS).detach().numpy()
        policy = Policy.load(export_policy(run, checkpoints=chosen))
        assert np.abs(policy.act(OBS.numpy()) - wanted).max() < 1e-5
        assert policy.metadata.training["samples"] == int(chosen[-1].stem) * 16 * 8

    def test_a_damaged_newest_checkpoint_gives_way_to_the_one_before(self, run: Path) -> None:
        checkpoint.list_checkpoints(run)[-1].write_bytes(b"PK\x03\x04 cut short")
        assert Policy.load(export_policy(run)).metadata.training["samples"] == 2 * 16 * 8


class TestRefused:
    def refused(self, run: Path, words: str, checkpoint: Path | None = None) -> None:
        """The export fails, and an earlier policy file and everything else stay as they were."""
        run.mkdir(exist_ok=True)
        (run / "policy.onnx").write_bytes(b"an earlier one")
        before = files(run)
        with pytest.raises(FileProblem, match=words) as caught:
            export_policy(run, checkpoints=() if checkpoint is None else (checkpoint,))
        assert "\n" not in str(caught.value)
        assert files(run) == before
        assert (run / "policy.onnx").read_bytes() == b"an earlier one"

    def test_no_directory(self, tmp_path: Path) -> None:
        with pytest.raises(FileProblem, match="nowhere: is not a directory"):
            export_policy(tmp_path / "nowhere")
        assert not (tmp_path / "nowhere").exists()

    def test_no_run(self, tmp_path: Path) -> None:
        self.refused(tmp_path / "empty", r"empty: is not a run of symdyn train: it contains no config.yaml")

    def test_no_checkpoint(self, run: Path) -> None:
        shutil.rmtree(run / "checkpoints")
        self.refused(run, "contains no checkpoint")

    def test_missing_given_checkpoint(self, run: Path) -> None:
        self.refused(run, "0000009.pt: does not exist", run / "checkpoints" / "0000009.pt")

    def test_bad_config(self, run: Path) -> None:
        (run / run_dir.CONFIG).write_text("presets: cpu\n")
        self.refused(run, "config.yaml: has unknown settings: presets")

    def test_other_layers_than_the_settings(self, run: Path) -> None:
        config = config_file.load(run / run_dir.CONFIG)
        config_file.save(replace(config, ppo=replace(config.ppo, hidden=(64,))), run / run_dir.CONFIG)
        self.refused(run, "0.weight 128x59, .*; its settings ask for 0.weight 32x59, .*2.weight 12x32")

    def test_another_kind_of_actor_than_the_settings(self, run: Path) -> None:
        config = config_file.load(run / run_dir.CONFIG)
        other = replace(config, ppo=replace(config.ppo, equivariant=not config.ppo.equivariant))
        config_file.save(other, run / run_dir.CONFIG)
        self.refused(run, "0.weight 128x59, .*; its settings ask for 0.weight 256x59, ")

    def test_missing_timing_file(self, run: Path, tmp_path: Path) -> None:
        config = config_file.load(run / run_dir.CONFIG)
        config_file.save(replace(config, timing=tmp_path / "gone.json"), run / run_dir.CONFIG)
        self.refused(run, "gone.json: cannot be read")

    def test_no_actor(self, run: Path) -> None:
        spoil(run, lambda content: content.pop("ppo"))
        self.refused(run, "without an actor")

    def test_weights_that_are_not_finite(self, run: Path) -> None:
        path = spoil(run, lambda content: list(content["ppo"]["actor_state_dict"].values())[-1].fill_(torch.nan))
        self.refused(run, "not finite")
        self.refused(run, f"{path.name}: holds an actor whose weights are not finite", path)

    def test_an_actor_of_another_kind(self, run: Path) -> None:
        spoil(run, lambda content: content["ppo"]["actor_state_dict"].update({"obs_normalizer._mean": torch.zeros(52)}))
        self.refused(run, "holds an actor with .*obs_normalizer._mean 52")

    def test_a_file_that_acts_otherwise(self, run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        act = Policy.act
        monkeypatch.setattr(Policy, "act", lambda self, obs: act(self, obs) + np.float32(1e-3))
        self.refused(run, "other actions as ONNX than in training")

    def test_interrupted(self, run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        def interrupt(*_: object) -> None:
            raise KeyboardInterrupt

        monkeypatch.setattr(export, "_compare", interrupt)
        before = files(run)
        with pytest.raises(KeyboardInterrupt):
            export_policy(run)
        assert files(run) == before

    def test_unwritable(self, run: Path) -> None:
        before = files(run)
        with pytest.raises(FileProblem, match="cannot be written"):
            export_policy(run, run / "progress.jsonl" / "policy.onnx")
        with pytest.raises(FileProblem, match="cannot be written"):
            export_policy(run, run / "checkpoints")
        assert files(run) == before


class TestCommit:
    @pytest.fixture
    def checkout(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
        (tmp_path / "package").mkdir()
        (tmp_path / "package" / "__init__.py").touch()
        (tmp_path / ".gitignore").write_text("ignored/\n")
        for name in [name for name in os.environ if name.startswith("GIT_")]:
            monkeypatch.delenv(name)  # of a hook that runs the tests
        for arguments in (["init", "-q"], ["add", "."], ["commit", "-q", "-m", "first"]):
            who = ["-c", "user.name=a", "-c", "user.email=a@b"]
            subprocess.run(["git", "-C", str(tmp_path), *who, *arguments], check=True)
        return tmp_path

    def test_clean_and_dirty(self, checkout: Path) -> None:
        clean = commit(checkout / "package")
        assert len(clean) == 40
        (checkout / "package" / "__init__.py").write_text("x = 1\n")
        assert commit(checkout / "package") == f"{clean}-dirty"

    def test_inside_a_hook_of_another_repository(self, checkout: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        clean = commit(checkout / "package")
        monkeypatch.setenv("GIT_DIR", str(checkout / "nowhere"))
        assert commit(checkout / "package") == clean

    def test_installed_inside_somebody_elses_checkout(self, checkout: Path) -> None:
        installed = checkout / "ignored" / "package"
        installed.mkdir(parents=True)
        (installed / "__init__.py").touch()
        assert commit(installed) == "unknown"

    def test_no_checkout(self, tmp_path: Path) -> None:
        (tmp_path / "__init__.py").touch()
        assert commit(tmp_path) == "unknown"

    def test_no_git(self, checkout: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("PATH", "")
        assert commit(checkout / "package") == "unknown"
