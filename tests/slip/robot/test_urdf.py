"""Quadrupeds read from descriptions, against what a person finds in them."""

from __future__ import annotations

import math
import random
from pathlib import Path
from xml.etree import ElementTree

import pinocchio
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slip.robot.urdf import load_robot, load_urdf
from symdyn.errors import FileProblem, InvalidValue, SymdynError, UnknownName
from symdyn.robot.descriptions import urdf_path
from symdyn.robot.legs import JOINTS, LEGS
from tests.robots import GO2
from tests.slip.robot.robots import FEET, every_robot, load_robot_once, other_urdf


@every_robot
def test_feet_and_legs_are_those_a_person_would_name(name: str) -> None:
    robot = load_robot_once(name)
    assert tuple(leg.name for leg in robot.legs) == LEGS
    assert tuple(leg.foot for leg in robot.legs) == FEET[name]
    assert load_urdf(robot.urdf).legs == robot.legs, "found without being named"


def test_go2s_joints_are_in_symdyns_order() -> None:
    robot = load_robot_once("go2")
    assert robot.joints == GO2.joint_names
    assert robot.standing.tolist() == GO2.default_joint_pos.tolist()
    assert robot.joints[robot.joints_of(robot.legs[2])] == GO2.joint_names[6:9]


@given(st.randoms(use_true_random=False))
def test_the_order_in_which_feet_are_named_does_not_matter(shuffle: random.Random) -> None:
    feet = list(FEET["solo12"])
    shuffle.shuffle(feet)
    assert load_urdf(load_robot_once("solo12").urdf, feet=feet).legs == load_robot_once("solo12").legs


def test_an_arm_is_carried_and_held() -> None:
    urdf = other_urdf("b1_description", "urdf/b1-z1.urdf")
    robot = load_urdf(urdf, feet=FEET["b1"])
    assert len(robot.joints) == len(JOINTS)
    masses = ElementTree.parse(urdf).getroot().findall("link/inertial/mass")
    assert pinocchio.computeTotalMass(robot.model) == pytest.approx(sum(float(m.get("value", "nan")) for m in masses))


def test_joints_in_no_pose_are_at_the_limit_nearest_to_zero() -> None:
    standing = load_urdf(urdf_path(GO2), pose={"FL_thigh_joint": 0.5}).standing
    expected = {"hip": 0.0, "thigh": 0.0, "calf": -0.83776}
    for joint, angle in zip(JOINTS, standing, strict=True):
        assert angle == pytest.approx(0.5 if joint == "LF_thigh" else expected[joint.partition("_")[2]])


# Bad input


def test_unknown_robot() -> None:
    with pytest.raises(UnknownName, match=r"Unknown robot 'go3'.*Did you mean 'go2'.*anymal_c, b1"):
        load_robot("go3")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "not valid XML"),
        ("legs: 4", "not valid XML"),
        ("<robot name='r'>", "not valid XML"),
        ("<mujoco/>", "root element is <mujoco>"),
        ("<robot name='r'/>", "has no link"),
        (
            "<robot name='r'><link name='a'/><joint name='j' type='revolute'><parent link='a'/></joint></robot>",
            "Pinocchio",
        ),
        ("<robot name='r'><link name='a'/></robot>", "ends are none"),
    ],
)
def test_a_file_that_is_no_quadrupeds_urdf(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "robot.urdf"
    path.write_text(text)
    with pytest.raises(SymdynError, match=said) as raised:
        load_urdf(path)
    assert "robot.urdf" in str(raised.value)


@pytest.mark.parametrize("mass", ["0", "nan"])
def test_a_robot_without_mass(tmp_path: Path, mass: str) -> None:
    tree = ElementTree.parse(urdf_path(GO2))
    for element in tree.getroot().findall("link/inertial/mass"):
        element.set("value", mass)
    tree.write(tmp_path / "ghost.urdf")
    with pytest.raises(FileProblem, match=r"ghost\.urdf"):
        load_urdf(tmp_path / "ghost.urdf")


def test_a_file_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(FileProblem, match=r"none\.urdf: cannot be read: No such file"):
        load_urdf(tmp_path / "none.urdf")
    with pytest.raises(FileProblem, match="Is a directory"):
        load_urdf(tmp_path)


@pytest.mark.parametrize(
    ("folder", "file", "said"),
    [
        ("panda_description", "urdf/panda.urdf", "2: panda_leftfinger, panda_rightfinger"),
        ("b1_description", "urdf/b1-z1.urdf", "5: FL_foot, FR_foot, RL_foot, RR_foot, gripperMover"),
        ("allegro_hand_description", "urdf/allegro_left_hand.urdf", "a leg at each corner"),
    ],
)
def test_a_robot_without_four_legs(folder: str, file: str, said: str) -> None:
    with pytest.raises(SymdynError, match=said):
        load_urdf(other_urdf(folder, file))


@pytest.mark.parametrize(
    ("feet", "said"),
    [
        (("RL_foot", "FL_foot", "FR_foot"), "3 were named"),
        (("RL_foot", "FL_foot", "FR_foot", "FR_foot"), "Four different feet"),
        (("RL_foot", "FL_foot", "FR_foot", "RR_toe"), "Unknown foot 'RR_toe'. Did you mean 'RR_foot'"),
        (("RL_foot", "FL_foot", "FR_foot", "base"), "Unknown foot 'base'"),
        (("RL_foot", "FL_foot", "FR_foot", "FR_calf"), "share the joint FR_calf_joint"),
        (("RL_foot", "FL_foot", "FR_foot", "RR_hip"), "is moved by 1 joint"),
    ],
)
def test_feet_that_are_none(feet: tuple[str, ...], said: str) -> None:
    with pytest.raises(SymdynError, match=said):
        load_urdf(urdf_path(GO2), feet=feet)


def test_poses_that_are_none(tmp_path: Path) -> None:
    with pytest.raises(UnknownName, match="Unknown joint 'knee'"):
        load_urdf(urdf_path(GO2), pose={"knee": 1.0})
    with pytest.raises(InvalidValue, match=r"FL_calf_joint.*nan"):
        load_urdf(urdf_path(GO2), pose={"FL_calf_joint": math.nan})
    with pytest.raises(SymdynError, match="above the hip"):
        load_urdf(urdf_path(GO2), pose={"FL_thigh_joint": 3.0})
    srdf = tmp_path / "robot.srdf"
    for text, said in (
        ("<robot name='r'/>", "no group_state called 'standing'"),
        (
            "<robot name='r'><group_state name='standing'><joint name='j' value='x'/></group_state></robot>",
            "'j' is not a number",
        ),
        ("standing", "not valid XML"),
    ):
        srdf.write_text(text)
        with pytest.raises(FileProblem, match=said):
            load_urdf(urdf_path(GO2), srdf=srdf)
