"""``symdyn robot-sim`` in this process: its help, its end, and what it says to bad input."""

from __future__ import annotations

import pytest

from hardware.robot_sim.faults import FAULTS
from hardware.robot_sim.scenarios import SCENARIOS
from tests.e2e.command_in_process import symdyn
from tests.hardware.lcm_urls import multicast_url


def test_it_ends_by_itself_after_its_duration_and_writes_nothing_unless_asked(tmp_path):
    flags = ("--scenario", "idle", "--duration", "0.3", "--no-realtime")  # in this process
    done = symdyn("robot-sim", "--url", multicast_url(), *flags, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "did not fall" in done.stdout
    assert not list(tmp_path.iterdir())


def test_help_names_every_scenario_and_fault(tmp_path):
    done = symdyn("robot-sim", "--help", cwd=tmp_path)
    assert done.returncode == 0
    said = " ".join(done.stdout.split())  # the lines are wrapped to the terminal
    for name, entry in {**SCENARIOS, **FAULTS}.items():
        assert f" {name}: {entry.help}" in said


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--url", "udpm://127.0.0.1:7667"), "The LCM URL"),
        (("--scenario", "dance"), "Unknown scenario 'dance'"),
        (("--fault", "gremlins"), "Unknown fault 'gremlins'"),
        (("--fault", "silent", "--fault-at", "-1"), "--fault-at"),
        (("--fault", "silent", "--fault-for", "0"), "--fault-for"),
        (("--fault", "silent", "--fault-size", "nan"), "--fault-size"),
        (("--duration", "0"), "--duration"),
        (("--duration", "nan"), "--duration"),
        (("--wakes-at", "-1"), "--wakes-at"),
        (("--seed", "-1"), "--seed"),
        (("--duration", "0.1", "--out", "/dev/full/s.json"), "/dev/full"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(tmp_path, arguments, said):
    url = () if "--url" in arguments else ("--url", multicast_url())
    done = symdyn("robot-sim", *url, *arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr
    assert done.stderr.startswith("symdyn: error:") and done.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())
