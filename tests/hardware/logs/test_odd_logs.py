"""Logs that are not what a command wants: two in one file, and one in which the policy never ran."""

from __future__ import annotations

from pathlib import Path

import pytest

from hardware.control.controller import State
from hardware.estimation.calibration import read_raw
from hardware.wire.channels import IMU, TICK
from hardware.wire.event_log import LogReader
from symdyn.errors import FileProblem
from tests.e2e.command_in_process import symdyn
from tests.hardware.logs.log_sessions import lockstep_session


@pytest.fixture(scope="module")
def ran(tmp_path_factory) -> Path:
    """Up from the floor and a second of trot."""
    return lockstep_session(tmp_path_factory.mktemp("logs") / "ran.lcmlog", 9.0)


@pytest.fixture(scope="module")
def never_ran(tmp_path_factory) -> Path:
    return lockstep_session(tmp_path_factory.mktemp("logs") / "stood.lcmlog", 2.0, scenario="stand")


@pytest.mark.parametrize("command", ["analyze", "replay", "calibrate-feet"])
def test_two_logs_in_one_file_are_refused_with_the_place_where_to_part_them(never_ran, tmp_path, command):
    both = tmp_path / "both.lcmlog"
    both.write_bytes(never_ran.read_bytes() * 2)
    done = symdyn(command, both, cwd=tmp_path)
    assert done.returncode == 2
    assert f"holds two logs, the second from byte {never_ran.stat().st_size} on" in done.stderr
    assert "tail -c" in done.stderr


def test_a_log_in_which_the_policy_never_ran_has_an_answer_or_a_reason(never_ran, tmp_path):
    analysed = symdyn("analyze", never_ran, "--out", tmp_path / "out", cwd=tmp_path)
    assert analysed.returncode == 0, analysed.stderr
    assert "The policy never ran" in analysed.stdout
    assert "The policy never ran" in (tmp_path / "out" / "report.md").read_text()
    replayed = symdyn("replay", never_ran, cwd=tmp_path)
    assert replayed.returncode == 0, replayed.stderr
    calibrated = symdyn("calibrate-feet", never_ran, cwd=tmp_path)
    assert calibrated.returncode == 2
    assert "the policy never ran" in calibrated.stderr
    assert not (tmp_path / "feet.json").exists()


def test_only_messages_from_the_time_in_which_the_policy_ran_are_calibrated_with(ran):
    within, running = 0, False
    for event in LogReader(ran):
        if event.channel == TICK:
            running = event.message().state == State.RUN
        within += event.channel == IMU and running
    assert 0 < within < len(read_raw(ran))
    assert len(read_raw(ran, state=State.RUN)) == within


def test_a_log_without_a_deployer_counts_as_a_whole(tmp_path, ran):
    with pytest.raises(FileProblem):
        read_raw(ran, state="no such state")
