"""Robot files: the one of the Go2 against its URDF, what comes back from disk, and what is refused in words."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symdyn.errors import FileProblem, InvalidValue, UnknownName
from symdyn.io.settings_data import plain
from symdyn.robot.definition import JointLimit, Leg, Robot
from symdyn.robot.descriptions import mesh_path, urdf_path
from symdyn.robot.legs import JOINTS, LEGS
from symdyn.robot.robot_file import ROBOTS, get_robot, load_robot_file, save_robot_file

GO2 = get_robot("go2")
DATA = plain(GO2)


def written(path: Path, edit: Callable[[dict[str, Any]], object] = lambda _: None) -> Path:
    """The Go2's file with something changed in place, as JSON."""
    data = json.loads(json.dumps(DATA))
    edit(data)
    path.write_text(json.dumps(data))
    return path


def test_arrays_over_joints_and_feet_are_in_the_order_of_symdyn() -> None:
    assert [name.removesuffix("_joint") for name in GO2.joint_names] == [
        {"LH": "RL", "LF": "FL", "RF": "FR", "RH": "RR"}[joint[:2]] + joint[2:] for joint in JOINTS
    ]
    assert GO2.foot_links == ("RL_foot", "FL_foot", "FR_foot", "RR_foot")
    poses = GO2.default_joint_pos.reshape(len(LEGS), 3)
    for pose, leg in zip(poses, LEGS, strict=True):
        assert tuple(pose) == getattr(GO2.legs, leg).stance


def test_every_robot_that_comes_with_symdyn_names_what_its_urdf_has() -> None:
    pinocchio = pytest.importorskip("pinocchio")
    assert "go2" in ROBOTS
    for name in ROBOTS:
        robot = get_robot(name)
        assert robot.name == name
        model = pinocchio.buildModelFromUrdf(str(urdf_path(robot)))
        assert all(model.existJointName(joint) for joint in robot.joint_names)
        assert all(model.existBodyName(link) for link in (robot.trunk, *robot.foot_links))


@pytest.mark.parametrize("suffix", [".toml", ".json"])
def test_read_from_a_path_it_is_the_robot_of_that_name(tmp_path: Path, suffix: str) -> None:
    source = Path(__file__).parents[3] / "symdyn" / "robot" / "robots" / "go2.toml"
    path = tmp_path / f"copy{suffix}"
    text = source.read_text() if suffix == ".toml" else json.dumps(tomllib.loads(source.read_text()))
    path.write_text(text)
    assert get_robot(str(path)) == GO2


def test_saved_it_is_read_back_the_same(tmp_path: Path) -> None:
    limit = JointLimit(GO2.joint_names[3], position=(-0.1, 0.1 + 0.2), torque=7.0)
    robot = replace(GO2, name="mine", limits=(limit,), gear_ratio=None)
    save_robot_file(robot, tmp_path / "robot.json")
    assert load_robot_file(tmp_path / "robot.json") == robot


def test_a_relative_urdf_counts_from_the_folder_of_the_file(tmp_path: Path) -> None:
    path = written(tmp_path / "mine.json", lambda d: d.update(urdf="../mine.urdf"))
    assert get_robot(str(path)).urdf == str((tmp_path / "../mine.urdf").resolve())


