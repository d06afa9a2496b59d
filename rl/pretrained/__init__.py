"""The policies that come with symdyn, a file a robot; ``README.md`` beside this file is their model card."""

from __future__ import annotations

from pathlib import Path

from symdyn.errors import UnknownName
from symdyn.policy.file import Policy
from symdyn.robot.robot_file import DEFAULT_ROBOT, chosen_robot


def pretrained() -> dict[str, Path]:
    """The policy files by the name of their robot."""
    return {path.stem: path for path in sorted(Path(__file__).parent.glob("*.onnx"))}


def policy_path(robot: str = DEFAULT_ROBOT) -> Path:
    """The policy file of the robot of that name.

    Raises:
        UnknownName: if none comes with symdyn.
    """
    files = pretrained()
    try:
        return files[robot]
    except KeyError:
        raise UnknownName("policy that comes with symdyn", robot, files) from None


def load_policy(path: Path | None, robot: str | None) -> tuple[Path, Policy]:
    """The policy that a command is to run.

    Args:
        path: its file; if None, the one that comes with symdyn for the robot.
        robot: name or file of the robot that it is to run on; if None, the one that the policy names.

    Returns:
        The path, and the policy.

    Raises:
        SymdynError: as :func:`symdyn.robot.robot_file.get_robot`, :func:`policy_path` and
            :meth:`symdyn.policy.file.Policy.load`.
    """
    its = chosen_robot(robot)
    path = path or policy_path(DEFAULT_ROBOT if its is None else its.name)
    return path, Policy.load(path, its)
