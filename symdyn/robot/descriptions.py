"""Where the URDFs of robots and their meshes lie."""

from __future__ import annotations

import importlib.metadata
import math
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from symdyn.errors import FileProblem, ResourceProblem
from symdyn.robot.definition import Robot
from symdyn.robot.robot_file import EXAMPLE_ROBOT_DATA
from symdyn.robot.urdf_numbers import check_numbers


@cache  # what is installed does not change, and to list it takes longer than to build a model
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


def velocity_limits(robot: Robot) -> NDArray[np.float64]:
    """Highest speed of each joint, (12,) rad/s in the order of JOINTS: from the robot file, else from the URDF.

    Raises:
        FileProblem: if neither has one, or the URDF is missing or no XML.
        ResourceProblem: if example-robot-data is not installed.
    """
    path = urdf_path(robot)
    try:
        joints = {joint.get("name"): joint.find("limit") for joint in ElementTree.parse(path).iter("joint")}
    except (OSError, ElementTree.ParseError) as error:
        raise FileProblem(path, f"cannot be read as a URDF ({error}).") from error
    found = []
    for name in robot.joint_names:
        limit = joints.get(name)
        text = None if limit is None else limit.get("velocity")
        try:
            found.append(robot.limit(name).velocity or float(text or "nan"))
        except ValueError:
            raise FileProblem(path, f"has {text!r} as the velocity limit of {name!r}, which is not a number.") from None
        if not 0.0 < found[-1] < math.inf:
            raise FileProblem(path, f"has no velocity limit for {name!r}; the robot file can give one under limits.")
    return np.array(found)


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
