"""A training run's directory: what lies in it, and whether it may be used."""

from __future__ import annotations

import shlex
from datetime import datetime
from pathlib import Path
from typing import Any

from rl.learning import checkpoint
from symdyn.errors import FileProblem
from symdyn.gait.timing import TimingCurve
from symdyn.io.files import read_json, writable_directory, write_json
from symdyn.robot.definition import Robot
from symdyn.robot.robot_file import get_robot, is_robot_file, load_robot_file, save_robot_file

CONFIG = "config.yaml"
TIMING = "timing.json"
ROBOT = "robot.json"
ORIGIN = "origin.json"
POLICY = "policy.onnx"
SELECTION = "selection.json"

STARTED_FROM = "started_from"
"""Key of origin.json."""


def check_fresh(run: Path) -> None:
    """Check that a directory, which need not exist, holds no run.

    Raises:
        FileProblem: if it does.
    """
    if (run / CONFIG).exists() or checkpoint.list_checkpoints(run):
        name = shlex.quote(str(run))
        raise FileProblem(run, f"already holds a run: continue it with --resume {name}, or choose another --out.")


def reserve(preset: str, parent: Path = Path("runs")) -> Path:
    """Make the directory ``runs/DATE-TIME-PRESET``, with a number after it if another process was faster.

    Raises:
        FileProblem: if it cannot be made.
    """
    name = f"{datetime.now():%Y%m%d-%H%M%S}-{preset}"
    try:
        parent.mkdir(parents=True, exist_ok=True)
        run, number = parent / name, 1
        while True:
            try:
                run.mkdir()
                return run
            except FileExistsError:
                number += 1
                run = parent / f"{name}-{number}"
    except OSError as error:
        raise FileProblem(parent, f"is not a writable directory: {error.strerror or error}.") from error


def existing(path: Path) -> Path:
    """A directory that holds a run.

    Raises:
        FileProblem: if it does not.
    """
    if not path.is_dir():
        raise FileProblem(path, "is not a directory.")
    if not (path / CONFIG).is_file():
        raise FileProblem(path, f"is not a run of symdyn train: it contains no {CONFIG}.")
    return path


def robot(run: Path, chosen: str) -> Robot:
    """The robot of a run: its own copy, or while it has none the one that was chosen.

    Args:
        run: directory.
        chosen: name or file of a robot, as the run's settings have it.

    Raises:
        FileProblem: if the file is missing or malformed.
        UnknownName: if there is no robot of that name.
    """
    return load_robot_file(run / ROBOT) if (run / ROBOT).is_file() else get_robot(chosen)


def robot_flag(chosen: str) -> str:
    """What a command needs to know this robot: ``--robot FILE`` for one that does not come with symdyn, else nothing.

    Args:
        chosen: name or file of a robot, as the run's settings have it.
    """
    return f" --robot {shlex.quote(chosen)}" if is_robot_file(chosen) else ""


def timing(run: Path, chosen: Path | None, robot: Robot) -> TimingCurve:
    """The curves of a run: its own copy, or while it has none those of the file that was chosen, or the paper's.

    Args:
        run: directory.
        chosen: a curves file.
        robot: of the run.

    Raises:
        FileProblem: if the file is missing or malformed, or was made for another robot.
    """
    if (run / TIMING).is_file():
        return TimingCurve.load(run / TIMING, robot.name)
    return TimingCurve() if chosen is None else TimingCurve.load(chosen, robot.name)


def ancestor(run: Path) -> dict[str, Any]:
    """What lies behind a run that was started from another (``--start-from``), as its ``origin.json`` has it.

    Returns:
        ``samples`` and ``seconds`` of training, 0 for a run that began with random weights; of others also ``run``,
        ``seed`` and ``iteration``.

    Raises:
        FileProblem: if the file is damaged.
    """
    noted = read_json(run / ORIGIN) if (run / ORIGIN).is_file() else {}
    return noted.get(STARTED_FROM) or {"samples": 0, "seconds": 0.0}


def begin(run: Path, robot: Robot, curve: TimingCurve, origin: dict[str, Any]) -> None:
    """Write what must not change while the run goes on, whatever happens to the files it came from.

    Args:
        run: directory, made if need be.
        robot: that is trained.
        curve: its timing.
        origin: where the code came from.

    Raises:
        FileProblem: if it cannot be written.
    """
    writable_directory(run)
    if not (run / ROBOT).is_file():
        save_robot_file(robot, run / ROBOT)
    if not (run / TIMING).is_file():
        curve.save(run / TIMING, robot=robot.name)
        write_json(run / ORIGIN, origin)
