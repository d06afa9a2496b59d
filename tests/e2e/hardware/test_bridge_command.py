"""``symdyn bridge`` between ``symdyn robot-sim --dds`` and ``symdyn deploy``: real processes over DDS on loopback."""

from __future__ import annotations

import json
import signal
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from benchmarks.bridge_faults import OF_PROCESSES
from benchmarks.bridged import Bridged, await_mode, await_robot, bridged
from benchmarks.dds_ear import DdsEar, free_domain
from benchmarks.robot_processes import process
from hardware.dds.messages import LOW_CMD_CODEC, damping
from hardware.dds.node import LOW_CMD, Writer
from hardware.dds.types import LowCmd
from tests.e2e.hardware.waiting import wait_for
from tests.hardware.lcm_urls import multicast_url

DAMPED_S = 0.4  # s; the figures are in docs/robot.md, this only tells "soon" from "not at all" on a busy machine


def damps_soon_after(its: Bridged, what: Callable[[], None]) -> float:
    """When the first damping after something that is done was written; not long after."""
    before = time.monotonic()
    what()
    done = time.monotonic()  # on a busy machine, much later than it happened
    wait_for(lambda: its.ear.first_damping(before) is not None, "damping")
    damped = its.ear.first_damping(before)
    assert damped is not None and damped - done < DAMPED_S
    return damped


def test_the_policy_runs_through_the_bridge_and_ctrl_c_damps_and_ends(tmp_path: Path) -> None:
    # a machine that stops for some 50 ms makes the deployer damp, rightly: then it is tried again
    if not any(_runs(tmp_path) for _ in range(2)):
        assert _runs(tmp_path), "the robot was damped three times before it ran"


def _runs(tmp_path: Path) -> bool:
    """Whether the machine kept the robot running; what follows from a run is asserted."""
    out = tmp_path / "robot.json"
    with bridged(free_domain(), multicast_url(), ("--out", out)) as its:
        try:
            await_mode(its, "running")
        except RuntimeError:  # damped on the way there
            return False
        time.sleep(3.0)
        if its.ear.mode != "running" and "no_joint_state" in its.words():
            return False
        assert its.ear.mode == "running", its.words()
        assert all(heard.sound for heard in its.ear.commands)
        assert len({heard.writer for heard in its.ear.commands}) == 1
        damped = damps_soon_after(its, lambda: its.bridge.process.send_signal(signal.SIGINT))
        time.sleep(0.5)
        assert not its.ear.stiff_after_damping(damped)
        assert its.bridge.process.poll() is None
        its.bridge.process.send_signal(signal.SIGINT)
        code, words = its.bridge.ends(within=20.0)
        assert code == 0, words
        its.robot.process.send_signal(signal.SIGINT)
        its.robot.ends(within=20.0)
    summary = json.loads(out.read_text())
    assert summary["targets"]["not_finite"] == summary["targets"]["refused"] == 0
    assert "running" in [one["mode"] for one in summary["targets"]["modes"]]
    return True


@pytest.mark.parametrize(
    ("fault", "by"),
    [
        ("deployer and watchdog killed", "bridge"),
        ("bridge killed", "guard"),
        ("bridge stopped", "guard"),
        ("guard killed", "bridge"),
        ("second writer of LowCmd", "bridge"),
    ],
)
def test_whoever_dies_the_other_damps(fault: str, by: str) -> None:
    with bridged(free_domain(), multicast_url()) as its:
        await_mode(its, "standing")
        damped = damps_soon_after(its, lambda: OF_PROCESSES[fault](its))
        assert its.who(damped) == by
        time.sleep(0.5)
        assert not its.ear.stiff_after_damping(damped)
        if fault == "bridge stopped":  # come back, it must not go on where it was
            its.bridge.process.send_signal(signal.SIGCONT)
            time.sleep(0.5)
            assert not its.ear.stiff_after_damping(damped)


def test_it_refuses_to_start_where_another_program_commands(tmp_path: Path) -> None:
    domain, url = free_domain(), multicast_url()
    on = ("--interface", "lo", "--domain", domain)
    with process("robot-sim", "--dds", *on, "--url", url, "--scenario", "idle"):
        ear = DdsEar(domain)
        await_robot(ear.node)
        writer, data, stop = Writer(ear.node, LOW_CMD, LowCmd), LOW_CMD_CODEC.encode(damping(1.0)), threading.Event()

        def command() -> None:
            while not stop.wait(0.01):
                writer.write(data)

        thread = threading.Thread(target=command)
        thread.start()
        try:
            with process("bridge", *on, "--url", multicast_url()) as bridge:
                code, words = bridge.ends(within=60.0)
        finally:
            stop.set()
            thread.join()
            ear.close()
    assert code == 2
    assert "Another program commands the motors" in words
    assert not ear.commands, "it said something to the motors"


def test_where_no_robot_answers_it_says_what_to_look_for() -> None:
    with process("bridge", "--interface", "lo", "--domain", free_domain(), "--url", multicast_url()) as bridge:
        code, words = bridge.ends(within=60.0)
    assert code == 2
    assert "No robot answers" in words
    assert "ping 192.168.123.161" in words or "--domain 1" in words
