"""Robots of example-robot-data without a robot file: which description, which pose they stand in.

Feet, legs and joints are not listed: :mod:`slip.robot.urdf` finds them in the description. Robots with a robot file
(:mod:`symdyn.robot.robot_file`) are known by that.
"""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.errors import UnknownName
from symdyn.robot.robot_file import ROBOTS, is_robot_file


@dataclass(frozen=True)
class KnownRobot:
    """Files of a robot, as paths inside example-robot-data's ``robots`` folder.

    Attributes:
        urdf: the description.
        srdf: holds the pose ``standing``.
    """

    urdf: str
    srdf: str


def _same_folder(name: str) -> KnownRobot:
    return KnownRobot(f"{name}_description/urdf/{name}.urdf", f"{name}_description/srdf/{name}.srdf")


_ANYMAL_B = KnownRobot("anymal_b_simple_description/robots/anymal.urdf", "anymal_b_simple_description/srdf/anymal.srdf")

KNOWN_ROBOTS: dict[str, KnownRobot] = {
    "go1": _same_folder("go1"),
    "a1": _same_folder("a1"),
    "b1": _same_folder("b1"),
    "solo12": KnownRobot("solo_description/robots/solo12.urdf", "solo_description/srdf/solo.srdf"),
    "anymal": _ANYMAL_B,  # as in example-robot-data's own loader of that name
    "anymal_b": _ANYMAL_B,
    "anymal_c": KnownRobot(
        "anymal_c_simple_description/urdf/anymal.urdf", "anymal_c_simple_description/srdf/anymal.srdf"
    ),
    "hyq": KnownRobot("hyq_description/robots/hyq_no_sensors.urdf", "hyq_description/srdf/hyq.srdf"),
}


def check_known(name: str) -> None:
    """Check the value of ``--robot``: a name of :data:`KNOWN_ROBOTS` or of symdyn's robot files, or a robot file.

    Raises:
        UnknownName: if it is none.
    """
    if name not in KNOWN_ROBOTS and name not in ROBOTS and not is_robot_file(name):
        raise UnknownName("robot", name, (*KNOWN_ROBOTS, *ROBOTS, "FILE.toml"))
