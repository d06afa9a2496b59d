"""Many cells: every one is done once, whatever is killed in between, and one that fails stops no other."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from slip.curves.parallel import CELLS, SETTINGS, Outcome, run_cells
from slip.curves.settings import Workers
from symdyn.errors import FileProblem, InvalidValue, ResourceProblem
from tests.slip.curves import parallel_work
from tests.slip.curves.parallel_work import die, slow_cells, slow_square, square

HERE = Workers(jobs=1)
SQUARES = {"work": "squares"}


def cells(*numbers: int, **more: Any) -> dict[str, dict[str, Any]]:
    return {f"x{i}": {"x": i, **more} for i in numbers}


def results(outcomes: dict[str, Outcome]) -> dict[str, int]:
    return {name: outcome.result["square"] for name, outcome in outcomes.items() if outcome.result}


@pytest.mark.parametrize("jobs", [1, 2])
def test_every_cell_is_done_and_written(tmp_path: Path, jobs: int) -> None:
    seen: list[tuple[int, int]] = []
    found = run_cells(
        square, cells(2, 1, 4), tmp_path, SQUARES, Workers(jobs), on_progress=lambda *done: seen.append(done)
    )
    assert list(found) == ["x2", "x1", "x4"], "in the order of the cells"
    assert results(found) == {"x2": 4, "x1": 1, "x4": 16}
    assert seen == [(0, 3), (1, 3), (2, 3), (3, 3)]
    assert sorted(path.name for path in (tmp_path / CELLS).iterdir()) == ["x1.json", "x2.json", "x4.json"]
    data = json.loads((tmp_path / CELLS / "x2.json").read_text())
    assert (data["status"], data["cell"], data["result"]) == ("done", {"x": 2}, {"square": 4})


def test_a_failed_cell_is_written_with_its_reason_and_a_defect_with_its_place(tmp_path: Path) -> None:
    found = run_cells(square, cells(1, 3, 5), tmp_path, SQUARES, HERE)
    assert [outcome.status for outcome in found.values()] == ["done", "failed", "failed"]
    assert found["x3"].reason == "x is 3, but must be another number."
    assert found["x3"].trace is None
    assert found["x5"].reason == "defect: TypeError: a defect"
    assert found["x5"].trace is not None and "parallel_work.py" in found["x5"].trace
    assert json.loads((tmp_path / CELLS / "x3.json").read_text())["reason"] == found["x3"].reason


def test_what_is_done_is_not_done_again_and_failures_only_if_asked_for(tmp_path: Path) -> None:
    log = tmp_path / "log.txt"
    given = cells(1, 3, log=str(log))
    first = run_cells(square, given, tmp_path / "out", SQUARES, HERE)
    assert run_cells(square, given, tmp_path / "out", SQUARES, HERE) == first
    assert log.read_text().split() == ["1", "3"]
    run_cells(square, given, tmp_path / "out", SQUARES, HERE, retry_failed=True)
    assert log.read_text().split() == ["1", "3", "3"]


def test_cells_may_be_added(tmp_path: Path) -> None:
    run_cells(square, cells(1), tmp_path, SQUARES, HERE)
    assert results(run_cells(square, cells(0, 1, 2), tmp_path, SQUARES, HERE)) == {"x0": 0, "x1": 1, "x2": 4}


@pytest.mark.parametrize(("jobs", "sent"), [(1, signal.SIGKILL), (2, signal.SIGKILL), (2, signal.SIGINT)])
def test_killed_it_goes_on_with_what_is_left(tmp_path: Path, jobs: int, sent: signal.Signals) -> None:
    command = [sys.executable, str(Path(parallel_work.__file__)), str(tmp_path), str(jobs)]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    folder = tmp_path / CELLS
    deadline = time.monotonic() + 60
    while not folder.is_dir() or len(list(folder.glob("x*.json"))) < 3:
        assert process.poll() is None, "it ended before it could be killed"
        assert time.monotonic() < deadline
        time.sleep(0.01)
    os.kill(process.pid, sent)
    process.wait(timeout=60)
    done = {path.stem: path.read_bytes() for path in folder.glob("x*.json")}
    given = slow_cells(tmp_path)
    assert 3 <= len(done) < len(given)
    time.sleep(0.5)  # workers that outlive their parent end with their cell
    (tmp_path / "log.txt").write_text("")
    found = run_cells(slow_square, given, tmp_path, SQUARES, Workers(2))
    assert results(found) == {name: cell["x"] ** 2 for name, cell in given.items()}
    again = {f"x{number}" for number in (tmp_path / "log.txt").read_text().split()}
    assert again == set(given) - set(done), "what was done was not done again"
    for name, content in done.items():
        assert (folder / f"{name}.json").read_bytes() == content


def test_a_worker_that_dies_is_said_in_words(tmp_path: Path) -> None:
    run_cells(square, cells(1), tmp_path, SQUARES, HERE)
    with pytest.raises(ResourceProblem, match="A worker process died"):
        run_cells(die, cells(1, 2, 4), tmp_path, SQUARES, Workers(2))
    assert (tmp_path / CELLS / "x1.json").exists()


def test_a_folder_of_other_work_is_refused_and_left_alone(tmp_path: Path) -> None:
    run_cells(square, cells(1), tmp_path, SQUARES, HERE)
    for other in ({"work": "cubes"}, {"work": "squares", "more": 1}, {}):
        with pytest.raises(FileProblem, match="belongs to work with a different"):
            run_cells(square, cells(2), tmp_path, other, HERE)
    assert sorted(path.name for path in (tmp_path / CELLS).iterdir()) == ["x1.json"]
    with pytest.raises(FileProblem, match="result of another cell"):
        run_cells(square, {"x1": {"x": 7}}, tmp_path, SQUARES, HERE)


@pytest.mark.parametrize("content", ["", "{", "[]", "{}", '{"format_version": 1, "status": "done"}'])
def test_damaged_results_and_settings_are_named(tmp_path: Path, content: str) -> None:
    run_cells(square, cells(1), tmp_path, SQUARES, HERE)
    path = tmp_path / CELLS / "x1.json"
    path.write_text(content)
    with pytest.raises(FileProblem, match=r"x1\.json"):
        run_cells(square, cells(1), tmp_path, SQUARES, HERE)
    path.unlink()
    (tmp_path / SETTINGS).write_text(content)
    with pytest.raises(FileProblem, match=SETTINGS):
        run_cells(square, cells(1), tmp_path, SQUARES, HERE)


def test_a_folder_that_is_a_file(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    with pytest.raises(FileProblem):
        run_cells(square, cells(1), tmp_path / "file", SQUARES, HERE)


@pytest.mark.parametrize(("backend", "package", "install"), [("ray", "ray", "ray"), ("dask", "distributed", "dask")])
def test_a_missing_backend_names_the_package_to_install(
    tmp_path: Path, backend: Any, package: str, install: str
) -> None:
    if find_spec(package) is not None:
        pytest.skip(f"{package} is installed")
    with pytest.raises(ResourceProblem, match=f"--backend {backend} needs .*pip install '?{install}"):
        run_cells(square, cells(1), tmp_path / "out", SQUARES, Workers(2, backend))
    assert not (tmp_path / "out").exists()


def test_bad_workers() -> None:
    with pytest.raises(InvalidValue, match="jobs is -1"):
        Workers(-1)
    with pytest.raises(InvalidValue, match="one of loky, ray, dask"):
        Workers(1, "slurm")  # pyright: ignore[reportArgumentType]
