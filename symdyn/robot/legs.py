"""Names and order of legs and joints: the one place where a robot's names meet the paper's.

Every array over legs in symdyn has the order :data:`LEGS`, every array over joints the order :data:`JOINTS`, which is
leg by leg, so that ``q.reshape(..., len(LEGS), len(LEG_JOINTS))`` gives a row a leg. Robots, simulators and wire
formats have orders of their own; :func:`permutation` translates by name.
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.errors import SymdynError

LEGS = ("LH", "LF", "RF", "RH")
"""Left hind, left front, right front, right hind: the paper's order."""

LEG_JOINTS = ("hip", "thigh", "calf")
"""Abduction, hip flexion, knee; from the trunk outwards."""

LEG_JOINT_AXES_B = {"hip": (1.0, 0.0, 0.0), "thigh": (0.0, 1.0, 0.0), "calf": (0.0, 1.0, 0.0)}
"""Axis of each joint in the body frame at zero angles (x forward, y left, z up); the same for every leg of the Go2."""

JOINTS = tuple(f"{leg}_{joint}" for leg in LEGS for joint in LEG_JOINTS)
"""The order of joint positions, velocities, torques and actions."""


def is_left(leg: str) -> bool:
    """Whether a leg of :data:`LEGS` is on the left side."""
    return leg[0] == "L"


def is_front(leg: str) -> bool:
    """Whether a leg of :data:`LEGS` is a front leg."""
    return leg[1] == "F"


def permutation(source: Sequence[str], target: Sequence[str]) -> tuple[int, ...]:
    """Indices that reorder an array over ``source`` names into ``target`` order.

    Args:
        source: names in the order of the array at hand.
        target: names in the wanted order.

    Returns:
        ``index`` such that ``array[..., index]`` is in ``target`` order.

    Raises:
        SymdynError: if the two do not hold the same names, each once.
    """
    if len(set(source)) != len(source) or sorted(source) != sorted(target):
        raise SymdynError(f"Names do not match: have {', '.join(source)}; need {', '.join(target)}, each once.")
    where = {name: i for i, name in enumerate(source)}
    return tuple(where[name] for name in target)
