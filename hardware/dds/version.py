"""Which cyclonedds this wire was tested with. Another one is refused: some make the robot's own programs crash."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version

from symdyn.errors import ResourceProblem

TESTED = ("11.0.1",)


def check_version() -> None:
    """Raises ResourceProblem if another cyclonedds is installed than was tested, or none."""
    wanted = f"pip install 'cyclonedds=={TESTED[-1]}'"
    try:
        found = version("cyclonedds")
    except PackageNotFoundError:
        raise ResourceProblem(f"cyclonedds is not installed: {wanted}.") from None
    if found not in TESTED:
        raise ResourceProblem(
            f"cyclonedds {found} was not tested with the robot, and a wrong version can crash the robot's programs. In "
            f"an environment without Unitree's SDK, which needs an old version: {wanted}."
        )
