"""Groups found from descriptions: by the equations that define them, and on robots that were changed on purpose."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from itertools import product
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from slip.robot.known import KNOWN_ROBOTS
from slip.robot.morphology import Element, Morphology, find_morphology, group_name
from slip.robot.quadruped import BASE_VELOCITIES, Quadruped
from slip.robot.tolerances import Tolerances
from slip.robot.urdf import load_robot, load_urdf
from symdyn.gait.symmetry import K4, PAIRS, pair_joint_signs
from symdyn.robot.descriptions import robots_folder, urdf_path
from symdyn.robot.legs import JOINTS, LEG_JOINT_AXES_B, LEG_JOINTS, LEGS, is_left
from tests.robots import GO2

NAMES = tuple(g.name for g in K4)
ROBOTS = tuple(sorted(set(KNOWN_ROBOTS) - {"anymal"}))  # which is another name of anymal_b
every_robot = pytest.mark.parametrize("name", ROBOTS)

load_once = cache(load_robot)
poses = arrays(np.float64, len(JOINTS), elements=st.floats(-np.pi, np.pi))


@cache
def morphology(name: str) -> Morphology:
    return find_morphology(load_once(name))


def hips_centre(robot: Quadruped) -> np.ndarray:
    return robot.trunk_joints().mean(axis=0) * [1.0, 1.0, 0.0]


def mass_matrix_at_centre(robot: Quadruped, angles: np.ndarray) -> np.ndarray:
    """By its definition: kinetic energy of velocities whose linear part is that of the hips' centre."""
    n = BASE_VELOCITIES + len(robot.joints)
    columns = np.eye(n)
    for i in range(3, 6):
        columns[:3, i] = np.cross(np.eye(3)[i - 3], -hips_centre(robot))
    return columns.T @ robot.mass_matrix(angles) @ columns


# What is found satisfies what defines it


@pytest.mark.parametrize("element", NAMES)
@every_robot
@settings(max_examples=20)
@given(q=poses)
def test_feet_are_equivariant(name: str, element: str, q: np.ndarray) -> None:
    robot, g = load_once(name), morphology(name)[element]
    centre, feet = hips_centre(robot), robot.feet(q)
    images = robot.feet(g.on_joints(q)) - centre
    expected = (feet - centre)[list(g.leg_index)] * g.spatial.reflection_b
    assert np.abs(images - expected).max() < 1e-9
    assert g.kinematics_error < 1e-9


@pytest.mark.parametrize("element", NAMES)
@every_robot
@settings(max_examples=20)
@given(q=poses)
def test_mass_matrix_is_equivariant_within_what_is_said(name: str, element: str, q: np.ndarray) -> None:
    robot, g = load_once(name), morphology(name)[element]
    rho = g.representation
    expected = rho @ mass_matrix_at_centre(robot, q) @ rho.T
    error = np.linalg.norm(mass_matrix_at_centre(robot, g.on_joints(q)) - expected) / np.linalg.norm(expected)
    # said is the largest over some random poses; another may be a little worse
    assert error <= 1.5 * g.mass_error + 1e-12


@every_robot
def test_representations_form_k4(name: str) -> None:
    found = morphology(name)
    rho = {g: found[g].representation for g in NAMES}
    n = BASE_VELOCITIES + len(JOINTS)
    by_name = {g.name: g for g in K4}
    for a, b in product(NAMES, NAMES):
        np.testing.assert_array_equal(rho[a] @ rho[b], rho[(by_name[a] @ by_name[b]).name])
    for a in NAMES:
        np.testing.assert_array_equal(rho[a] @ rho[a].T, np.eye(n))
    np.testing.assert_array_equal(rho["e"], np.eye(n))


@every_robot
def test_groups_are_subgroups_and_the_bodys_lies_in_the_mechanisms(name: str) -> None:
    found, by_name = morphology(name), {g.name: g for g in K4}
    for group in (found.mechanism_group, found.body_group):
        assert {(by_name[a] @ by_name[b]).name for a in group for b in group} == set(group)
    assert set(found.body_group) <= set(found.mechanism_group)
    assert find_morphology(load_once(name)) == found, "the same again"


# The Go2: the figures, and what symdyn uses


def test_go2_is_c2_as_a_body_and_k4_as_a_mechanism() -> None:
    found = morphology("go2")
    assert (group_name(found.mechanism_group), found.body_group) == ("K4", ("e", "g_s"))
    assert found["e"].mass_error == found["e"].kinematics_error == found["e"].limits_error == 0.0
    assert found["g_s"].mass_error == pytest.approx(1.4e-5, rel=0.2)
    for name in ("g_t", "g_r"):
        assert found[name].mass_error == pytest.approx(2e-2, rel=0.2)
        assert found[name].limits_error == pytest.approx(3.56, abs=0.005)


