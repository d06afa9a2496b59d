"""``symdyn robot-sim`` as a process of its own, over real multicast."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from hardware.wire.channels import IMU, JOINTS, JOYSTICK, TARGETS, TRUTH
from hardware.wire.link import Link
from hardware.wire.readings import Joints, Targets
from tests.hardware.lcm_urls import multicast_url
from tests.robots import GO2

ONES = np.ones(12)
PATIENCE = 60.0  # s; for a busy machine


@contextmanager
def robot_sim(url: str, *arguments: object, cwd: Path) -> Iterator[subprocess.Popen[str]]:
    """The process, killed if it is still there at the end."""
    command = [sys.executable, "-m", "symdyn", "robot-sim", "--url", url, *map(str, arguments)]
    process = subprocess.Popen(command, cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


@contextmanager
def listening(url: str) -> Iterator[tuple[Link, list[tuple[str, float]]]]:
    arrivals: list[tuple[str, float]] = []
    link = Link(url, (JOINTS, IMU, JOYSTICK, TRUTH), lambda channel, _, when, __: arrivals.append((channel, when)))
    link.start()
    try:
        yield link, arrivals
    finally:
        link.close()


def wait_for(condition) -> None:
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.01)


def summary_of(process: subprocess.Popen[str], path: Path) -> dict:
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, err
    assert "processor" in out
    return json.loads(path.read_text())


def hold(link: Link, kp: float, kd: float, seconds: float, rate: float = 50.0) -> int:
    """Targets for the default pose at a fixed rate; how many."""
    count = round(seconds * rate)
    begin = time.monotonic()
    for k in range(count):
        time.sleep(max(0.0, begin + k / rate - time.monotonic()))
        link.send(TARGETS, Targets(GO2.default_joint_pos, kp * ONES, kd * ONES).message(k, 1))
    return count


def test_a_robot_that_is_told_something_obeys_and_the_summary_tells_it(tmp_path):
    url = multicast_url()
    with (
        listening(url) as (link, arrivals),
        robot_sim(url, "--start", "standing", "--out", "s.json", cwd=tmp_path) as sim,
    ):
        # zeros until it has data from the robot
        wait_for(lambda: link.latest(IMU) is not None)
        assert not any(link.latest(IMU).message.quat)  # type: ignore[union-attr]
        wait_for(lambda: any(link.latest(IMU).message.quat))  # type: ignore[union-attr]
        standing = hold(link, kp=60.0, kd=3.0, seconds=1.5)
        assert link.latest(TRUTH).message.p[2] > 0.3  # type: ignore[union-attr]
        assert Joints.of(link.latest(JOINTS).message).pos == pytest.approx(GO2.default_joint_pos, abs=0.2)  # type: ignore[union-attr]
        begun = time.monotonic()
        damping = hold(link, kp=0.0, kd=4.0, seconds=2.0)
        wait_for(lambda: link.latest(TRUTH).message.p[2] < 0.12)  # type: ignore[union-attr]
        heard = link.latest(TRUTH).number  # type: ignore[union-attr]
        wait_for(lambda: link.latest(TRUTH).number > heard + 10)  # type: ignore[union-attr]
        sim.send_signal(signal.SIGINT)
        told = summary_of(sim, tmp_path / "s.json")
        assert told["targets"]["received"] == standing + damping
        assert [entry["mode"] for entry in told["targets"]["modes"]] == ["standing", "damping"]
        assert told["targets"]["modes"][1]["monotonic"] == pytest.approx(begun, abs=0.5)
        assert told["targets"]["range_excess_rad"] == 0.0
        assert told["robot"]["max_tilt_rad"] < 0.3
        assert (told["fault"]["began_monotonic"], told["robot"]["fell_at_s"]) == (None, None)
        assert told["pace"]["periods"] * 0.002 == pytest.approx(told["simulated_s"])
        counts = {channel: sum(name == channel for name, _ in arrivals) for channel in (JOINTS, IMU, JOYSTICK, TRUTH)}
        published = told["pace"]["periods"] - told["pace"]["left_out"]
        assert counts[JOINTS] == counts[IMU] == counts[JOYSTICK] == published
        assert counts[TRUTH] <= told["pace"]["periods"] / 5
        # time goes on as it does outside, however busy the machine
        wall = arrivals[-1][1] - arrivals[0][1]
        assert told["simulated_s"] == pytest.approx(wall + told["pace"]["stalled_s"], rel=0.1)


def test_a_fault_begins_when_the_robot_is_told_to_run_and_the_reaction_is_measured(tmp_path):
    url = multicast_url()
    flags = (
        "--start",
        "standing",
        "--scenario",
        "idle",
        "--fault",
        "silent_imu",
        "--fault-since",
        "run",
        "--fault-at",
        0.4,
    )
    with listening(url) as (link, _), robot_sim(url, *flags, "--out", "s.json", cwd=tmp_path) as sim:
        wait_for(lambda: link.latest(IMU) is not None and any(link.latest(IMU).message.quat))  # type: ignore[union-attr]
        hold(link, GO2.kp, GO2.kd, seconds=0.2)
        wait_for(lambda: time.monotonic() - link.latest(IMU).arrival > 0.5)  # type: ignore[union-attr]
        assert time.monotonic() - link.latest(JOINTS).arrival < 0.5  # type: ignore[union-attr]
        begun = time.monotonic()
        hold(link, 0.0, 4.0, seconds=0.1)
        sim.send_signal(signal.SIGTERM)
        fault = summary_of(sim, tmp_path / "s.json")["fault"]
        assert fault["first_damping_monotonic"] == pytest.approx(begun, abs=0.5)
        assert fault["reaction_s"] == pytest.approx(fault["first_damping_monotonic"] - fault["began_monotonic"])
        assert fault["reaction_s"] > 0.4


def test_a_second_robot_on_a_busy_url_is_refused(tmp_path):
    url = multicast_url()
    with listening(url) as (link, _), robot_sim(url, cwd=tmp_path):
        wait_for(lambda: link.latest(IMU) is not None)
        with robot_sim(url, cwd=tmp_path) as second:
            _, err = second.communicate(timeout=PATIENCE)
            assert second.returncode == 2
            assert "Another robot already publishes" in err
            assert url in err
