"""Many cells of work on many processors, resumable: one small file a finished cell.

A cell is a dictionary of numbers and words; the work on it is a function at the top of a module that takes it and
returns another dictionary. Each result is written, whole, as soon as it arrives: what is killed at any moment loses
only the cells under way and goes on with the others. A cell that fails is written down with its reason and does not
stop the rest.

On one machine the workers are processes (joblib's loky). On a cluster they are those of Ray or of Dask, of which this
process must be a client: of the cluster that their own settings name (RAY_ADDRESS, DASK_SCHEDULER_ADDRESS), or else of
one that they start here. Only this process writes files; workers need no common disk.
"""

from __future__ import annotations

import contextlib
import time
import traceback
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

import joblib
from joblib.externals.loky.process_executor import TerminatedWorkerError

from slip.curves.settings import Workers
from symdyn.errors import FileProblem, ResourceProblem, SymdynError
from symdyn.io.files import read_json, writable_directory, write_json

FORMAT_VERSION = 1

SETTINGS = "settings.json"
CELLS = "cells"

Cell = Mapping[str, Any]
Work = Callable[[dict[str, Any]], dict[str, Any]]


@dataclass(frozen=True)
class Outcome:
    """What became of a cell.

    Attributes:
        cell: what was to be done.
        status: ``done`` or ``failed``.
        seconds: that it took.
        result: of the work, if done.
        reason: why not, in a sentence, if failed.
        trace: where, if the failure is a defect of the program and no property of the cell.
    """

    cell: dict[str, Any]
    status: Literal["done", "failed"]
    seconds: float
    result: dict[str, Any] | None = None
    reason: str | None = None
    trace: str | None = None


def run_cells(
    work: Work,
    cells: Mapping[str, Cell],
    folder: Path,
    settings: Mapping[str, Any],
    workers: Workers | None = None,
    retry_failed: bool = False,
    on_progress: Callable[[int, int], None] | None = None,
) -> dict[str, Outcome]:
    """Do what is left of the cells.

    Args:
        work: on a cell; a function at the top of a module, since it travels to other processes. Result and cell hold
            what JSON holds.
        cells: by name, which becomes the name of the cell's file.
        folder: of ``settings.json`` and ``cells/NAME.json``, made if need be. Cells may be added from run to run.
        settings: what all cells have in common; a folder of other settings is refused.
        workers: who does it.
        retry_failed: whether cells that failed before are tried again.
        on_progress: called with the number of cells done and of all, once at the start and after each cell.

    Returns:
        What became of every cell, in the order of ``cells``.

    Raises:
        FileProblem: if the folder belongs to other work or cannot be written.
        ResourceProblem: if the backend's package is missing, or a worker died.
    """
    workers = workers or Workers()
    workers.check()
    _claim(folder, settings)
    found: dict[str, Outcome] = {}
    for name, cell in cells.items():
        outcome = _earlier(folder / CELLS / f"{name}.json", cell)
        if outcome is not None and not (retry_failed and outcome.status == "failed"):
            found[name] = outcome
    left = [(name, dict(cell)) for name, cell in cells.items() if name not in found]
    if on_progress is not None:
        on_progress(len(found), len(cells))
    with contextlib.closing(_outcomes(work, left, workers)) as outcomes:
        for name, outcome in outcomes:
            write_json(folder / CELLS / f"{name}.json", {"format_version": FORMAT_VERSION, **asdict(outcome)})
            found[name] = outcome
            if on_progress is not None:
                on_progress(len(found), len(cells))
    return {name: found[name] for name in cells}


def attempt(work: Work, name: str, cell: dict[str, Any]) -> tuple[str, Outcome]:
    """Do one cell, here and now, and say what became of it."""
    start = time.perf_counter()
    try:
        result = work(dict(cell))
    except SymdynError as error:
        return name, Outcome(cell, "failed", time.perf_counter() - start, reason=str(error))
    except Exception as error:  # a defect in one cell of a thousand must not stop the night's work
        reason = f"defect: {type(error).__name__}: {error}"
        return name, Outcome(cell, "failed", time.perf_counter() - start, reason=reason, trace=traceback.format_exc())
    return name, Outcome(cell, "done", time.perf_counter() - start, result=result)


def _claim(folder: Path, settings: Mapping[str, Any]) -> None:
    """Make the folder this work's, or see that it is."""
    path, wanted = folder / SETTINGS, {"format_version": FORMAT_VERSION, **settings}
    if not path.exists():
        writable_directory(folder)
        write_json(path, wanted)
        return
    before = read_json(path)
    if not isinstance(before, dict):
        raise FileProblem(path, "holds no settings; choose another --out.")
    changed = [name for name in {**wanted, **before} if before.get(name) != wanted.get(name)]
    if changed:
        raise FileProblem(path, f"belongs to work with a different {', '.join(changed)}; choose another --out.")
    writable_directory(folder)


def _earlier(path: Path, cell: Cell) -> Outcome | None:
    """What became of a cell in an earlier run, or None."""
    if not path.exists():
        return None
    data = read_json(path)
    if not isinstance(data, dict) or data.pop("format_version", None) != FORMAT_VERSION:
        raise FileProblem(path, f"is not a result with format_version {FORMAT_VERSION}; delete it to compute it again.")
    try:
        outcome = Outcome(**data)
    except TypeError as error:
        raise FileProblem(path, f"is not the result of a cell ({error}); delete it to compute it again.") from error
    if outcome.cell != dict(cell):
        raise FileProblem(path, f"is the result of another cell, {outcome.cell}; choose another --out.")
    return outcome


def _outcomes(
    work: Work, cells: Sequence[tuple[str, dict[str, Any]]], workers: Workers
) -> Generator[tuple[str, Outcome], None, None]:
    """Names and outcomes as they arrive."""
    if not cells:
        return
    jobs = workers.jobs or -1
    calls = [joblib.delayed(attempt)(work, *cell) for cell in cells]
    with _connected(workers), joblib.parallel_config(backend=workers.backend):
        # Ray returns nothing before it has everything: a few a time, then
        ray, size = workers.backend == "ray", 4 * joblib.effective_n_jobs(jobs)
        try:
            for start in range(0, len(calls), size) if ray else (0,):
                parallel: Any = joblib.Parallel(jobs, **({} if ray else {"return_as": "generator_unordered"}))
                yield from parallel(calls[start : start + size] if ray else calls)
        except TerminatedWorkerError as error:
            raise ResourceProblem(
                "A worker process died, probably for lack of memory. Finished cells are kept: run the same command "
                "again with fewer --jobs."
            ) from error


@contextlib.contextmanager
def _connected(workers: Workers) -> Iterator[None]:
    """The cluster of a backend, for as long as it is needed. Neither package is among symdyn's."""
    if workers.backend == "ray":
        import ray.util.joblib  # pyright: ignore[reportMissingImports]

        ray.util.joblib.register_ray()
        yield
    elif workers.backend == "dask":
        import dask  # pyright: ignore[reportMissingImports]
        import distributed  # pyright: ignore[reportMissingImports]

        named = dask.config.get("scheduler-address", None)
        with (
            distributed.Client() if named else distributed.Client(n_workers=workers.jobs or None, threads_per_worker=1)
        ):
            yield
    else:
        yield
