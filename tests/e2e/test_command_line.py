"""Whole commands on real files; what is interrupted or killed is a process of its own."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import torch

from rl.learning import checkpoint, run_log
from tests.e2e.command_in_process import symdyn

TINY = ("--preset", "smoke", "--num-envs", "8", "--ppo.hidden", "32", "16")


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> Path:
    """A finished tiny run with its policy file."""
    directory = tmp_path_factory.mktemp("e2e") / "run"
    trained = symdyn("train", *TINY, "--iterations", "3", "--out", directory)
    assert trained.returncode == 0, trained.stderr
    assert "symdyn export" in trained.stdout
    exported = symdyn("export", directory)
    assert exported.returncode == 0, exported.stderr
    return directory


def test_a_run_leaves_settings_log_checkpoints_and_curves(run):
    assert (run / "config.yaml").is_file()
    assert [record["iteration"] for record in run_log.read(run)] == [1, 2, 3]
    assert checkpoint.list_checkpoints(run)
    assert list(run.glob("events.out.tfevents.*"))


def test_the_policy_file_acts_like_the_torch_actor_of_the_run(run):
    from rl.learning import config_file
    from rl.learning.trainer import Trainer
    from symdyn.policy.file import Policy

    trainer = Trainer(config_file.load(run / "config.yaml"), run)
    trainer.resume()
    obs = trainer.env.get_observations()
    with torch.inference_mode():
        wanted = trainer.ppo.get_policy()(obs).numpy()
    found = Policy.load(run / "policy.onnx").act(obs["policy"].numpy())
    assert np.abs(found - wanted).max() < 1e-5


def test_evaluate_writes_metrics_report_and_figures(run, tmp_path):
    done = symdyn("evaluate", run / "policy.onnx", "--suite", "quick", "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    metrics = json.loads((tmp_path / "out" / "metrics.json").read_text())
    assert metrics["suite"] == "quick"
    report = (tmp_path / "out" / "report.md").read_text()
    assert report.index("## Verdict") < report.index("## Each gait")
    assert "**Failed: the robot " in report  # three updates make no policy
    assert set(metrics) >= {"suite", "policy", "seeds", "protocol", "gaits", "transitions", "keys"}
    wanted = {"gc_stance", "gc_morph", "gc", "rmsne", "cot", "speed_error", "settling_time", "phase_error"}
    for by_speed in metrics["gaits"].values():
        for values in by_speed.values():
            assert set(values) >= wanted | {"duty_error", "gait_identity", "fell"}
            assert set(values) <= set(metrics["keys"])
    report = (tmp_path / "out" / "report.md").read_text()
    for figure in (tmp_path / "out").glob("*.png"):
        assert f"({figure.name})" in report
        assert figure.read_bytes().startswith(b"\x89PNG")


def test_interrupted_by_ctrl_c_and_resumed_it_ends_with_the_same_weights(tmp_path):
    flags = (*TINY, "--checkpoint-every", "1", "--seed", "3")
    whole = symdyn("train", *flags, "--iterations", "12", "--out", tmp_path / "whole")
    assert whole.returncode == 0, whole.stderr
    command = [sys.executable, "-m", "symdyn", "train", *flags, "--iterations", "12", "--out", str(tmp_path / "cut")]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    _wait_for(lambda: len(run_log.read(tmp_path / "cut")) >= 2, process)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=120)
    assert process.returncode == 130, err
    assert f"symdyn train --resume {tmp_path / 'cut'}" in out.replace("\n", "")
    stopped_at = checkpoint.load_newest(tmp_path / "cut")["iteration"]
    assert 2 <= stopped_at < 12, "stopped before the end, or this shows nothing"
    resumed = symdyn("train", "--resume", tmp_path / "cut", "--iterations", "12")
    assert resumed.returncode == 0, resumed.stderr
    _same_weights(tmp_path / "whole", tmp_path / "cut")


def test_killed_at_once_and_resumed_it_ends_with_the_same_weights(tmp_path):
    flags = (*TINY, "--checkpoint-every", "2", "--seed", "4")
    assert symdyn("train", *flags, "--iterations", "8", "--out", tmp_path / "whole").returncode == 0
    command = [sys.executable, "-m", "symdyn", "train", *flags, "--iterations", "8", "--out", str(tmp_path / "cut")]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _wait_for(lambda: bool(checkpoint.list_checkpoints(tmp_path / "cut")), process)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    resumed = symdyn("train", "--resume", tmp_path / "cut")
    assert resumed.returncode == 0, resumed.stderr
    _same_weights(tmp_path / "whole", tmp_path / "cut")


def test_gaits_as_json_is_the_derived_table():
    found = {gait["name"]: gait for gait in json.loads(symdyn("gaits", "--json").stdout)}
    assert set(found["trot"]) == {"name", "offsets", "K", "H", "time_reversal_partner", "symmetric_pairs"}
    assert found["trot"]["offsets"] == {"LH": 0.0, "LF": 0.5, "RF": 0.0, "RH": 0.5}
    assert found["trot"]["K"] == ["e", "g_r"]
    assert ["g_s", 0.5] in found["trot"]["H"]
    assert found["half_bound_left"]["time_reversal_partner"] == "half_bound_right"
    assert found["bound"]["symmetric_pairs"] == [["LH", "RH"], ["LF", "RF"]]


def test_gaits_shows_the_library_one_gait_and_the_observation(tmp_path):
    assert "transverse_gallop" in symdyn("gaits").stdout
    shown = symdyn("gaits", "pace", "--figure", tmp_path / "pace.png")
    assert shown.returncode == 0, shown.stderr
    assert "█" in shown.stdout
    assert (tmp_path / "pace.png").read_bytes().startswith(b"\x89PNG")
    assert "projected_gravity_b" in symdyn("gaits", "--observation").stdout


def test_help_names_every_command_and_imports_nothing_heavy():
    shown = symdyn("--help")
    assert shown.returncode == 0
    for name in ("gaits", "train", "export", "evaluate", "experiment", "record", "demo"):
        assert f"  {name}" in shown.stdout  # each one's own --help: tests/test_docs.py
    loaded = "print(sorted(set(sys.modules) & {'numpy', 'torch'}))"
    code = f"import sys; from symdyn_cli.main import main; main(['--help']); {loaded}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.endswith("[]\n")


def _same_weights(a: Path, b: Path) -> None:
    first, second = (checkpoint.load_newest(run) for run in (a, b))
    assert first["iteration"] == second["iteration"]
    for network in ("actor_state_dict", "critic_state_dict"):
        for name, value in first["ppo"][network].items():
            assert torch.equal(value, second["ppo"][network][name]), name


def _wait_for(happened, process: subprocess.Popen) -> None:
    deadline = time.monotonic() + 120
    while not happened():
        assert process.poll() is None, "the command ended before it could be interrupted"
        assert time.monotonic() < deadline
        time.sleep(0.01)
