"""Where the descriptions of example-robot-data lie (its wheel ships data only, so there is nothing to import)."""

from __future__ import annotations

import importlib.metadata
from pathlib import Path

from symdyn.errors import FileProblem, ResourceProblem
from symdyn.robot.definition import Robot


def robots_folder() -> Path:
    """Folder ``robots`` of the installed example-robot-data.

    Raises:
        ResourceProblem: if it is not installed or holds no robots.
    """
    try:
        files = importlib.metadata.files("example-robot-data") or []
    except importlib.metadata.PackageNotFoundError:
        raise ResourceProblem(
            "example-robot-data is not installed; pip install 'symdyn-gaits[slip]' or 'symdyn-gaits[rl]' brings it."
        ) from None
    for file in files:
        if "robots" in file.parts and file.suffix == ".urdf":
            path = Path(str(file.locate())).resolve()
            return next(parent for parent in path.parents if parent.name == "robots")
    raise ResourceProblem("The installed example-robot-data holds no robots; reinstall it.")


def urdf_path(robot: Robot) -> Path:
    """Path of the robot's URDF. Raises FileProblem, ResourceProblem."""
    path = robots_folder() / robot.urdf
    if not path.is_file():
        raise FileProblem(path, f"the description of {robot.name} is missing from example-robot-data.")
    return path
