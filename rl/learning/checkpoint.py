"""Checkpoints: whole files, newest first, never a pickle of anything but tensors and plain values."""

from __future__ import annotations

import logging
import pickle
import zipfile
from pathlib import Path
from typing import Any

import torch

from symdyn.errors import FileProblem
from symdyn.io.files import write_with

_log = logging.getLogger(__name__)
_KEPT = 2


def path_of(run: Path, iteration: int) -> Path:
    """File of the checkpoint after so many updates."""
    return run / "checkpoints" / f"{iteration:07d}.pt"


def list_checkpoints(run: Path) -> list[Path]:
    """The run's checkpoints, oldest first."""
    return sorted((run / "checkpoints").glob("[0-9]*.pt"))


def save(run: Path, iteration: int, content: dict[str, Any], keep_every: int) -> Path:
    """Write a checkpoint and drop those that need not stay. Raises FileProblem, with nothing half-written."""
    path = path_of(run, iteration)
    write_with(path, lambda temporary: torch.save(content, temporary))
    for old in list_checkpoints(run)[:-_KEPT]:
        if int(old.stem) % keep_every:
            old.unlink(missing_ok=True)
    return path


def load(path: Path) -> dict[str, Any]:
    """Read a checkpoint of :func:`save`; only tensors and plain values are accepted.

    Raises:
        FileProblem: if the file is missing, damaged, or holds anything else.
    """
    try:
        content = torch.load(path, weights_only=True, map_location="cpu")
    except FileNotFoundError:
        raise FileProblem(path, "does not exist.") from None
    except (OSError, EOFError, RuntimeError, ValueError, zipfile.BadZipFile, pickle.UnpicklingError) as error:
        first_line = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise FileProblem(path, f"is not a symdyn checkpoint ({first_line}).") from error
    if not isinstance(content, dict) or "iteration" not in content:
        raise FileProblem(path, "is not a symdyn checkpoint.")
    return content


def check_robot(content: dict[str, Any], robot: str, origin: object) -> None:
    """Check that a checkpoint is of a robot of that name; one from before checkpoints said so is of any.

    Raises:
        FileProblem: if it is of another.
    """
    its = content.get("robot", robot)
    if its != robot:
        raise FileProblem(origin, f"holds a checkpoint of the robot {its!r}, not of {robot!r}.")


def load_newest(run: Path) -> dict[str, Any]:
    """The newest checkpoint that can be read.

    Raises:
        FileProblem: if there is none.
    """
    for path in reversed(list_checkpoints(run)):
        try:
            return load(path)
        except FileProblem as error:
            _log.warning("%s Trying the previous one.", error)
    raise FileProblem(run, "contains no checkpoint to continue from; nothing was changed.")
