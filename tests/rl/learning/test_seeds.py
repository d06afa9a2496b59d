"""Several seeds: each run is what it would be alone, they stop and go on together, and there must be room for them."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest
import torch
from rich.console import Console

from rl.cli.arguments.train import parse
from rl.cli.train_seeds import train_seeds
from rl.learning import checkpoint, config_file, run_dir, seeds
from rl.learning.presets import preset
from rl.learning.trainer import Trainer
from symdyn.errors import InvalidValue

COMMAND = [sys.executable, "-m", "symdyn", "train"]


def weights(run: Path) -> torch.Tensor:
    state = checkpoint.load_newest(run)["ppo"]["actor_state_dict"]
    return torch.cat([value.flatten() for value in state.values()])


def test_each_run_is_what_it_is_alone_and_an_interrupted_one_goes_on(tmp_path: Path) -> None:
    together = tmp_path / "three"
    settings = tmp_path / "settings.yaml"
    config_file.save(replace(preset("smoke"), threads=1), settings)
    process = subprocess.Popen(
        [*COMMAND, "--settings", str(settings), "--seeds", "3", "--seed", "4", "--out", str(together)],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    # the third seed waits for a processor where there are two; stop all as soon as one has written a checkpoint
    deadline = time.monotonic() + 120.0
    while not list(together.glob("seed-*/checkpoints/*.pt")) and time.monotonic() < deadline:
        time.sleep(0.05)
    process.send_signal(signal.SIGTERM)
    said = process.communicate()[0]
    assert process.returncode in (0, 130), said
    again = subprocess.run([*COMMAND, "--resume", str(together)], capture_output=True, text=True)
    assert again.returncode == 0, again.stdout + again.stderr
    assert [run.seed for run in seeds.runs_of(together)] == [4, 5, 6]
    for run in seeds.runs_of(together):
        assert run.finished(config_file.load(settings))
        alone = tmp_path / f"alone-{run.seed}"
        config = replace(config_file.load(settings), seed=run.seed, threads=1)
        trainer = Trainer(config, alone)
        trainer.train()
        torch.testing.assert_close(weights(run.directory), weights(alone), rtol=0.0, atol=0.0)


def test_runs_without_room_are_refused_before_anything_is_written(tmp_path: Path) -> None:
    config = preset("cpu")
    out = tmp_path / "many"
    with pytest.raises(InvalidValue, match=r"--seeds is 100000000, but must be fewer.*of disk"):
        seeds.begin(out, config, 100_000_000)
    big = replace(config, num_envs=100_000_000)
    with pytest.raises(InvalidValue, match=r"--seeds is 1, but must be fewer.*of memory"):
        seeds.begin(out, big, 1)
    with pytest.raises(InvalidValue, match="a whole number > 0"):
        seeds.begin(out, config, 0)
    assert not out.exists()


def test_the_room_that_is_asked_for_is_at_least_what_a_run_takes(tmp_path: Path) -> None:
    config = replace(preset("smoke"), num_envs=64)
    trainer = Trainer(config, tmp_path)
    trainer._save()
    (file,) = checkpoint.list_checkpoints(tmp_path)
    guessed = seeds._DISK_OF_A_NETWORK + config.num_envs * seeds._DISK_OF_A_ROBOT
    assert file.stat().st_size < 1.3 * guessed


def test_seeds_are_refused_with_resume(tmp_path: Path) -> None:
    config_file.save(preset("smoke"), tmp_path / run_dir.CONFIG)
    with pytest.raises(InvalidValue, match="--seeds is '3', but must be left out with --resume"):
        parse(["--resume", str(tmp_path), "--seeds", "3"])


def test_settings_that_several_seeds_would_ignore_are_refused(tmp_path: Path) -> None:
    seeds.begin(tmp_path, preset("smoke"), 2)
    args = parse(["--resume", str(tmp_path), "--iterations", "99"])
    with pytest.raises(InvalidValue, match="--iterations is 99, but must be left out when several seeds are continued"):
        train_seeds(tmp_path, args, Console(quiet=True))


def test_the_table_has_what_each_seed_chose(tmp_path: Path) -> None:
    config = preset("smoke")
    runs = seeds.begin(tmp_path / "runs", config, 2)
    for run, identity in zip(runs, (0.5, 1.0), strict=True):
        run.directory.mkdir()
        candidates = {"a": {"identity": identity}, "b": {"identity": 0.0}}
        (run.directory / run_dir.SELECTION).write_text(json.dumps({"chosen": "a", "candidates": candidates}))
        (run.directory / "progress.jsonl").write_text('{"samples": 3000000, "time/seconds": 120.0}\n{"samples": 31')
    assert seeds.table(runs) == {
        "seed 0": {"identity": 0.5, "samples_millions": 3.0, "minutes": 2.0},
        "seed 1": {"identity": 1.0, "samples_millions": 3.0, "minutes": 2.0},
    }


def test_as_many_runs_train_at_a_time_as_there_are_processors() -> None:
    assert seeds.side_by_side(1) == 1
    assert seeds.side_by_side(10_000) == os.cpu_count()
