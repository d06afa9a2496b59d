"""A training run's directory: what lies in it, and whether it may be used."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

from rl import checkpoint
from symdyn.errors import FileProblem
from symdyn.files import writable_directory

CONFIG = "config.yaml"
POLICY = "policy.onnx"


def fresh(path: Path | None, preset: str) -> Path:
    """A directory for a new run: ``path``, or ``runs/DATE-TIME-PRESET``.

    Raises:
        FileProblem: if it cannot be written to, or already holds a run.
    """
    run = path or Path("runs") / f"{datetime.now():%Y%m%d-%H%M%S}-{preset}"
    if (run / CONFIG).exists() or checkpoint.list_checkpoints(run):
        raise FileProblem(run, f"already holds a run: continue it with --resume {run}, or choose another --out.")
    return writable_directory(run)


def existing(path: Path) -> Path:
    """A directory that holds a run.

    Raises:
        FileProblem: if it does not.
    """
    if not path.is_dir():
        raise FileProblem(path, "is no directory.")
    if not (path / CONFIG).is_file():
        raise FileProblem(path, f"is no run of symdyn train (it holds no {CONFIG}).")
    return path
