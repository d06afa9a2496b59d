"""The report of sessions whose truth is known: what it says, what it shows, what it leaves out."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_rgba

from hardware.control.faults import FAULTS
from hardware.control.settings import Settings
from hardware.estimation.kinematics import LegKinematics
from hardware.estimation.settings import ContactConfig
from hardware.logs.contents import read_contents
from hardware.logs.observed import observe, summarise
from hardware.logs.report import Analysis, analyse, write
from hardware.running.session import Session
from hardware.wire.channels import JOINTS
from hardware.wire.event_log import LogWriter
from hardware.wire.messages import leg_control_data_lcmt, state_estimator_lcmt
from hardware.wire.sdk_order import JOINTS_TO_SDK, LEGS_TO_SDK
from symdyn.analysis.recording import Recording
from symdyn.errors import FileProblem
from symdyn.gait.library import LIBRARY
from symdyn.robot.legs import LEGS
from tests.hardware.logs.log_sessions import BEGIN, write_session
from tests.robots import GO2
from tests.symdyn.analysis.synthetic import recording

DT = 0.005


def session(*gaits: str, seconds: float = 3.0, speed: float = 0.8) -> tuple[Recording, list[str]]:
    """Gaits one after another, and the gait of every sample."""
    parts = [recording(LIBRARY[gait], speed, seconds=seconds, dt=DT) for gait in gaits]
    arrays = [name for name, value in vars(parts[0]).items() if isinstance(value, np.ndarray)]
    made = replace(parts[0], **{name: np.concatenate([getattr(part, name) for part in parts]) for name in arrays})
    return made, [gait for gait in gaits for _ in range(round(seconds / DT))]


def analysed(path: Path, settle_s: float = 1.0) -> Analysis:
    return analyse(read_contents(path), GO2, settle_s, ContactConfig())


@pytest.fixture(scope="module")
def found(tmp_path_factory) -> tuple[Analysis, str, Path]:
    folder = tmp_path_factory.mktemp("report")
    made, gaits = session("trot", "bound")
    n = len(gaits)
    states = ["run"] * (n - 40) + ["damp"] * 40
    faults = [""] * (n - 40) + ["tilt: 0.71 rad"] * 40
    path = write_session(
        folder / "run.lcmlog", made, gaits, states, faults, lost={100, 101, *range(n - 30, n - 20)}, truth=made
    )
    analysis = analysed(path)
    return analysis, write(analysis, folder / "out").read_text(), folder / "out"


class TestReport:
    def test_a_row_a_segment(self, found):
        analysis, text, _ = found
        assert [(s["gait"], s["steady"]) for s in analysis.metrics["segments"]] == [("trot", True), ("bound", True)]
        assert text.count("| trot | 0.80 |") == text.count("| bound | 0.80 |") == 2  # by the robot, and by the truth
        for segment in analysis.metrics["segments"]:
            assert segment["robot"]["gc_stance"] == pytest.approx(0.0, abs=0.003)
            assert segment["robot"]["gait_identity"] == 1.0

    def test_the_fault_with_what_to_do(self, found):
        _, text, _ = found
        assert "tilt: 0.71 rad" in text
        # once, although ticks are missing while the robot was damped
        assert text.count(FAULTS["tilt"].help) == 1

    def test_what_the_log_lacks(self, found):
        analysis, text, _ = found
        (told,) = analysis.metrics["problems"]
        assert told.startswith("2 ticks were lost")
        assert told in text

    def test_json_holds_the_same_numbers(self, found):
        analysis, _, out = found
        loaded = json.loads((out / "metrics.json").read_text())
        assert loaded["segments"][0]["robot"]["cot"] == analysis.metrics["segments"][0]["robot"]["cot"]
        used = {key for s in loaded["segments"] for view in ("robot", "truth", "estimator") for key in s[view]}
        assert used <= set(loaded["keys"])

    def test_contacts_are_drawn_by_gait_with_desired_sensed_and_true(self, found):
        figure, caption = found[0].figures["contacts.png"]
        panels = [axes for axes in figure.axes if axes.get_title()]
        assert [axes.get_title().split(",")[0] for axes in panels] == ["trot", "bound"]
        for axes in panels:
            # of every leg: hollow desired stance, solid contact, thin line of the truth
            assert len(axes.collections) == 3 * len(LEGS)
        assert "truth" in caption

    def test_velocity_is_drawn_with_command_estimate_and_truth(self, found):
        figure, _ = found[0].figures["velocity.png"]
        forward = figure.axes[0]
        lines = {line.get_label(): line for line in forward.get_lines() if not line.get_label().startswith("_")}
        assert set(lines) == {"estimated", "true", "commanded"}
        np.testing.assert_allclose(lines["commanded"].get_ydata(), 0.8)
        assert [text.get_text() for text in forward.texts] == ["trot", "bound"]

    def test_torque_limits_are_those_of_the_urdf(self, found):
        figure, _ = found[0].figures["torques.png"]
        bounds = [
            sorted({round(abs(y), 2) for line in axes.get_lines() if len(set(y2 := line.get_ydata())) == 1 for y in y2})
            for axes in figure.axes[:: len(LEGS)]
        ]
        # shared/hardware.md: hip and thigh 23.7 N m, calf 45.43 N m
        assert [23.7 in bounds[0], 23.7 in bounds[1], 45.43 in bounds[2]] == [True, True, True]

    def test_cost_of_transport_is_drawn_by_gait(self, found):
        analysis, _, _ = found
        figure, caption = analysis.figures["cot.png"]
        heights = sorted(bar.get_height() for bar in figure.axes[0].patches)
        expected = sorted(s["truth"]["cot"] for s in analysis.metrics["segments"])
        assert heights == pytest.approx(expected)
        assert "true distance" in caption


def test_a_real_robot_has_no_truth(tmp_path):
    made, gaits = session("trot")
    analysis = analysed(write_session(tmp_path / "run.lcmlog", made, gaits))
    assert "no ground truth" in analysis.figures["velocity.png"][1]
    assert "truth" not in analysis.figures["contacts.png"][1]
    assert "estimated distance" in analysis.figures["cot.png"][1]
    axes = analysis.figures["contacts.png"][0].axes[0]
    assert not any(np.allclose(c.get_facecolor(), to_rgba("black")) for c in axes.collections if len(c.get_facecolor()))


def test_treading_on_the_spot_has_no_cost_of_transport(tmp_path):
    made, gaits = session("trot", speed=0.0)
    analysis = analysed(write_session(tmp_path / "run.lcmlog", made, gaits))
    assert "cot.png" not in analysis.figures
    assert "| trot | 0.00 |" in write(analysis, tmp_path).read_text()


def test_a_session_that_never_ran(tmp_path):
    made, gaits = session("trot", seconds=1.0)
    path = write_session(tmp_path / "run.lcmlog", made, gaits, states=["stand"] * len(gaits))
    analysis = analysed(path)
    assert analysis.metrics["problems"] == [
        "The policy never ran: there is no gait to judge. Press R1 twice to get from Passive to Run."
    ]
    assert set(analysis.figures) == {"torques.png", "timing.png"}
    assert "## Gaits" not in write(analysis, tmp_path).read_text()


def test_a_deployer_that_falls_silent_is_told(tmp_path):
    made, gaits = session("trot")
    path = write_session(tmp_path / "run.lcmlog", made, gaits, lost=range(400, 600))
    told = " ".join(analysed(path).metrics["problems"])
    assert "last tick is 1.0 s before the end" in told


def test_settling_time_left_out_or_not(tmp_path):
    made, gaits = session("bound", seconds=4.0)
    early = made.time < 0.8
    spoilt = replace(made, contact=np.where(early[:, None], True, made.contact))
    path = write_session(tmp_path / "run.lcmlog", spoilt, gaits)
    after, all_of_it = (analysed(path, s).metrics["segments"][0]["robot"]["gc_stance"] for s in (1.0, 0.0))
    assert after == 0.0
    assert all_of_it > 0.05


class TestObserved:
    def still(self, path: Path, loaded: tuple[str, ...]) -> Path:
        """A log of the bridge alone: a robot that stands on some legs and does nothing."""
        joints, imu = leg_control_data_lcmt(), state_estimator_lcmt()
        joints.q = GO2.default_joint_pos[list(JOINTS_TO_SDK)].tolist()
        joints.tau_est = [5.0] * 12
        imu.quat, imu.aBody = [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 9.81]
        imu.contact_estimate = np.array([60.0 * (leg in loaded) for leg in LEGS])[list(LEGS_TO_SDK)].tolist()
        with LogWriter(path, overwrite=True) as log:
            for k in range(1000):
                log.append("state_estimator_data", imu.encode(), BEGIN + 0.002 * k)
                log.append(JOINTS, joints.encode(), BEGIN + 0.002 * k)
        return path

    def test_a_robot_that_stands_still(self, tmp_path):
        kinematics = LegKinematics(GO2)
        found = observe(read_contents(self.still(tmp_path / "a.lcmlog", ("LH", "RF"))), kinematics, ContactConfig())
        assert found is not None
        assert len(found.time) == pytest.approx(400, abs=1)
        assert found.contact[:, [LEGS.index("LH"), LEGS.index("RF")]].all()
        assert not found.contact[:, [LEGS.index("LF"), LEGS.index("RH")]].any()
        assert np.abs(found.velocity_h).max() < 0.01
        told = summarise(found, kinematics.mass)
        assert told["moving_s"] == 0.0
        assert np.isnan([told["speed"], told["cot"], *told["stride_s"].values(), *told["duty"].values()]).all()

    def test_the_threshold_is_a_setting(self, tmp_path):
        log = read_contents(self.still(tmp_path / "a.lcmlog", LEGS))
        high = ContactConfig(thresholds=(100.0, 10.0, 10.0, 10.0))
        found = observe(log, LegKinematics(GO2), high)
        assert found is not None
        assert found.contact.mean(axis=0).tolist() == [0.0, 1.0, 1.0, 1.0]

    def test_nothing_to_estimate_from(self, tmp_path):
        log = read_contents(self.still(tmp_path / "a.lcmlog", LEGS))
        for lacking in (replace(log, imu={}), replace(log, joints={}), replace(log, imu={}, joints={})):
            assert observe(lacking, LegKinematics(GO2), ContactConfig()) is None


def test_a_log_of_another_robot_is_refused(tmp_path):
    log = read_contents(write_session(tmp_path / "run.lcmlog", *session("trot", seconds=1.0)))
    its = Session("policy.onnx", "", Settings(), False, 2, "unknown", robot="solo12")
    with pytest.raises(FileProblem, match=r"run\.lcmlog: is a log of the robot 'solo12', not of 'go2'\."):
        analyse(replace(log, session=its), GO2, 1.0, ContactConfig())


def test_the_head_of_a_log_from_before_names_no_robot_and_is_of_the_go2():
    message = Session("policy.onnx", "", Settings(), False, 2, "unknown", robot="solo12").message()
    assert Session.of(message, "log").robot == "solo12"
    head = json.loads(message.json)
    del head["robot"]
    message.json = json.dumps(head)
    assert Session.of(message, "log").robot == "go2"
