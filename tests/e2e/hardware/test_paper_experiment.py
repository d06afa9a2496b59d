"""The paper's experiment by the clock: ``symdyn robot-sim`` and ``symdyn deploy``, then ``analyze`` and ``replay``."""

from __future__ import annotations

import json
import signal
from pathlib import Path

import pytest

from benchmarks.robot_processes import process
from rl.pretrained import policy_path
from symdyn.gait.library import PAPER_GAITS
from tests.e2e.command_in_process import symdyn
from tests.e2e.hardware.waiting import FORGIVING
from tests.hardware.lcm_urls import multicast_url


def test_the_papers_experiment_its_log_and_its_replay(tmp_path: Path) -> None:
    url, log, out = multicast_url(), tmp_path / "run.lcmlog", tmp_path / "sim.json"
    with (
        process("robot-sim", "--url", url, "--scenario", "paper", "--out", out) as robot,
        process("deploy", policy_path(), "--url", url, "--log", log, *FORGIVING) as deployer,
    ):
        robot.ends(within=150.0)
        summary = json.loads(out.read_text())
        assert summary["person"]["script_done"], deployer.words()
        deployer.process.send_signal(signal.SIGINT)
        code, words = deployer.ends(within=20.0)
        assert code == 0, words
    assert summary["robot"]["fell_at_s"] is None
    assert summary["targets"]["torque_excesses"] == summary["targets"]["not_finite"] == 0
    analysed = symdyn("analyze", log, "--out", tmp_path / "report", cwd=tmp_path)
    assert analysed.returncode == 0, analysed.stderr
    assert (tmp_path / "report" / "report.md").is_file()
    metrics = json.loads((tmp_path / "report" / "metrics.json").read_text())
    # a stall of the machine cuts a segment in two, and of a short one there are no metrics
    told = [segment for segment in metrics["segments"] if segment["truth"] is not None]
    segments = [segment for segment in told if segment["command"][0] == pytest.approx(0.8)]
    assert {segment["gait"].removesuffix("_mirrored") for segment in segments} == set(PAPER_GAITS)
    for segment in segments:
        # 0.03 to 0.06 on a quiet machine; the policy's own evaluation at this speed has 0.04
        assert segment["truth"]["gc_stance"] < 0.1, segment
        assert segment["truth"]["gait_identity"] > 0.9, segment
        assert abs(segment["truth"]["speed"] - 0.8) < 0.12, segment
        assert segment["estimator"]["v_x_rms"] < 0.1, segment
    replayed = symdyn("replay", log, policy_path(), cwd=tmp_path)
    assert replayed.returncode == 0, replayed.stdout