@pytest.mark.parametrize("g", K4, ids=lambda g: g.name)
def test_symdyns_permutations_and_signs_are_the_derived_ones(g) -> None:
    found = morphology("go2")[g.name]
    assert g.leg_index == found.leg_index
    assert g.joint_index == found.joint_index
    assert g.joint_signs.tolist() == list(found.joint_signs)
    assert found.is_symdyns()
    # and so the whole representation
    x = np.arange(1.0, 1.0 + BASE_VELOCITIES + len(JOINTS))
    expected = [*g.reflection_b * x[:3], *g.axial_reflection_b * x[3:6], *g.joint_signs * x[6:][list(g.joint_index)]]
    np.testing.assert_array_equal(found.representation @ x, expected)


def test_the_rewards_pair_signs_are_the_derived_ones() -> None:
    # legs of opposite sides agree by the signs with which g_s puts one in the other's place
    g_s = morphology("go2")["g_s"]
    for (i, j), signs in zip(PAIRS, pair_joint_signs(), strict=True):
        derived = g_s.joint_signs[3 * i : 3 * i + 3] if is_left(LEGS[i]) != is_left(LEGS[j]) else (1, 1, 1)
        assert signs.tolist() == list(derived)


def test_symdyns_joint_axes_are_the_descriptions() -> None:
    robot = load_once("go2")
    assert robot.joints == GO2.joint_names
    data = robot.placed(np.zeros(len(JOINTS)))
    for leg in robot.legs:
        for kind, joint, column in zip(LEG_JOINTS, leg.joints, robot.velocity_index(leg), strict=True):
            axis_b = data.J[3:, column]
            np.testing.assert_allclose(axis_b, LEG_JOINT_AXES_B[kind], atol=1e-12, err_msg=joint)


@pytest.mark.parametrize(
    ("name", "mechanism", "body"),
    [
        ("go1", "K4", "C2"),
        ("a1", "K4", "C2"),
        ("b1", "K4", "C2"),
        ("solo12", "K4", "K4"),
        ("anymal_b", "K4", "K4"),
        ("anymal_c", "K4", "C2"),
        ("hyq", "K4", "1"),
    ],
)
def test_other_robots(name: str, mechanism: str, body: str) -> None:
    found = morphology(name)
    assert (group_name(found.mechanism_group), group_name(found.body_group)) == (mechanism, body)


def test_signs_are_found_and_not_assumed() -> None:
    # HyQ's abduction axes are each other's mirror image, unlike those of every other robot here
    assert set(morphology("hyq")["g_s"].joint_signs) == {1}
    assert not morphology("hyq")["g_s"].is_symdyns()
    assert morphology("hyq")["e"].is_symdyns()


def test_two_joints_a_leg() -> None:
    found = find_morphology(load_urdf(robots_folder() / "solo_description/robots/solo.urdf"))
    assert found.body_group == NAMES
    assert found["g_t"].joint_signs == (-1,) * 8
    assert not found["g_s"].is_symdyns()


# Robots changed on purpose


def changed(tmp_path: Path, *changes: tuple[str, str, Callable[[np.ndarray], np.ndarray]]) -> Morphology:
    """The Go2 with some vectors of its description changed: (path of the element, attribute, what to do with it)."""
    tree = ElementTree.parse(urdf_path(GO2))
    for path, attribute, change in changes:
        element = tree.getroot().find(path)
        assert element is not None
        vector = np.array([float(x) for x in element.get(attribute, "").split()])
        element.set(attribute, " ".join(map(str, change(vector))))
    file = tmp_path / "changed.urdf"
    tree.write(file)
    return find_morphology(load_urdf(file))


