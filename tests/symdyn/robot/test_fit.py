"""A machine's file: what comes back from disk, what it says of a robot's spread, and what is refused in words."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from symdyn.errors import FileProblem, InvalidValue
from symdyn.robot.fit import QUANTITIES, UNITS, Fit, JointFit, Measured, load_fit, save_fit
from symdyn.robot.legs import JOINTS
from tests.robots import GO2


def machine(seed: int = 0) -> Fit:
    rng = np.random.default_rng(seed)

    def near(value: float) -> Measured:
        half = 0.1 * value * rng.random()
        return Measured(value, value - half, value + half, bool(rng.random() < 0.8))

    middle = dict(zip(QUANTITIES, (0.01, 0.9, 1.1, 0.95, 0.2, 0.05, 0.006, 0.02), strict=True))
    joints = [JointFit(joint, **{name: near(value) for name, value in middle.items()}) for joint in JOINTS]
    return Fit("go2", 'a "log" \\ of mine.lcmlog', "ab" * 32, "hung", "unknown", tuple(joints))


def test_from_disk_comes_what_was_written_to_six_digits(tmp_path: Path) -> None:
    written = machine()
    save_fit(written, tmp_path / "fit.toml")
    read = load_fit(tmp_path / "fit.toml", GO2)
    assert replace(read, joints=written.joints) == written
    for mine, its in zip(written.joints, read.joints, strict=True):
        for name in QUANTITIES:
            a, b = getattr(mine, name), getattr(its, name)
            assert [b.value, b.low, b.high] == pytest.approx([a.value, a.low, a.high], rel=1e-5)
            assert a.determined == b.determined


def test_every_quantity_has_a_unit() -> None:
    assert set(UNITS) == set(QUANTITIES)


def test_a_range_reaches_over_the_intervals_of_the_joints_that_are_determined_and_no_others() -> None:
    fit = machine()
    known = [joint.kp for joint in fit.joints if joint.kp.determined]
    assert 0 < len(known) < len(JOINTS)
    assert fit.range("kp") == (min(m.low for m in known), max(m.high for m in known))
    unknown = tuple(replace(joint, kp=replace(joint.kp, determined=False)) for joint in fit.joints)
    assert replace(fit, joints=unknown).range("kp") is None


def test_the_fit_of_another_robot_is_refused_by_both_names(tmp_path: Path) -> None:
    save_fit(replace(machine(), robot="b1"), tmp_path / "fit.toml")
    with pytest.raises(FileProblem, match=r"fit\.toml: is the fit of a b1, not of a go2"):
        load_fit(tmp_path / "fit.toml", GO2)


@pytest.mark.parametrize(
    ("was", "becomes", "said"),
    [
        ('joint = "LH_hip"', 'joint = "LH_knee"', "LH_knee"),
        ("strength = {value", "power = {value", "unknown settings: joints\\[0\\].power"),
        (", determined = ", ", known = ", "unknown"),
        ("[[joints]]", "[[joints]", "not valid TOML"),
        ("value = 0.01,", "value = 0.2,", "rising order"),
    ],
)
def test_a_file_that_is_no_fit_is_refused_with_the_place(tmp_path: Path, was: str, becomes: str, said: str) -> None:
    path = tmp_path / "fit.toml"
    save_fit(machine(), path)
    text = path.read_text()
    assert was in text
    path.write_text(text.replace(was, becomes, 1))
    with pytest.raises(FileProblem, match=said):
        load_fit(path)
    with pytest.raises(FileProblem, match="cannot be read"):
        load_fit(tmp_path / "none.toml")


def test_numbers_that_no_joint_has_are_refused() -> None:
    joint = machine().joints[0]
    for name, value in (("delay", 0.3), ("delay", -0.001), ("strength", 0.0), ("kd", -0.1), ("offset", 2.0)):
        with pytest.raises(InvalidValue, match=f"{name} of LH_hip"):
            replace(joint, **{name: Measured(value, value, value)})
    with pytest.raises(InvalidValue, match="rising order"):
        Measured(1.0, 1.1, 1.2)
    with pytest.raises(InvalidValue, match="in this order"):
        replace(machine(), joints=machine().joints[::-1])
