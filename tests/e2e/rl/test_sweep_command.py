"""``symdyn evaluate --sweep-timing`` as a user runs it: a process, a table, a kill, bad input."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from symdyn.analysis import trials
from tests.e2e.command_in_process import symdyn
from tests.symdyn.policy.policy_files import swaying

SMALL = (
    *("--sweep.period-factors", "0.9", "1.1", "--sweep.duty-factors", "0.9", "1.0", "1.1"),
    *("--sweep.speeds", "-0.5", "0.5", "--sweep.gaits", "trot", "--sweep.seconds", "3"),
)


@pytest.fixture(scope="module")
def policy_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return swaying(tmp_path_factory.mktemp("policy") / "swaying.onnx")


def arguments(policy: Path, out: Path, *more: str) -> list[str]:
    return ["evaluate", str(policy), "--sweep-timing", *SMALL, "--out", str(out), *more]


def test_killed_at_once_and_run_again_it_ends_with_the_table_of_a_run_through(
    policy_file: Path, tmp_path: Path
) -> None:
    whole = symdyn(*arguments(policy_file, tmp_path / "whole"))
    assert whole.returncode == 0, whole.stderr
    assert "symdyn fit-curves --trials" in whole.stdout
    table = tmp_path / "cut" / "timing_sweep.csv"
    command = [sys.executable, "-m", "symdyn", *arguments(policy_file, tmp_path / "cut")]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    deadline = time.monotonic() + 120
    while not table.exists():
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.002)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    assert 0 < len(trials.read(table)) <= 12  # of whole cells, each of two trials
    again = symdyn(*arguments(policy_file, tmp_path / "cut"))
    assert again.returncode == 0
    assert table.read_text() == (tmp_path / "whole" / "timing_sweep.csv").read_text()


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (("--sweep.speeds", "0"), "other than 0"),
        (("--sweep.period-factors", "nan"), "period_factors"),
        (("--sweep.duty-factors", "1", "5"), "a_beta"),
        (("--sweep.gaits", "trott"), "Did you mean 'trot'"),
        (("--sweep.seconds", "0.5"), "seconds"),
        (("--sweep.seeds", "-1"), "seeds"),
        (("--out", "/proc/nowhere"), "/proc/nowhere"),
    ],
)
def test_bad_input_is_one_sentence_and_writes_nothing(
    policy_file: Path, tmp_path: Path, more: tuple[str, ...], said: str
) -> None:
    done = symdyn(*arguments(policy_file, tmp_path / "out", *more), cwd=tmp_path)
    assert done.returncode == 2
    assert said in " ".join(done.stderr.split())
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []
