"""Contacts and ground forces against the simulated robot's truth; calibration against forces whose make-up is known."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hardware.cli import calibrate_feet
from hardware.cli.arguments.calibrate_feet import parse
from hardware.estimation.calibration import LEAST_SAMPLES, FootCalibration, NoTwoModes, calibrate, otsu, read_raw
from hardware.estimation.contact import FootContact
from hardware.estimation.ground_force import GroundForce
from hardware.estimation.kinematics import LegKinematics
from hardware.estimation.settings import ContactConfig
from hardware.robot_sim.sensors import NO_NOISE
from hardware.robot_sim.settings import PERIOD
from hardware.wire.channels import IMU, TRUTH, encode
from hardware.wire.event_log import LogWriter
from hardware.wire.messages import state_estimator_lcmt
from hardware.wire.readings import Imu, Joints
from symdyn.errors import FileProblem, InvalidValue
from symdyn.gait.timing import GRAVITY
from symdyn.robot.legs import LEGS
from tests.hardware.estimation.rolling_walk import Motion, legs, walk
from tests.hardware.robot_sim.robot_sim_runs import TrueSample, driven
from tests.hardware.robot_sim.simulated import go2
from tests.robots import GO2

DT = 0.005
STANDING = walk(Motion(sway=(0.0, 0.0, 0.0), tilt=(0.0, 0.0, 0.0)), DT, DT)[0]


def showing(*raw: float) -> Imu:
    return Imu(*(STANDING.imu.quat_w, np.zeros(3), np.array([0.0, 0.0, GRAVITY])), np.array(raw))


def test_hysteresis_foot_by_foot() -> None:
    contact = FootContact(ContactConfig(thresholds=(10.0, 20.0, 30.0, 40.0), release=0.5), legs())
    steps = [
        ((9.0, 9.0, 9.0, 9.0), (False, False, False, False)),
        ((11.0, 11.0, 31.0, 39.0), (True, False, True, False)),
        ((6.0, 21.0, 16.0, 41.0), (True, True, True, True)),
        ((4.0, 11.0, 14.0, 21.0), (False, True, False, True)),
        ((9.0, 9.0, 29.0, 19.0), (False, False, False, False)),
    ]
    for raw, expected in steps:
        assert tuple(contact.update(showing(*raw), STANDING.joints, DT)) == expected


def test_what_is_not_a_number_is_no_load() -> None:
    contact = FootContact(ContactConfig(), legs())
    assert contact.update(showing(100.0, 100.0, 100.0, 100.0), STANDING.joints, DT).all()
    assert not contact.update(showing(math.nan, math.nan, -math.inf, 0.0), STANDING.joints, DT).any()


@pytest.mark.parametrize(
    ("setting", "named"),
    [
        ({"thresholds": (30.0, 30.0, 0.0, 30.0)}, "contact.thresholds"),
        ({"thresholds": (30.0, 30.0, 30.0)}, "LH, LF, RF, RH"),
        ({"thresholds": (30.0, 30.0, math.nan, 30.0)}, "contact.thresholds"),
        ({"release": 1.1}, "contact.release"),
        ({"release": 0.0}, "contact.release"),
        ({"vertical_force": math.inf}, "contact.vertical_force"),
        ({"bandwidth": -1.0}, "contact.bandwidth"),
        ({"source": "sight"}, "'auto', 'force' or 'torque'"),
    ],
)
def test_settings_that_are_none(setting: dict[str, Any], named: str) -> None:
    with pytest.raises(InvalidValue, match=named):
        ContactConfig(**setting)


def test_forces_on_a_standing_robot_are_its_weight() -> None:
    robot, observer = go2(start="standing", noise=NO_NOISE), GroundForce(legs(), bandwidth=150.0)
    for _ in range(250):
        robot.step()
        force = observer.update(PERIOD, Imu.of(robot.imu()), Joints.of(robot.joints()))
    assert force.sum() == pytest.approx(legs().mass * GRAVITY, rel=0.01)


def observed(samples: tuple[TrueSample, ...], kinematics: LegKinematics) -> np.ndarray:
    observer = GroundForce(kinematics, ContactConfig().bandwidth)
    return np.array([observer.update(s.dt, s.imu, s.joints) for s in samples])


@pytest.mark.parametrize("gait", ["trot", "rotary_gallop"])
def test_forces_on_a_running_robot(gait: str) -> None:
    samples = driven(gait, (0.8, 0.0, 0.0), seed=0).samples
    true = np.array([s.vertical_force for s in samples])
    found = observed(samples, legs())
    assert np.corrcoef(found.ravel(), true.ravel())[0, 1] > 0.9
    swing = ~np.array([s.contact for s in samples])
    without_rotors = LegKinematics(GO2)
    without_rotors.model.armature = np.zeros(12)
    # in the air nothing pushes, which takes the rotors to see
    rms, naive = (np.sqrt((f[swing] ** 2).mean()) for f in (found, observed(samples, without_rotors)))
    assert rms < 0.2 * true[~swing].mean() < naive


@pytest.mark.parametrize("gait", ["trot", "bound", "rotary_gallop"])
@pytest.mark.parametrize("source", ["force", "torque"])
def test_contacts_of_the_simulated_robot(gait: str, source: str) -> None:
    run = driven(gait, (0.8, 0.0, 0.0), seed=0)
    contact = FootContact(ContactConfig(source=source), legs())
    found = np.array([contact.update(s.imu, s.joints, s.dt) for s in run.samples])
    true = np.array([s.contact for s in run.samples])
    assert 0.3 < true[run.running].mean() < 0.7
    assert (found == true)[run.running].mean() > 0.95


def test_where_feet_show_nothing_the_torques_tell_and_where_they_show_something_they_do() -> None:
    run = driven("trot", (0.8, 0.0, 0.0), seed=0).samples[:400]
    numb = [replace(s.imu, foot_force=np.zeros(4)) for s in run]
    for imus, source in (([s.imu for s in run], "force"), (numb, "torque")):
        contacts = [FootContact(ContactConfig(source=its), legs()) for its in ("auto", source)]
        for imu, s in zip(imus, run, strict=True):
            auto, told = (contact.update(imu, s.joints, s.dt) for contact in contacts)
            np.testing.assert_array_equal(auto, told)
        assert contacts[0].source == source


def test_a_foot_that_shows_something_once_has_a_sensor() -> None:
    contact = FootContact(ContactConfig(), legs())
    assert contact.source == "torque"
    contact.update(showing(0, 0, 0, 0), STANDING.joints, DT)
    assert contact.source == "torque"
    for raw in (3.0, 0.0):
        contact.update(showing(0, raw, 0, 0), STANDING.joints, DT)
        assert contact.source == "force"


def test_forces_begin_anew_after_bad_input() -> None:
    observer, joints = GroundForce(legs(), bandwidth=150.0), STANDING.joints
    pushing = Joints(joints.pos, joints.vel, np.full(12, 5.0))
    first = [observer.update(DT, showing(0, 0, 0, 0), pushing) for _ in range(5)]
    assert np.abs(first[-1]).max() > 1.0
    for bad in (
        Joints(joints.pos * math.nan, joints.vel, joints.torque),
        Joints(joints.pos, joints.vel, joints.torque + math.inf),
    ):
        np.testing.assert_array_equal(observer.update(DT, showing(0, 0, 0, 0), bad), np.zeros(4))
        again = [observer.update(DT, showing(0, 0, 0, 0), pushing) for _ in range(5)]
        np.testing.assert_array_equal(again, first)
        assert not observer.update(0.0, showing(0, 0, 0, 0), pushing).any()


@given(st.lists(st.floats(-3.0, 3.0), min_size=12, max_size=12), st.sampled_from([0.0, 1e-9]))
def test_forces_are_finite_in_any_pose(pose: list[float], calf: float) -> None:
    joint_pos = np.array(pose)
    joint_pos[2::6] = calf  # two straight legs, or all but straight
    observer, joints = GroundForce(legs(), bandwidth=150.0), Joints(joint_pos, np.ones(12), np.full(12, 10.0))
    for _ in range(3):
        force = observer.update(DT, showing(0, 0, 0, 0), joints)
    assert np.isfinite(force).all()


def heaps(swing: float, spread: float, stance: float, share: float, n: int = 4000, seed: int = 0) -> np.ndarray:
    """(n, 4) whole numbers: a foot's zero with noise, or loads that come and go as half a sine."""
    rng = np.random.default_rng(seed)
    light = swing + spread * rng.standard_normal((n, 4))
    # the median of half a sine is its peak by the root of 2
    heavy = swing + (stance - swing) * np.sqrt(2.0) * np.sin(np.pi * rng.random((n, 4))) * rng.uniform(0.8, 1.2, (n, 4))
    return np.rint(np.where(rng.random((n, 4)) < share, heavy, light))


@given(
    swing=st.floats(-20.0, 20.0),
    spread=st.floats(0.0, 4.0),
    rise=st.floats(100.0, 300.0),
    share=st.floats(0.2, 0.8),
    standing=st.sampled_from([0.0, 0.5]),
)
def test_threshold_lies_above_swing_and_below_stance(
    swing: float, spread: float, rise: float, share: float, standing: float
) -> None:
    """Also if the robot stood for some of the time, each foot under about half of its load in a run."""
    raw = heaps(swing, spread, swing + rise, share)
    stood = round(standing * len(raw))
    raw[:stood] = np.rint(swing + rise * np.random.default_rng(1).normal(0.5, 0.05, (stood, 4)))
    for foot in calibrate(raw, "heaps").feet:
        assert foot.swing == pytest.approx(swing, abs=0.6 + spread)
        assert swing + 3.0 * spread < foot.threshold < max(swing + 0.2 * rise, (swing + 8.0 * spread + 3.0) / 0.7, 5.1)
        assert foot.stance_share == pytest.approx(standing + (1.0 - standing) * share, abs=0.1)


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("standing", 80.0 + 5.0 * np.random.default_rng(0).standard_normal(4000)),
        ("in the air", 5.0 + 2.0 * np.random.default_rng(0).standard_normal(4000)),
        ("no rhyme or reason", np.random.default_rng(0).uniform(0.0, 100.0, 4000)),
        ("mostly light", np.random.default_rng(0).exponential(30.0, 4000)),
        ("shifting weight", np.repeat([40.0, 85.0], 2000) + np.random.default_rng(0).standard_normal(4000)),
        ("one step in 10 s", np.where(np.arange(4000) < 40, 150.0, 5.0)),
        ("dead", np.zeros(4000)),
    ],
)
def test_forces_that_are_no_two_heaps(name: str, values: np.ndarray) -> None:
    raw = heaps(5.0, 2.0, 150.0, 0.5)
    raw[:, LEGS.index("RF")] = values
    advice = "contact.source torque" if name == "dead" else "Record the robot trotting"
    with pytest.raises(NoTwoModes, match=f"RF.*{advice}"):
        calibrate(raw, name)


