"""Two processes never write one run directory."""

from __future__ import annotations

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from rl.learning import run_dir, run_lock
from symdyn.errors import FileProblem

HOLD = (
    "import sys; from pathlib import Path; from rl.learning import run_lock\nwith run_lock.held(Path(sys.argv[1])):\n"
)


def holding(run: Path, then: str = "    print('held', flush=True); input()") -> subprocess.Popen[str]:
    """Another process that has the lock until it is told to end."""
    command = [sys.executable, "-c", HOLD + then, str(run)]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "held\n"
    return process


def test_a_directory_that_another_process_writes_is_refused_with_its_number(tmp_path: Path) -> None:
    other = holding(tmp_path / "run")
    with pytest.raises(FileProblem, match=rf"run: is being written by process {other.pid} on .*, since 20"):
        run_lock.held(tmp_path / "run").__enter__()
    other.communicate("\n")
    with run_lock.held(tmp_path / "run"):
        pass


def test_the_lock_of_a_killed_process_is_free(tmp_path: Path) -> None:
    other = holding(tmp_path)
    other.kill()
    other.wait()
    with run_lock.held(tmp_path):
        assert "process" in (tmp_path / run_lock.FILE).read_text()


def test_a_directory_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with (
        pytest.raises(FileProblem, match="is not a writable directory"),
        run_lock.held(tmp_path / "file" / "run"),
    ):
        pass


def test_runs_that_begin_in_the_same_second_get_directories_of_their_own(tmp_path: Path) -> None:
    with ThreadPoolExecutor(8) as pool:
        runs = list(pool.map(lambda _: run_dir.reserve("smoke", tmp_path), range(24)))
    assert len(set(runs)) == 24
    assert all(run.is_dir() for run in runs)
