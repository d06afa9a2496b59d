"""The robots of example-robot-data that are known by name: which description, which pose they stand in.

Feet, legs and joints are not listed: :mod:`slip.robot.urdf` finds them in the description.
"""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.errors import UnknownName
from symdyn.robot.definition import GO2, Robot


@dataclass(frozen=True)
class KnownRobot:
    """Files of a robot, as paths inside example-robot-data's ``robots`` folder.

    Attributes:
        urdf: the description.
        srdf: holds the pose ``standing``; None if the pose is the definition's.
        definition: what training and deployment agree on, for robots that have it.
    """

    urdf: str
    srdf: str | None = None
    definition: Robot | None = None


def _same_folder(name: str) -> KnownRobot:
    return KnownRobot(f"{name}_description/urdf/{name}.urdf", f"{name}_description/srdf/{name}.srdf")


_ANYMAL_B = KnownRobot("anymal_b_simple_description/robots/anymal.urdf", "anymal_b_simple_description/srdf/anymal.srdf")

KNOWN_ROBOTS: dict[str, KnownRobot] = {
    GO2.name: KnownRobot(GO2.urdf, definition=GO2),
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


def known_robot(name: str) -> KnownRobot:
    """The robot of that name. Raises UnknownName."""
    try:
        return KNOWN_ROBOTS[name]
    except KeyError:
        raise UnknownName("robot", name, KNOWN_ROBOTS) from None
