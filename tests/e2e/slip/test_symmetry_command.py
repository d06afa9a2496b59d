"""``symdyn symmetry`` as a user runs it: what it says, what it writes, and every bad input."""

from __future__ import annotations

import contextlib
import io
import json
import subprocess
import sys
from pathlib import Path

import pytest

from slip.robot.known import KNOWN_ROBOTS
from symdyn.robot.descriptions import robots_folder, urdf_path
from symdyn_cli.main import main
from tests.robots import GO2

Done = subprocess.CompletedProcess[str]
GO2_FEET = GO2.foot_links


def symmetry(*arguments: object, cwd: Path) -> Done:
    out, err = io.StringIO(), io.StringIO()
    with contextlib.chdir(cwd), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = main(["symmetry", *map(str, arguments)])
        except SystemExit as stop:  # the parser's own way out
            code = stop.code
    return Done(list(map(str, arguments)), int(code or 0), " ".join(out.getvalue().split()), err.getvalue())


def test_in_a_process_of_its_own(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "symdyn", "symmetry", "--out", "go2.json"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    said = " ".join(done.stdout.split())
    assert "As a mechanism go2 has K4 = {e, g_s, g_t, g_r}; as a body it has C2 = {e, g_s}." in said
    assert "g_t misses the mass matrix by 2.3e-02 (allowed 0.01) and joint limits by 3.56 rad (allowed 0.01)." in said
    assert "Permutations and signs are those of symdyn.gait.symmetry" in said
    for numbers in ("g_s RH RF LF LH -++", "k 5.084", "ks 43.44", "J 0.2179", "l 1.0341", "lb 0.4972", "2074 N/m"):
        assert numbers in said
    assert max(map(len, done.stdout.splitlines())) <= 80
    assert [path.name for path in tmp_path.iterdir()] == ["go2.json"]


def test_the_file_holds_what_was_found(tmp_path: Path) -> None:
    assert symmetry("--robot", "solo12", "--out", "new/solo.json", cwd=tmp_path).returncode == 0
    found = json.loads((tmp_path / "new" / "solo.json").read_text())
    assert (found["format_version"], found["robot"], found["urdf"]) == (1, "solo12", "solo12.urdf")
    assert found["feet"] == {"LH": "HL_FOOT", "LF": "FL_FOOT", "RF": "FR_FOOT", "RH": "HR_FOOT"}
    assert found["body_group"] == found["mechanism_group"] == ["e", "g_s", "g_t", "g_r"]
    assert [element["name"] for element in found["elements"]] == ["e", "g_s", "g_t", "g_r"]
    assert found["elements"][1]["leg_index"] == [3, 2, 1, 0]
    assert found["body"]["mass"] == pytest.approx(2.5, abs=0.001)
    assert found["slip_parameters"]["hind_distance"] == pytest.approx(0.5, abs=0.001)


@pytest.mark.parametrize("name", sorted(KNOWN_ROBOTS))
def test_every_known_robot(tmp_path: Path, name: str) -> None:
    done = symmetry("--robot", name, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "as a spring-loaded model" in done.stdout
    assert f"{name} has" in done.stdout


def test_any_urdf_with_and_without_feet_named(tmp_path: Path) -> None:
    (tmp_path / "mine.urdf").write_text(urdf_path(GO2).read_text())
    alone = symmetry("--urdf", "mine.urdf", cwd=tmp_path)
    assert alone.returncode == 0, alone.stderr
    named = symmetry("--urdf", "mine.urdf", "--feet", *reversed(GO2_FEET), cwd=tmp_path)
    assert named.stdout == alone.stdout
    assert "mine has K4" in named.stdout


def test_a_robot_without_a_pose_of_standing_has_a_group_and_no_springs(tmp_path: Path) -> None:
    urdf = robots_folder() / "solo_description/robots/solo12.urdf"
    done = symmetry("--urdf", urdf, "--out", "solo.json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "No spring-loaded model" in done.stdout
    assert "give a pose with bent knees" in done.stdout
    found = json.loads((tmp_path / "solo.json").read_text())
    assert found["body"] is found["slip_parameters"] is None
    srdf = robots_folder() / "solo_description/srdf/solo.srdf"
    assert "ks" in symmetry("--urdf", urdf, "--srdf", srdf, cwd=tmp_path).stdout


def test_given_gains_and_tolerances(tmp_path: Path) -> None:
    done = symmetry("--kp", "60", "--kd", "1", "--tolerances.mass", "0.1", "--tolerances.limits", "4", cwd=tmp_path)
    assert "4148 N/m" in done.stdout
    assert "kp 60 N m/rad, kd 1 N m s/rad (given)" in done.stdout
    assert "go2 has K4 = {e, g_s, g_t, g_r}, as a mechanism and as a body." in done.stdout


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--robot", "go3"), ("Unknown robot 'go3'", "Did you mean 'go2'", "anymal_c")),
        (("--urdf", "nowhere.urdf"), ("nowhere.urdf", "No such file")),
        (("--urdf", "."), ("Is a directory",)),
        (("--urdf", "{robots}/panda_description/urdf/panda.urdf"), ("four legs", "panda_leftfinger")),
        (("--urdf", "{robots}/b1_description/urdf/b1-z1.urdf"), ("four legs", "gripperMover", "Name four feet")),
        (("--urdf", "{robots}/go2_description/urdf/go2.urdf", "--feet", "toe", *GO2_FEET[1:]), ("Unknown foot 'toe'",)),
        (("--urdf", "{robots}/go2_description/urdf/go2.urdf", "--feet", "FL_foot"), ("Four different feet", "FL_foot")),
        (("--urdf", "{robots}/go2_description/urdf/go2.urdf", "--srdf", "no.srdf"), ("no.srdf", "No such file")),
        (("--urdf", "{robots}/go2_description/urdf/go2.urdf", "--robot", "go2"), ("--robot", "--urdf")),
        (("--feet", *GO2_FEET), ("--feet", "--urdf")),
        (("--srdf", "x.srdf"), ("--srdf", "--urdf")),
        (("--kp", "30"), ("--kp", "together")),
        (("--kd", "1"), ("--kd", "together")),
        (("--kp", "-1", "--kd", "1"), ("kp is -1.0",)),
        (("--kp", "nan", "--kd", "1"), ("kp is nan",)),
        (("--kp", "many", "--kd", "1"), ("many",)),
        (("--tolerances.mass", "-1"), ("tolerances.mass is -1.0", ">= 0")),
        (("--tolerances.limits", "nan"), ("tolerances.limits is nan",)),
        (("--out", "/proc/nowhere/x.json"), ("/proc/nowhere/x.json", "cannot be written")),
        (("--out", "/dev/full/x.json"), ("/dev/full/x.json", "cannot be written")),
        (("--legs", "5"), ("legs",)),
    ],
)
def test_refused_in_one_sentence_and_nothing_written(tmp_path: Path, arguments: tuple, said: tuple) -> None:
    done = symmetry(*(str(word).format(robots=robots_folder()) for word in arguments), cwd=tmp_path)
    assert done.returncode == 2, (done.stdout, done.stderr)
    for words in said:
        assert words in " ".join(done.stderr.split()), done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_help_explains_the_options(tmp_path: Path) -> None:
    done = symmetry("--help", cwd=tmp_path)
    assert done.returncode == 0
    for option in ("--robot", "--urdf", "--feet", "--srdf", "--out"):
        assert option in done.stdout
    assert all(name in done.stdout for name in KNOWN_ROBOTS if name != "anymal")
