"""Numbers of a URDF that parsers drop or take in silence are refused, with their line, by every command."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from symdyn.errors import FileProblem
from symdyn.robot.descriptions import urdf_path
from symdyn.robot.robot_file import get_robot
from symdyn.robot.urdf_numbers import check_numbers
from tests.e2e.command_in_process import symdyn

GO2 = urdf_path(get_robot("go2"))
TEXT = GO2.read_text(encoding="utf-8")
MASS = re.search(r'value="6.921"', TEXT)[0]  # type: ignore[index]


def changed(folder: Path, old: str, new: str) -> tuple[Path, int]:
    """The Go2's URDF with one change, and the line where the element begins."""
    assert old in TEXT
    begin = TEXT.rindex("<", 0, TEXT.index(old))
    path = folder / "changed.urdf"
    path.write_text(TEXT.replace(old, new, 1), encoding="utf-8")
    return path, TEXT[:begin].count("\n") + 1


def test_the_urdfs_that_symdyn_knows_are_sound():
    from slip.robot.known import KNOWN_ROBOTS
    from symdyn.robot.descriptions import robots_folder

    check_numbers(GO2)
    for known in KNOWN_ROBOTS.values():
        check_numbers(robots_folder() / known.urdf)


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("6,921", "'6,921' is not a finite number (a decimal point is needed)"),
        ("${trunk_mass}", "is an expression of xacro"),
        ("-0.089", "must not be negative"),
        ("nan", "'nan' is not a finite number"),
        ("1e999", "'1e999' is not a finite number"),
        ("", "0 numbers, but must be 1"),
        ("1 2", "2 numbers, but must be 1"),
        ("6_921", "not a finite number"),
    ],
)
def test_a_mass_that_is_none_is_refused_with_its_line(tmp_path, value, said):
    path, line = changed(tmp_path, MASS, f'value="{value}"')
    with pytest.raises(FileProblem) as raised:
        check_numbers(path)
    assert f"line {line}: <mass" in str(raised.value)
    assert "of link 'base'" in str(raised.value)
    assert said in str(raised.value)


@pytest.mark.parametrize("pattern", [r'xyz="[^"]*"', r'ixx="[^"]*"', r'lower="[^"]*"', r'effort="[^"]*"'])
def test_other_numbers_are_looked_at_as_well(tmp_path, pattern):
    found = re.search(pattern, TEXT)
    assert found
    name = found[0].partition("=")[0]
    path, line = changed(tmp_path, found[0], f'{name}="0,1 0 0"')
    with pytest.raises(FileProblem, match=f"line {line}: .*{name}=.*not a finite number"):
        check_numbers(path)


def test_numbers_of_other_elements_and_no_xml_are_left_alone(tmp_path):
    path = tmp_path / "a.urdf"
    path.write_text('<robot name="r"><gazebo><mass value="${m}"/></gazebo></robot>')
    check_numbers(path)
    path.write_text("<robot")
    check_numbers(path)
    check_numbers(tmp_path / "missing.urdf")


@pytest.mark.parametrize("value", ["6,921", "${trunk_mass}", "-0.089"])
def test_commands_end_with_one_sentence_and_code_2(tmp_path, value):
    path, line = changed(tmp_path, MASS, f'value="{value}"')
    robot = (Path("symdyn/robot/robots/go2.toml")).read_text(encoding="utf-8")
    robot = re.sub('name = ".*"', 'name = "changed"', robot, count=1)
    robot = re.sub('urdf = ".*"', 'urdf = "changed.urdf"', robot)
    (tmp_path / "changed.toml").write_text(robot, encoding="utf-8")
    for arguments in (
        ("symmetry", "--urdf", path),
        ("symmetry", "--robot", tmp_path / "changed.toml"),
        ("train", "--preset", "smoke", "--robot", tmp_path / "changed.toml", "--out", tmp_path / "run"),
        ("robot-sim", "--robot", tmp_path / "changed.toml", "--duration", "0.1"),
    ):
        done = symdyn(*arguments)
        assert done.returncode == 2, arguments
        assert f"line {line}: <mass" in done.stderr, arguments
    assert not (tmp_path / "run").exists()
