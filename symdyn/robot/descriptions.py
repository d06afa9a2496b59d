"""Where the URDFs of robots and their meshes lie."""

from __future__ import annotations

import importlib.metadata
from pathlib import Path

from symdyn.errors import FileProblem, ResourceProblem
from symdyn.robot.definition import Robot
from symdyn.robot.robot_file import EXAMPLE_ROBOT_DATA
from symdyn.robot.urdf_numbers import check_numbers


def robots_folder() -> Path:
    """Folder ``robots`` of the installed example-robot-data, whose wheel ships data only: there is nothing to import.

    Raises:
        ResourceProblem: if it is not installed or holds no robots.
    """
    try:
        files = importlib.metadata.files("example-robot-data") or []
    except importlib.metadata.PackageNotFoundError:
        raise ResourceProblem(
            "example-robot-data is not installed; the extras slip and rl bring it (docs/install.md)."
        ) from None
    for file in files:
        if "robots" in file.parts and file.suffix == ".urdf":
            path = Path(str(file.locate())).resolve()
            return next(parent for parent in path.parents if parent.name == "robots")
    raise ResourceProblem("The installed example-robot-data holds no robots; reinstall it.")


def urdf_path(robot: Robot) -> Path:
    """Path of the robot's URDF, whose numbers are sound. Raises FileProblem, ResourceProblem."""
    if robot.urdf.startswith(EXAMPLE_ROBOT_DATA):
        path = robots_folder() / robot.urdf.removeprefix(EXAMPLE_ROBOT_DATA)
        if not path.is_file():
            raise FileProblem(path, f"the description of {robot.name} is missing from example-robot-data.")
        return path
    path = Path(robot.urdf)
    if not path.is_file():
        raise FileProblem(path, f"the description of {robot.name} does not exist.")
    check_numbers(path)
    return path


def package_folders(urdf: Path) -> list[Path]:
    """Where the packages lie that a URDF names: its own folder, every one above it, and that of example-robot-data."""
    try:
        installed = [robots_folder().parents[1]]
    except ResourceProblem:
        installed = []
    return [*urdf.parents, *installed]


def mesh_path(urdf: Path, reference: str) -> Path:
    """The file of a mesh that a URDF names.

    Args:
        urdf: the description.
        reference: as it stands there: ``package://PACKAGE/PATH``, an absolute path, or one that counts from the URDF's
            folder. The folder of a package is looked for in :func:`package_folders`.

    Raises:
        FileProblem: if there is no such file.
    """
    relative = reference.removeprefix("package://")
    folders = package_folders(urdf) if relative != reference else [urdf.parent]
    for folder in folders:
        if (folder / relative).is_file():
            return folder / relative
    raise FileProblem(urdf, f"names the mesh {reference!r}, which lies neither beside it nor in a folder above it.")