def test_what_is_left_out_takes_its_default(tmp_path: Path) -> None:
    path = written(
        tmp_path / "mine.json", lambda d: (d.pop("gear_ratio"), d.pop("limits"), d["legs"]["LH"].pop("lying"))
    )
    robot = load_robot_file(path)
    assert (robot.gear_ratio, robot.limits, robot.legs.LH.lying) == (None, (), None)


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (lambda d: d.pop("trunk"), "lacks the settings trunk"),
        (lambda d: d["legs"].pop("RF"), "lacks the settings legs.RF"),
        (lambda d: d["legs"]["LF"].pop("foot"), "lacks the settings legs.LF.foot"),
        (lambda d: d.update(weight=15.0), "unknown settings: weight. Known in the file: name, urdf, trunk"),
        (lambda d: d["legs"]["LH"].update(joints=["a", "b"]), "legs.LH.joints is .*, but must be a list of 3"),
        (lambda d: d["legs"]["LH"].update(foot="FL_foot"), "feet of the legs .* must be different"),
        (lambda d: d.update(kp=-1.0), "kp is -1.0, but must be a number > 0"),
        (lambda d: d.update(kp="30"), "kp is '30', but must be a finite number"),
        (lambda d: d.update(control_dt=0), "control_dt is 0.0, but must be a number > 0"),
        (lambda d: d.update(base_height_range=[0.45, 0.35]), "base_height_range .* the smaller first"),
        (lambda d: d.update(name="my robot"), "name is 'my robot', but must be a word"),
        (
            lambda d: d.update(limits=[{"joint": "knee"}]),
            r"joints of limits is \['knee'\], but must be each once",
        ),
        (lambda d: d.update(limits=5), "limits is 5, but must be a list, each a table of settings"),
        (lambda d: d.update(legs=5), "legs is 5, but must be a table of settings"),
    ],
)
def test_a_bad_file_is_refused_by_its_key(tmp_path: Path, edit: Callable[[Any], object], message: str) -> None:
    path = written(tmp_path / "mine.json", edit)
    with pytest.raises(FileProblem, match=message) as caught:
        load_robot_file(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("name", "kind"), [("mine.toml", "TOML"), ("mine.json", "JSON")])
def test_what_is_no_toml_or_json_is_refused(tmp_path: Path, name: str, kind: str) -> None:
    (tmp_path / name).write_text("<robot name='go2'/>")
    with pytest.raises(FileProblem, match=f"is not a robot file: it is not valid {kind}"):
        get_robot(str(tmp_path / name))
    with pytest.raises(FileProblem, match="cannot be read"):
        get_robot(str(tmp_path / f"other{name}"))


def test_an_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(UnknownName, match=r"Unknown robot 'go3'. Did you mean 'go2'\? Known: FILE.toml, .*go2"):
        get_robot("go3")


def test_another_stance_goes_to_the_legs_by_name() -> None:
    pose = np.arange(12.0)
    robot = GO2.standing_at(pose)
    assert np.array_equal(robot.default_joint_pos, pose)
    assert robot.legs.LH.stance == (0.0, 1.0, 2.0)  # the first of LEGS
    assert robot.legs.RH.stance == (9.0, 10.0, 11.0)
    others = [field.name for field in fields(Robot) if field.name != "legs"]
    assert [getattr(robot, name) for name in others] == [getattr(GO2, name) for name in others]
    with pytest.raises(InvalidValue, match="The stance of the legs"):
        GO2.standing_at(np.full(12, np.nan))


def test_limits_by_joint() -> None:
    name = GO2.joint_names[0]
    robot = replace(GO2, limits=(JointLimit(name, velocity=3.0),))
    assert robot.limit(name).velocity == 3.0
    assert robot.limit(GO2.joint_names[1]) == JointLimit(GO2.joint_names[1])


def test_every_key_has_a_meaning() -> None:
    for kind in (Robot, Leg, JointLimit):
        for field in fields(kind):
            assert f"\n        {field.name}: " in (kind.__doc__ or ""), f"{kind.__name__}.{field.name}"


def test_meshes_are_found_beside_the_description_and_in_the_folders_above(tmp_path: Path) -> None:
    urdf = tmp_path / "mine_description" / "urdf" / "mine.urdf"
    mesh = tmp_path / "mine_description" / "meshes" / "foot.stl"
    for path in (urdf, mesh):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    assert mesh_path(urdf, "package://mine_description/meshes/foot.stl") == mesh
    assert mesh_path(urdf, "../meshes/foot.stl").resolve() == mesh
    assert mesh_path(urdf, str(mesh)) == mesh
    installed = "package://example-robot-data/robots/go2_description/urdf/go2.urdf"  # any file will do
    assert mesh_path(urdf, installed) == urdf_path(GO2)
    with pytest.raises(FileProblem, match=r"names the mesh 'package://mine/foot\.stl'"):
        mesh_path(urdf, "package://mine/foot.stl")
