"""``symdyn deploy`` against ``symdyn robot-sim``: real processes, real multicast, real signals."""

from __future__ import annotations

import json
import os
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from benchmarks.robot_processes import DISPLAY, QUICK_STAND, WATCHDOG, Command, Ear, hearing, on_processors, process
from rl.pretrained import policy_path
from symdyn.gait.library import PAPER_GAITS
from tests.e2e.command_in_process import symdyn
from tests.e2e.hardware.waiting import wait_for
from tests.hardware.lcm_urls import multicast_url

FORGIVING = ("--safety.overruns", "20")  # where a busy machine is not what is tested
REACTION_S = 0.2  # s; the figures are in docs/robot.md, this only tells "at once" from "not at once" on a busy machine
WATCHDOG_S = 0.3
BROKEN = "benchmarks.broken_deployer"


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


@contextmanager
def running(mode: str) -> Iterator[tuple[Command, Ear]]:
    """A deployer whose robot stands up or runs."""
    url = multicast_url()
    with (
        process("robot-sim", "--url", url, "--scenario", "run") as robot,
        process("deploy", policy_path(), "--url", url, *QUICK_STAND, *FORGIVING) as deployer,
        hearing(url) as ear,
    ):
        wait_for(lambda: ear.mode == mode, mode)
        time.sleep(0.5)
        assert ear.mode == mode, deployer.words()
        assert robot.process.poll() is None
        yield deployer, ear


@pytest.mark.parametrize("mode", ["standing", "running"])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_damps_and_a_second_one_ends(number: signal.Signals, mode: str) -> None:
    with running(mode) as (deployer, ear):
        when = time.monotonic()
        deployer.process.send_signal(number)
        wait_for(lambda: ear.mode == "damping", "damping")
        assert ear.first_damping(when) - when < REACTION_S
        time.sleep(1.0)
        assert deployer.process.poll() is None
        assert ear.mode == "damping"
        assert ear.longest_gap(when) < WATCHDOG_S
        deployer.process.send_signal(number)
        code, words = deployer.ends(within=10.0)
        assert code == 0, words
        assert "stop_requested" in words


@pytest.mark.parametrize("mode", ["standing", "running"])
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_the_watchdog_damps_when_the_deployer_is_killed_or_hangs(number: signal.Signals, mode: str) -> None:
    with running(mode) as (deployer, ear):
        guard = deployer.child(WATCHDOG)
        when = time.monotonic()
        deployer.process.send_signal(number)
        wait_for(lambda: ear.mode == "damping", "damping")
        assert ear.first_damping(when) - when < WATCHDOG_S
        time.sleep(1.0)
        assert ear.longest_gap(when) < WATCHDOG_S
        assert time.monotonic() - ear.targets[-1][0] < WATCHDOG_S
        if number is signal.SIGSTOP:
            deployer.process.send_signal(signal.SIGCONT)
            time.sleep(0.3)
            after = time.monotonic()
            time.sleep(0.3)
            # it comes back to find that it was taken over from, and damps as well
            assert not any(targets.kp.any() for moment, targets in ear.targets if moment > after)
        os.kill(guard, signal.SIGTERM)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_what_becomes_of_the_display_does_not_matter_to_the_robot(number: signal.Signals) -> None:
    url = multicast_url()
    with (
        process("robot-sim", "--url", url, "--scenario", "run"),
        process("deploy", policy_path(), "--url", url, *QUICK_STAND, *FORGIVING, terminal=True) as deployer,
        hearing(url) as ear,
    ):
        wait_for(lambda: ear.mode == "running", "running")
        wait_for(lambda: "stand -> run" in deployer.words(), "the log")
        wait_for(lambda: "m/s forward" in deployer.words(), "the table")
        display = deployer.child(DISPLAY)
        when = time.monotonic()
        os.kill(display, number)  # a stopped one fills its pipe, like a terminal that nobody reads
        time.sleep(2.0)
        assert ear.mode == "running"
        assert ear.longest_gap(when) < WATCHDOG_S
        deployer.process.send_signal(signal.SIGTERM)
        wait_for(lambda: ear.mode == "damping", "damping")
        deployer.process.send_signal(signal.SIGTERM)
        code, words = deployer.ends(within=15.0)
        assert code == 0, words
        assert "Damped for: stop_requested" in words


def test_the_watchdog_damps_when_the_deployer_takes_their_only_processor_for_itself() -> None:
    url = multicast_url()
    one, *rest = sorted(os.sched_getaffinity(0))
    with (
        on_processors(set(rest) or {one}),
        process("robot-sim", "--url", url, "--scenario", "run"),
        on_processors({one}),
        process("tick_never_ends", policy_path(), "--url", url, *QUICK_STAND, *FORGIVING, module=BROKEN) as deployer,
        on_processors(set(rest) or {one}),
        hearing(url) as ear,
    ):
        wait_for(lambda: ear.mode == "running", "running")
        time.sleep(0.5)
        guard, when = deployer.child(WATCHDOG), time.monotonic()
        deployer.process.send_signal(signal.SIGUSR1)
        time.sleep(1.0)
        assert ear.mode == "damping", deployer.words()
        assert ear.first_damping(when) - when < WATCHDOG_S
        assert ear.longest_gap(when) < WATCHDOG_S
        os.kill(guard, signal.SIGTERM)


def test_a_robot_that_falls_silent_is_damped_in_time(tmp_path: Path) -> None:
    url, out = multicast_url(), tmp_path / "sim.json"
    fault = ("--fault", "silent", "--fault-at", 1.0, "--fault-since", "run")
    with (
        process("robot-sim", "--url", url, *fault, "--out", out) as robot,
        process("deploy", policy_path(), "--url", url, *QUICK_STAND, *FORGIVING) as deployer,
        hearing(url) as ear,
    ):
        wait_for(lambda: ear.mode == "running", "running")
        wait_for(lambda: ear.mode == "damping", "damping")
        time.sleep(0.2)
        robot.process.send_signal(signal.SIGINT)
        robot.ends(within=20.0)
        assert 0.0 < json.loads(out.read_text())["fault"]["reaction_s"] < REACTION_S
        assert deployer.process.poll() is None
        assert ear.mode == "damping"