def test_too_few_forces_or_such_as_are_none() -> None:
    raw = heaps(5.0, 2.0, 150.0, 0.5)
    with pytest.raises(NoTwoModes, match=f"{LEAST_SAMPLES} are needed"):
        calibrate(raw[: LEAST_SAMPLES - 1], "few")
    raw[7, 2] = math.nan
    with pytest.raises(NoTwoModes, match="not finite"):
        calibrate(raw, "spoilt")


@given(st.lists(st.integers(-5, 30), min_size=2, max_size=40).filter(lambda values: len(set(values)) > 1))
def test_otsu_maximises_the_variance_between(values: list[int]) -> None:
    array = np.array(values, dtype=float)

    def between(cut: float) -> float:
        low, high = array[array <= cut], array[array > cut]
        return len(low) * len(high) * (low.mean() - high.mean()) ** 2

    best = max(between(cut) for cut in sorted(set(values))[:-1])
    assert between(otsu(array)) == pytest.approx(best, rel=1e-9)


def test_calibrated_contacts_are_at_least_as_good() -> None:
    run = driven("rotary_gallop", (0.8, 0.0, 0.0), seed=0)
    calibration = calibrate(np.array([s.imu.foot_force for s in run.samples]), "run")
    agree = []
    for config in (ContactConfig(), ContactConfig(thresholds=calibration.thresholds)):
        contact = FootContact(config, legs())
        agree.append(np.mean([contact.update(s.imu, s.joints, s.dt) == s.contact for s in run.samples]))
    assert agree[1] > agree[0] - 0.002
    assert agree[1] > 0.97


