"""A quadruped from its URDF, loaded with Pinocchio: which joints and which foot belong to which leg.

Nothing is known by index. Feet are the ends of the kinematic tree (or the links that the caller names), a leg is the
chain of joints from the trunk to a foot, and geometry tells left from right and front from hind.
"""

# pinocchio lies in a folder that its wheel adds to the path at run time, out of pyright's sight
# pyright: reportMissingImports=false

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pinocchio

from slip.robot.known import KNOWN_ROBOTS, check_known
from slip.robot.quadruped import Leg, Quadruped
from symdyn.errors import FileProblem, InvalidValue, SymdynError, UnknownName
from symdyn.robot.definition import Robot
from symdyn.robot.descriptions import robots_folder, urdf_path
from symdyn.robot.legs import LEGS, is_front, is_left
from symdyn.robot.robot_file import get_robot
from symdyn.robot.urdf_numbers import check_numbers

Chain = tuple[str, tuple[str, ...]]
"""A foot link and the joints from the trunk to it."""

_BASE_JOINT = 1
"""Pinocchio's number of the floating base; 0 is the universe."""


def load_robot(name: str) -> Quadruped:
    """A robot by name or robot file, standing as its robot file has it; those without one as their SRDF has it.

    Args:
        name: of :data:`symdyn.robot.robot_file.ROBOTS` or :data:`slip.robot.known.KNOWN_ROBOTS`, or the path of a
            robot file.

    Raises:
        UnknownName: if it is not known.
        ResourceProblem: if example-robot-data is not installed.
        FileProblem: if its files are missing or broken.
    """
    check_known(name)
    if name in KNOWN_ROBOTS:
        known, folder = KNOWN_ROBOTS[name], robots_folder()
        return load_urdf(folder / known.urdf, name=name, srdf=folder / known.srdf)
    robot = get_robot(name)
    pose = dict(zip(robot.joint_names, robot.default_joint_pos.tolist(), strict=True))
    return load_urdf(urdf_path(robot), name=robot.name, feet=robot.foot_links, pose=pose, definition=robot)


def load_urdf(
    urdf: Path,
    *,
    feet: Sequence[str] | None = None,
    srdf: Path | None = None,
    pose: Mapping[str, float] | None = None,
    name: str | None = None,
    definition: Robot | None = None,
) -> Quadruped:
    """Any robot with four legs.

    Args:
        urdf: its description; meshes are not needed.
        feet: names of the four foot links in any order; the ends of the kinematic tree if left out.
        srdf: a file with a group state called ``standing``, the nominal stance.
        pose: joint angles of the nominal stance by name, rad; goes before ``srdf``. Joints in neither are at zero, or
            at the limit nearest to it.
        name: of the robot; the file's name if left out.
        definition: the robot's gains and leg length, if symdyn defines it.

    Raises:
        FileProblem: if a file cannot be read, or is no URDF or SRDF.
        UnknownName: if a foot or a joint of the pose is not in the description.
        SymdynError: if there are not four legs, one at each corner, each hanging below its hip.
    """
    model = _read_model(urdf)
    chains = [_chain(model, urdf, foot) for foot in (_ends(model, urdf) if feet is None else _named(model, feet))]
    _check_nothing_is_shared(chains, urdf)
    if not pinocchio.computeTotalMass(model) > 0.0:  # nor nan
        raise FileProblem(urdf, "describes links without mass.")
    legs = _assigned(model, chains, urdf)
    given = ({} if srdf is None else _standing_of(srdf)) | _checked(model, pose or {})
    angles = [given.get(joint, _nearest_to_zero(model, joint)) for leg in legs for joint in leg.joints]
    robot = Quadruped(name or urdf.stem, urdf, model, legs, np.array(angles, dtype=np.float64), definition)
    _check_feet_below_hips(robot)
    return robot


def _read_xml(path: Path, what: str) -> ElementTree.Element:
    try:
        root = ElementTree.parse(path).getroot()
    except OSError as error:
        raise FileProblem(path, f"cannot be read: {error.strerror or error}.") from error
    except (ElementTree.ParseError, ValueError) as error:
        raise FileProblem(path, f"cannot be read as {what}: it is not valid XML ({error}).") from error
    if root.tag != "robot":
        raise FileProblem(path, f"cannot be read as {what}: its root element is <{root.tag}>, not <robot>.")
    return root


def _read_model(urdf: Path) -> Any:
    root = _read_xml(urdf, "URDF")
    if root.find("link") is None:
        raise FileProblem(urdf, "cannot be read as URDF: it has no links.")
    check_numbers(urdf)
    try:
        return pinocchio.buildModelFromUrdf(str(urdf), pinocchio.JointModelFreeFlyer())
    except Exception as error:  # Pinocchio raises what the parser beneath it raises
        raise FileProblem(urdf, f"cannot be read as URDF by Pinocchio ({str(error).strip()}).") from error


def _bodies(model: Any, joint: int) -> list[Any]:
    return [f for f in model.frames if f.type == pinocchio.FrameType.BODY and f.parentJoint == joint]


