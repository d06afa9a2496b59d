"""Every bad input: one clear sentence on standard error, exit code 2, no traceback, nothing half-written."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from symdyn.gait.timing import TimingCurve
from tests.e2e.command_in_process import Done, symdyn


def assert_refused(done: Done, *said: str) -> None:
    assert done.returncode == 2, (done.returncode, done.stdout, done.stderr)
    assert "Traceback" not in done.stderr
    for words in said:
        assert words in " ".join(done.stderr.split()), done.stderr


def files(folder: Path) -> set[Path]:
    return {path.relative_to(folder) for path in folder.rglob("*")}


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("gallop",), ("Unknown command 'gallop'", "gaits")),
        (("gaits", "bond"), ("Unknown gait 'bond'", "Did you mean 'bound'")),
        (("gaits", "--speed", "nan"), ("--speed", "finite")),
        (("gaits", "--timing", "nowhere.json"), ("nowhere.json", "No such file")),
        (("gaits", "--figure", "x.png"), ("--figure", "name of one gait")),
        (("train", "--preset", "gpu"), ("Unknown preset 'gpu'", "cpu, paper, smoke")),
        (("train", "--num-envs", "-4"), ("num_envs", "> 0")),
        (("train", "--iterations", "0"), ("iterations", "> 0")),
        (("train", "--seed", "-1"), ("seed", ">= 0")),
        (("train", "--num-envs", "many"), ("many",)),
        (("train", "--ppo.learning-rate", "nan"), ("learning_rate",)),
        (("train", "--ppo.discount", "1.5"), ("discount", "[0, 1]")),
        (("train", "--env.rewards.temporal", "nan"), ("temporal",)),
        (("train", "--env.commands.gaits", "trot", "waltz"), ("Unknown gait 'waltz'",)),
        (("train", "--env.commands.velocity-x", "2", "-2"), ("velocity_x", "smaller first")),
        (("train", "--env.randomization.friction", "0", "1"), ("friction",)),
        (("train", "--env.episode-s", "0"), ("episode_s",)),
        (("train", "--timing", "nowhere.json"), ("nowhere.json", "No such file")),
        (("train", "--resume", "nowhere"), ("nowhere", "not a directory")),
        (("train", "--out", "/proc/nowhere"), ("/proc/nowhere",)),
        (("train", "--num-envs", "100000000", "--preset", "smoke"), ("memory",)),
        (("export", "nowhere"), ("nowhere", "not a directory")),
        (("evaluate", "nowhere.onnx"), ("nowhere.onnx", "No such file")),
        (("evaluate", "nowhere.onnx", "--suite", "long"), ("Unknown suite 'long'", "paper, quick")),
        (("demo", "--out", "/proc/nowhere"), ("/proc/nowhere",)),
        (("train", "--start-from", "nowhere"), ("nowhere", "not a directory")),
        (("train", "--start-std", "0.2"), ("--start-std", "--start-from")),
        (("train", "--start-from", "nowhere", "--start-std", "0"), ("--start-std", "> 0")),
        (("experiment", "speed"), ("Unknown experiment 'speed'", "velocity")),
        (("experiment",), ("experiments", "empty")),
        (("experiment", "gaits", "--seeds", "0"), ("--seeds", "> 0")),
        (("experiment", "gaits", "--policy", "nowhere.onnx"), ("nowhere.onnx", "No such file")),
        (("experiment", "ablation", "--ablations", "nowhere"), ("nowhere", "no ablation", "full: none")),
        (("experiment", "learning"), ("--learning", "one or more runs")),
        (("experiment", "learning", "--learning", "nowhere"), ("nowhere", "not a directory")),
        (("record", "nowhere.onnx"), ("nowhere.onnx", "No such file")),
        (("record", "--gaits", "waltz"), ("Unknown gait 'waltz'", "walk")),
        (("record", "--gaits"), ("--gaits", "one name at least")),
        (("record", "--speeds", "1", "2", "3"), ("--speeds is 3", "1 or that of the gaits, 4")),
        (("record", "--speeds", "inf"), ("--speeds", "finite")),
        (("record", "--seconds", "0"), ("--seconds", "from 0.1")),
        (("record", "--seed", "-1"), ("--seed", ">= 0")),
        (("record", "--size", "641", "360"), ("width", "641", "even")),
        (("record", "--slow", "0"), ("--slow", "0.05")),
        (("record", "--fps", "0"), ("--fps", "from 5")),
        (("record", "--out", "film.avi"), ("'.avi'", ".gif, .mp4")),
        (("record", "--out", "film.gif", "--seconds", "600"), ("frames of a GIF", "60000", "write .mp4 instead")),
        (("train", "--no-such-flag"), ("no-such-flag",)),
    ],
)
def test_refused_in_one_sentence_and_nothing_written(tmp_path, arguments, said):
    assert_refused(symdyn(*arguments, cwd=tmp_path), *said)
    assert files(tmp_path) == set()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"a_T": float("nan")}, "a_T"),
        ({"a_T": -1.0}, "a_T"),
        ({"c_beta": "fast"}, "c_beta"),
        ({"b_T": None}, "b_T"),
    ],
)
def test_absurd_timing_file(tmp_path, change, said):
    curve = TimingCurve().as_dict() | change
    if change.get("b_T", 0) is None:
        del curve["b_T"]
    text = json.dumps({"format_version": 1, "active": "mine", "curves": {"mine": curve}})
    (tmp_path / "curves.json").write_text(text)
    assert_refused(symdyn("train", "--preset", "smoke", "--timing", "curves.json", cwd=tmp_path), "curves.json", said)
    assert files(tmp_path) == {Path("curves.json")}


def test_a_directory_that_holds_a_run_is_not_overwritten_and_not_resumed_with_other_settings(tmp_path):
    flags = ("--preset", "smoke", "--num-envs", "4", "--iterations", "1")
    assert symdyn("train", *flags, "--out", "run", cwd=tmp_path).returncode == 0
    before = {path: path.read_bytes() for path in (tmp_path / "run").rglob("*") if path.is_file()}
    assert_refused(symdyn("train", *flags, "--out", "run", cwd=tmp_path), "already holds a run", "--resume run")
    changed = symdyn("train", "--resume", "run", "--iterations", "2", "--num-envs", "8", cwd=tmp_path)
    assert_refused(changed, "num_envs")
    assert {path: path.read_bytes() for path in (tmp_path / "run").rglob("*") if path.is_file()} == before


def test_a_run_whose_checkpoints_are_gone_is_refused_and_stays_as_it_is(tmp_path):
    flags = ("--preset", "smoke", "--num-envs", "4", "--iterations", "1", "--candidates", "0")
    assert symdyn("train", *flags, "--out", "run", cwd=tmp_path).returncode == 0
    for path in (tmp_path / "run" / "checkpoints").iterdir():
        path.unlink()
    log = (tmp_path / "run" / "progress.jsonl").read_bytes()
    assert log
    assert_refused(
        symdyn("train", "--resume", "run", "--iterations", "2", cwd=tmp_path), "no checkpoint", "nothing was"
    )
    assert (tmp_path / "run" / "progress.jsonl").read_bytes() == log


def test_a_run_directory_without_a_run(tmp_path):
    (tmp_path / "empty").mkdir()
    assert_refused(symdyn("train", "--resume", "empty", cwd=tmp_path), "not a run of symdyn train")
    assert_refused(symdyn("export", "empty", cwd=tmp_path), "not a run of symdyn train")
    (tmp_path / "empty" / "config.yaml").write_text("preset: [")
    assert_refused(symdyn("train", "--resume", "empty", cwd=tmp_path), "config.yaml")


def test_a_policy_file_that_is_none(tmp_path):
    (tmp_path / "text.onnx").write_text("trot trot trot")
    assert_refused(symdyn("evaluate", "text.onnx", "--out", "out", cwd=tmp_path), "text.onnx")
    assert files(tmp_path) == {Path("text.onnx")}


def test_a_full_disk(tmp_path):
    # /dev/full stands for a disk without room: opening works, writing does not
    assert_refused(symdyn("gaits", "trot", "--figure", "/dev/full/trot.png", cwd=tmp_path), "/dev/full")


def test_a_process_of_its_own_says_it_on_standard_error_with_exit_code_2(tmp_path):
    command = [sys.executable, "-m", "symdyn", "evaluate", "nowhere.onnx"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, timeout=120, check=False)
    assert_refused(done, "symdyn: error: nowhere.onnx")
    assert done.stdout == ""