def moved(*by: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda vector: vector + by


def test_an_axis_turned_round_turns_its_sign_round(tmp_path: Path) -> None:
    found = changed(tmp_path, ("joint[@name='RR_thigh_joint']/axis", "xyz", np.negative))
    joint = JOINTS.index("RH_thigh")
    image = JOINTS.index("LH_thigh")
    g_s, before = found["g_s"], morphology("go2")["g_s"]
    assert found.mechanism_group == NAMES
    assert found["e"].joint_signs == (1,) * len(JOINTS)
    for i, (sign, was) in enumerate(zip(g_s.joint_signs, before.joint_signs, strict=True)):
        assert sign == (-was if i in (joint, image) else was)
    # its masses mirror as before, but its limits do not: they were not turned
    assert g_s.mass_error == pytest.approx(before.mass_error, rel=1e-3)
    assert g_s.limits_error > 1.0
    assert not g_s.is_symdyns()


def test_a_hip_moved_outwards_breaks_the_mechanism(tmp_path: Path) -> None:
    # one hip 20 mm further back: nothing maps its leg onto another
    found = changed(tmp_path, ("joint[@name='RR_hip_joint']/origin", "xyz", moved(-0.02, 0, 0)))
    assert found.mechanism_group == ("e",)
    assert all(found[name].kinematics_error > 5e-3 for name in NAMES[1:])


def test_both_hind_hips_moved_back_leave_every_element(tmp_path: Path) -> None:
    # the centre of the hips moves along, and with it the transverse plane
    back = [(f"joint[@name='{leg}_hip_joint']/origin", "xyz", moved(-0.02, 0, 0)) for leg in ("RR", "RL")]
    found = changed(tmp_path, *back)
    assert found.mechanism_group == NAMES
    assert found["g_t"].mass_error > morphology("go2")["g_t"].mass_error, "the trunk stayed where it was"


def test_a_longer_shank_breaks_what_moves_it(tmp_path: Path) -> None:
    change = [(f"joint[@name='{leg}_foot_joint']/origin", "xyz", moved(0, 0, -0.03)) for leg in ("FL", "FR")]
    assert changed(tmp_path, *change).mechanism_group == ("e", "g_s")
    assert changed(tmp_path, change[0]).mechanism_group == ("e",)


def test_a_load_on_one_side_breaks_the_body_only(tmp_path: Path) -> None:
    found = changed(tmp_path, ("link[@name='base']/inertial/origin", "xyz", moved(0, 0.03, 0)))
    assert found.mechanism_group == NAMES
    assert found.body_group == ("e",)
    assert found["g_s"].limits_error == 0.0


def test_tolerances_decide() -> None:
    robot = load_once("go2")
    assert find_morphology(robot, Tolerances(mass=1e-6)).body_group == ("e",)
    assert find_morphology(robot, Tolerances(mass=0.1, limits=4.0)).body_group == NAMES
    assert find_morphology(robot, Tolerances(mass=0.1)).body_group == ("e", "g_s")


def test_two_elements_without_their_product_are_no_group() -> None:
    # a1: g_s 4.1e-3, g_t 2.4e-3, g_r 5.6e-3
    found = find_morphology(load_once("a1"), Tolerances(mass=5e-3, limits=4.0))
    assert [g.of_body(found.tolerances) for g in found.elements] == [True, True, True, False]
    assert found.body_group == ("e", "g_t"), "the better of the two"


def test_legs_with_different_numbers_of_joints(tmp_path: Path) -> None:
    tree = ElementTree.parse(urdf_path(GO2))
    for leg in ("FL", "FR"):
        joint = tree.getroot().find(f"joint[@name='{leg}_hip_joint']")
        assert joint is not None
        joint.set("type", "fixed")
    tree.write(tmp_path / "mixed.urdf")
    found = find_morphology(load_urdf(tmp_path / "mixed.urdf"))
    assert found.mechanism_group == found.body_group == ("e", "g_s")
    assert found["g_s"].joint_signs == (-1, 1, 1, 1, 1, 1, 1, -1, 1, 1)
    assert found["g_t"].kinematics_error > 0.1


def test_a_limit_that_only_one_leg_has(tmp_path: Path) -> None:
    tree = ElementTree.parse(urdf_path(GO2))
    joint = tree.getroot().find("joint[@name='RR_calf_joint']")
    assert joint is not None
    joint.set("type", "continuous")
    tree.write(tmp_path / "free.urdf")
    found = find_morphology(load_urdf(tmp_path / "free.urdf"))
    assert found.mechanism_group == NAMES
    assert found.body_group == ("e",)
    assert found["g_s"].limits_error == np.inf
    assert json.loads(json.dumps(found.as_dict(), allow_nan=False))["elements"][1]["limits_error"] is None


def test_continuous_joints_have_no_limits(tmp_path: Path) -> None:
    text = urdf_path(GO2).read_text().replace('type="revolute"', 'type="continuous"')
    path = tmp_path / "wheels.urdf"
    path.write_text(text)
    found: Element = find_morphology(load_urdf(path))["g_t"]
    assert found.limits_error == 0.0
    assert found.joint_signs == morphology("go2")["g_t"].joint_signs
    assert found.mass_error == pytest.approx(morphology("go2")["g_t"].mass_error)