def test_file_round_trip(tmp_path: Path) -> None:
    calibration = calibrate(heaps(5.0, 2.0, 150.0, 0.5), "heaps")
    calibration.save(tmp_path / "feet.json")
    assert FootCalibration.load(tmp_path / "feet.json") == calibration
    ContactConfig(thresholds=calibration.thresholds)


@pytest.mark.parametrize(
    ("spoil", "named"),
    [
        (lambda data: data.update(format_version=2), "format_version"),
        (lambda data: data["feet"].pop("LF"), "LH, LF, RF, RH"),
        (lambda data: data["feet"]["LF"].pop("threshold"), "foot LF"),
        (lambda data: data["feet"]["LF"].update(threshold="high"), "'high' for threshold of foot LF"),
        (lambda data: data["feet"]["LF"].update(threshold=-3.0), "threshold -3 for foot LF"),
        (lambda data: data["feet"]["LF"].update(threshold=True), "True for threshold of foot LF"),
        (lambda data: data.update(samples="many"), "number of samples"),
        (lambda data: data.pop("source"), "source"),
    ],
)
def test_files_that_are_no_calibration(tmp_path: Path, spoil: Any, named: str) -> None:
    path = tmp_path / "feet.json"
    calibrate(heaps(5.0, 2.0, 150.0, 0.5), "heaps").save(path)
    data = json.loads(path.read_text())
    spoil(data)
    path.write_text(json.dumps(data))
    with pytest.raises(FileProblem, match=named):
        FootCalibration.load(path)


def test_missing_file_and_no_json(tmp_path: Path) -> None:
    with pytest.raises(FileProblem, match="cannot be read"):
        FootCalibration.load(tmp_path / "none.json")
    (tmp_path / "feet.json").write_text("[1, 2")
    with pytest.raises(FileProblem, match="not valid JSON"):
        FootCalibration.load(tmp_path / "feet.json")


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A trot as the bridge tells it, after a second of the zeros that it sends before it has data from the robot."""
    path = tmp_path_factory.mktemp("log") / "trot.lcmlog"
    robot_says = [state_estimator_lcmt() for _ in range(200)]
    for sample in driven("trot", (0.8, 0.0, 0.0), seed=0).samples:
        message = state_estimator_lcmt()
        message.quat = sample.imu.quat_w.tolist()
        # the wire's order is FR, FL, RR, RL
        by_leg = dict(zip(LEGS, sample.imu.foot_force.tolist(), strict=True))
        message.contact_estimate = [by_leg[leg] for leg in ("RF", "LF", "RH", "LH")]
        robot_says.append(message)
    with LogWriter(path) as writer:
        for k, message in enumerate(robot_says):
            writer.append(IMU, encode(IMU, message), k * DT)
            writer.append(TRUTH, encode(TRUTH, state_estimator_lcmt()), k * DT)
        writer.append(IMU, b"damaged", len(robot_says) * DT)
    return path


def test_raw_forces_of_a_log(log: Path) -> None:
    seen = []
    raw = read_raw(log, lambda done, total: seen.append(done / total))
    samples = driven("trot", (0.8, 0.0, 0.0), seed=0).samples
    np.testing.assert_array_equal(raw, [s.imu.foot_force for s in samples])
    assert seen == sorted(seen) and seen[0] >= 0.0 and seen[-1] <= 1.0


def test_a_log_of_something_else(tmp_path: Path) -> None:
    with LogWriter(tmp_path / "other.lcmlog") as writer:
        writer.append(TRUTH, encode(TRUTH, state_estimator_lcmt()), 0.0)
        writer.append(IMU, encode(IMU, state_estimator_lcmt()), 0.0)  # all zeros
    with pytest.raises(FileProblem, match="no message of a robot on channel state_estimator_data"):
        read_raw(tmp_path / "other.lcmlog")


def test_command(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, figure = tmp_path / "feet.json", tmp_path / "feet.png"
    assert calibrate_feet.run(parse([str(log), "--out", str(out), "--figure", str(figure)])) == 0
    calibration = FootCalibration.load(out)
    printed = capsys.readouterr().out
    assert f"symdyn deploy POLICY.onnx --feet {out}" in printed
    assert figure.read_bytes().startswith(b"\x89PNG")
    assert calibration.source == str(log)
