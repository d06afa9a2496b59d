"""Several runs that differ in their seed alone: trained side by side, and what came of all of them."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rl.learning import config_file, run_dir, run_log
from rl.learning.config import TrainConfig
from rl.learning.signals import on_stop
from rl.physics.batch import BYTES_PER_ROBOT
from symdyn.errors import FileProblem, InvalidValue
from symdyn.io.files import read_json, writable_directory, write_json

FILE = "seeds.json"
"""What makes a directory one of several seeds. Beside it lie ``config.yaml``, and one run for each seed."""

_MEMORY_OF_A_RUN = 0.5e9
"""Bytes without robots. Measured: 0.47e9 with 16 of them."""
_DISK_OF_A_ROBOT = 3e3
_DISK_OF_A_NETWORK = 1.5e6
"""Bytes of a checkpoint. Measured: 3.8e6 with 1024 robots and the networks of the preset ``cpu``."""
_LOG_OF_AN_UPDATE = 3e3
_LOOK_EVERY_S = 1.0


@dataclass(frozen=True)
class SeedRun:
    """One of the runs.

    Attributes:
        seed: of everything random in it.
        directory: of the run.
    """

    seed: int
    directory: Path

    @property
    def output(self) -> Path:
        """Where what the run says is written."""
        return self.directory.with_suffix(".txt")

    def finished(self, config: TrainConfig) -> bool:
        """Whether it has come to its end and, if the settings of the runs say so, chosen its policy."""
        if config.candidates:
            return (self.directory / run_dir.SELECTION).is_file()
        last = self.last_record()
        return last is not None and last["iteration"] >= config.total_iterations

    def last_record(self) -> dict[str, Any] | None:
        """What the run logged of its newest update; None before the first."""
        path = self.directory / run_log.FILE
        if not path.is_file():
            return None
        with path.open("rb") as stream:
            stream.seek(max(path.stat().st_size - 20_000, 0))
            lines = stream.read().splitlines()
        for line in reversed(lines):
            try:
                return json.loads(line)
            except ValueError:  # the line that is being written, or one cut short by a kill
                continue
        return None


def runs_of(directory: Path) -> list[SeedRun]:
    """The runs of a directory that :func:`begin` made.

    Raises:
        FileProblem: if its list of seeds is missing or malformed.
    """
    seeds = read_json(directory / FILE).get("seeds")
    if not isinstance(seeds, list) or not all(isinstance(seed, int) for seed in seeds):
        raise FileProblem(directory / FILE, "holds no list of seeds.")
    return [SeedRun(seed, directory / f"seed-{seed}") for seed in seeds]


def begin(directory: Path, config: TrainConfig, count: int) -> list[SeedRun]:
    """Write down which runs a directory is to hold: ``count`` of them, from ``config.seed`` upwards.

    Raises:
        InvalidValue: if their number makes no sense, or there is no room for them in memory or on the disk.
        FileProblem: if the directory cannot be written to.
    """
    check_room(config, count, side_by_side(count), directory)
    writable_directory(directory)
    config_file.save(config, directory / run_dir.CONFIG)
    write_json(directory / FILE, {"seeds": [config.seed + number for number in range(count)]})
    return runs_of(directory)


def side_by_side(count: int) -> int:
    """How many runs train at a time: one for each processor, each on threads of its own.

    Two runs on a thread each learn more samples a second than two threads give to one run.
    """
    return min(count, os.cpu_count() or 1)


def check_room(config: TrainConfig, count: int, at_a_time: int, directory: Path) -> None:
    """Check that so many runs fit into memory and onto the disk.

    Raises:
        InvalidValue: if they do not, with what they need and what there is.
    """
    if count < 1:
        raise InvalidValue("--seeds", count, "a whole number > 0")
    memory = at_a_time * (_MEMORY_OF_A_RUN + config.num_envs * BYTES_PER_ROBOT)
    kept = config.total_iterations // config.keep_every + config.candidates + 2
    a_run = (
        kept * (_DISK_OF_A_NETWORK + config.num_envs * _DISK_OF_A_ROBOT) + config.total_iterations * _LOG_OF_AN_UPDATE
    )
    disk = count * a_run
    place = next(folder for folder in (directory.absolute(), *directory.absolute().parents) if folder.is_dir())
    for what, need, there in (("memory", memory, _memory_left()), ("disk", disk, shutil.disk_usage(place).free)):
        if need > there:
            raise InvalidValue(
                "--seeds",
                count,
                f"fewer, or runs of fewer robots: they need about {need / 1e9:.1f} GB of {what}, and "
                f"{there / 1e9:.1f} GB are free",
            )


def train(
    config: TrainConfig,
    runs: Sequence[SeedRun],
    flags: Sequence[str | Path],
    watch: Callable[[Sequence[SeedRun]], None],
) -> tuple[list[SeedRun], bool]:
    """Train the runs that are not finished, side by side, each in a process of its own; begun ones go on.

    Args:
        config: settings of the runs.
        runs: in the order in which they begin.
        flags: of ``symdyn train`` for each run that begins anew.
        watch: called every second with the runs that are at work.

    Returns:
        The runs that failed, and whether a signal stopped all of them. A signal is passed on: each run saves and ends.
    """
    waiting = [run for run in runs if not run.finished(config)]
    slots = side_by_side(max(len(waiting), 1))
    threads = max((os.cpu_count() or 1) // slots, 1)
    working: dict[SeedRun, subprocess.Popen[bytes]] = {}
    failed: list[SeedRun] = []

    def pass_on(number: int) -> None:
        for process in list(working.values()):
            if process.poll() is None:
                process.send_signal(number)

    with on_stop(pass_on) as stopped:
        while working or (waiting and not stopped):
            while waiting and len(working) < slots and not stopped:
                run = waiting.pop(0)
                working[run] = _start(run, flags, threads)
            watch(list(working))
            time.sleep(_LOOK_EVERY_S)
            for run, process in list(working.items()):
                if process.poll() is not None:
                    del working[run]
                    if process.returncode != 0 and not stopped:
                        failed.append(run)
    return failed, bool(stopped)


def table(runs: Sequence[SeedRun]) -> dict[str, dict[str, float]]:
    """What the validation says of the policy that each finished run chose: for each seed its figures, with the samples
    (millions) and minutes it took.
    """
    found = {}
    for run in runs:
        if (run.directory / run_dir.SELECTION).is_file():
            chosen = read_json(run.directory / run_dir.SELECTION)
            last = run.last_record() or {"samples": 0, "time/seconds": 0.0}
            took = {"samples_millions": last["samples"] / 1e6, "minutes": last["time/seconds"] / 60.0}
            found[f"seed {run.seed}"] = chosen["candidates"][chosen["chosen"]] | took
    return found


def _start(run: SeedRun, flags: Sequence[str | Path], threads: int) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "symdyn", "train"]
    if (run.directory / run_dir.CONFIG).is_file():
        command += ["--resume", str(run.directory)]
    else:
        settings = run.directory.parent / run_dir.CONFIG
        command += ["--settings", str(settings), "--seed", str(run.seed), "--out", str(run.directory)]
        command += ["--threads", str(threads), *map(str, flags)]
    try:
        with run.output.open("ab") as output:
            # a session of its own: Ctrl-C in the terminal reaches it once, through us
            return subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=output, stderr=output, start_new_session=True
            )
    except OSError as error:
        raise FileProblem(run.output, f"cannot be written: {error.strerror or error}.") from error


def _memory_left() -> float:
    """Bytes that processes can still have; without end where the system does not say."""
    try:
        with Path("/proc/meminfo").open(encoding="ascii") as lines:
            sizes = dict(line.split(":") for line in lines)
        return float(sizes["MemAvailable"].split()[0]) * 1024.0
    except (OSError, KeyError, ValueError):
        return float("inf")