def _ends(model: Any, urdf: Path) -> list[str]:
    # the link furthest out on each joint that carries no other joint
    tips = [joint for joint in range(_BASE_JOINT + 1, model.njoints) if len(model.children[joint]) == 0]
    ends = []
    for tip in tips:
        reach = [
            (round(float(np.linalg.norm(f.placement.translation)), 6), i) for i, f in enumerate(_bodies(model, tip))
        ]
        ends.append(_bodies(model, tip)[max(reach)[1]].name)
    if len(ends) != len(LEGS):
        found = f"{len(ends)}: {', '.join(sorted(ends))}" if ends else "none"
        raise SymdynError(
            f"{urdf}: a quadruped has four legs, but the kinematic tree's ends are {found}. Name four feet."
        )
    return ends


def _named(model: Any, feet: Sequence[str]) -> list[str]:
    if len(set(feet)) != len(LEGS) or len(feet) != len(LEGS):
        raise SymdynError(f"Four different feet are needed, but {len(feet)} were named: {', '.join(feet) or 'none'}.")
    links = [f.name for f in model.frames if f.type == pinocchio.FrameType.BODY and f.parentJoint > _BASE_JOINT]
    for foot in feet:
        if foot not in links:
            raise UnknownName("foot", foot, links)
    return list(feet)


def _chain(model: Any, urdf: Path, foot: str) -> Chain:
    joint = model.frames[model.getFrameId(foot, pinocchio.FrameType.BODY)].parentJoint
    names: list[str] = []
    while joint > _BASE_JOINT:
        if model.joints[joint].nv != 1:
            raise SymdynError(
                f"{urdf}: joint {model.names[joint]!r} of foot {foot!r} does not turn about a single axis."
            )
        names.insert(0, model.names[joint])
        joint = model.parents[joint]
    if len(names) < 2:
        raise SymdynError(f"{urdf}: foot {foot!r} is moved by {len(names)} joint, but a leg has two or more.")
    return foot, tuple(names)


def _check_nothing_is_shared(chains: list[Chain], urdf: Path) -> None:
    of_legs = [joint for _, joints in chains for joint in joints]
    if len(set(of_legs)) != len(of_legs):
        twice = sorted({joint for joint in of_legs if of_legs.count(joint) > 1})
        raise SymdynError(
            f"{urdf}: two of the feet share the joint {', '.join(twice)}; each leg needs joints of its own."
        )


def _checked(model: Any, pose: Mapping[str, float]) -> dict[str, float]:
    for joint, angle in pose.items():
        if joint not in model.names:
            raise UnknownName("joint", joint, list(model.names)[_BASE_JOINT + 1 :])
        if not np.isfinite(angle):
            raise InvalidValue(f"the pose's angle of joint {joint!r}", angle, "finite")
    return dict(pose)


def _nearest_to_zero(model: Any, name: str) -> float:
    joint = model.joints[model.getJointId(name)]
    if joint.nq != 1:
        return 0.0
    return float(np.clip(0.0, model.lowerPositionLimit[joint.idx_q], model.upperPositionLimit[joint.idx_q]))


def _standing_of(srdf: Path) -> dict[str, float]:
    states = [state for state in _read_xml(srdf, "SRDF").findall("group_state") if state.get("name") == "standing"]
    if not states:
        raise FileProblem(srdf, "has no group_state called 'standing'.")
    angles = {}
    for joint in states[-1].findall("joint"):
        values = joint.get("value", "").split()
        try:
            if len(values) == 1:  # the base's pose has seven
                angles[joint.get("name", "")] = float(values[0])
        except ValueError as error:
            raise FileProblem(srdf, f"the angle of joint {joint.get('name')!r} is not a number.") from error
    return angles


def _assigned(model: Any, chains: list[Chain], urdf: Path) -> tuple[Leg, ...]:
    hips = np.array([model.jointPlacements[model.getJointId(joints[0])].translation for _, joints in chains])
    forward, left = (hips - hips.mean(axis=0))[:, :2].T
    legs = []
    for name in LEGS:
        corner = np.flatnonzero(((forward > 0.0) == is_front(name)) & ((left > 0.0) == is_left(name)))
        if len(corner) != 1:
            where = ", ".join(f"{foot} ({x:.3f}, {y:.3f})" for (foot, _), (x, y, _) in zip(chains, hips, strict=True))
            raise SymdynError(
                f"{urdf}: a quadruped has a leg at each corner of its trunk, but {len(corner)} of these are at {name}; "
                f"hips in x forward, y left, m: {where}."
            )
        foot, joints = chains[int(corner[0])]
        legs.append(Leg(name, joints, foot))
    return tuple(legs)


def _check_feet_below_hips(robot: Quadruped) -> None:
    hips, feet = robot.trunk_joints(), robot.feet(robot.standing)
    for leg, hip, foot in zip(robot.legs, hips, feet, strict=True):
        if foot[2] >= hip[2]:
            raise SymdynError(
                f"{robot.urdf}: {leg.foot!r} is {foot[2] - hip[2]:.3f} m above the hip of {leg.name} in the nominal "
                "pose; it is not a foot, or the robot does not stand in this pose."
            )
