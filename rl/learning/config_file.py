"""The settings of a run as YAML: written before it runs, read back with every key and type checked."""

from __future__ import annotations

from pathlib import Path

import yaml

from rl.learning.config import TrainConfig
from symdyn.errors import FileProblem
from symdyn.io.files import write_text
from symdyn.io.settings_data import plain, rebuild


def save(config: TrainConfig, path: Path) -> None:
    """Write the settings, whole or not at all.

    Raises:
        FileProblem: if the file cannot be written, or the settings could not be read back (an infinite number).
    """
    data = plain(rebuild(TrainConfig, plain(config), path))
    write_text(path, yaml.safe_dump(data, sort_keys=False))


def load(path: Path) -> TrainConfig:
    """Read the settings of :func:`save`.

    Raises:
        FileProblem: if the file is missing or no YAML, or for what :func:`symdyn.io.settings_data.rebuild` refuses.
    """
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise FileProblem(path, f"cannot be read: {error.strerror or error}.") from error
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise FileProblem(path, f"is not valid YAML ({' '.join(str(error).split())}).") from error
    return rebuild(TrainConfig, data, path)
