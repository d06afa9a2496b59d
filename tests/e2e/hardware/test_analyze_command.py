"""symdyn analyze and symdyn replay as a user runs them, on the log of a simulated robot that stands up and trots."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import lcm
import numpy as np
import pytest
from matplotlib.image import imread

from hardware.estimation.kinematics import LegKinematics
from hardware.estimation.settings import ContactConfig
from hardware.logs.contents import read_contents
from hardware.logs.observed import observe
from hardware.wire.channels import IMU, JOINTS, SESSION, TARGETS, TICK, TRUTH
from hardware.wire.event_log import LogReader
from rl.pretrained import policy_path
from tests.e2e.command_in_process import Done, symdyn
from tests.hardware.logs.log_sessions import lockstep_session
from tests.robots import GO2
from tests.symdyn.policy.policy_files import swaying

SECONDS = 11.0
"""s; the person has the robot trot at 0.8 m/s after eight of them."""


@pytest.fixture(scope="module")
def log(tmp_path_factory) -> Path:
    return lockstep_session(tmp_path_factory.mktemp("session") / "run.lcmlog", SECONDS)


def without(log: Path, path: Path, *channels: str) -> Path:
    """The log as lcm-logger would have written it, had there not been these channels."""
    found = lcm.EventLog(str(path), "w", overwrite=True)
    for event in lcm.EventLog(str(log), "r"):
        if event.channel not in channels:
            found.write_event(event.timestamp, event.channel, event.data)
    found.close()
    return path


def changed(log: Path, path: Path, channel: str, number: int, change) -> Path:
    """The log with the message of that number on a channel put through ``change``; it ends half a second later."""
    found, count, end = lcm.EventLog(str(path), "w", overwrite=True), 0, float("inf")
    for event, read in zip(lcm.EventLog(str(log), "r"), LogReader(log), strict=False):
        data = event.data
        if read.time > end:
            break
        if event.channel == channel:
            count += 1
            if count == number:
                message = read.message()
                change(message)
                data, end = message.encode(), read.time + 0.5
        found.write_event(event.timestamp, event.channel, data)
    found.close()
    return path


def assert_refused(done: Done, *said: str) -> None:
    assert done.returncode == 2, done.stdout + done.stderr
    assert done.stderr.startswith("symdyn: error: ")
    assert done.stderr.count("\n") == 1
    for text in said:
        assert text in done.stderr


@pytest.fixture(scope="module")
def done(log, tmp_path_factory) -> tuple[Done, Path]:
    folder = tmp_path_factory.mktemp("analyze")
    return symdyn("analyze", log, "--out", "new/run", cwd=folder), folder / "new" / "run"


@pytest.fixture
def metrics(done) -> dict:
    return json.loads((done[1] / "metrics.json").read_text())


class TestAnalyze:
    def test_writes_report_metrics_and_figures_and_says_what_to_open(self, done):
        said, out = done
        assert said.returncode == 0, said.stderr
        assert said.stderr == ""
        figures = ["contacts.png", "cot.png", "timing.png", "torques.png", "velocity.png"]
        assert sorted(path.name for path in out.iterdir()) == sorted([*figures, "metrics.json", "report.md"])
        report = (out / "report.md").read_text()
        for name in figures:
            assert f"]({name})" in report
            picture = imread(out / name)
            assert picture[..., :3].std() > 0.02, f"{name} is blank"
        assert "new/run/contacts.png" in said.stdout
        assert "| trot | 0.80 |" in report
        assert max(map(len, said.stdout.splitlines())) <= 80

    def test_the_robot_did_what_it_was_told(self, metrics):
        steady = [s for s in metrics["segments"] if s["steady"] and s["robot"] is not None]
        fastest = max(steady, key=lambda s: s["command"][0])
        assert fastest["gait"] == "trot"
        assert fastest["command"][0] == pytest.approx(0.8)
        for view in ("robot", "truth"):
            assert fastest[view]["gc_stance"] < 0.1
            assert fastest[view]["gait_identity"] == 1.0
            assert abs(fastest[view]["lag_s"]) < 0.03
            assert fastest[view]["speed"] == pytest.approx(0.8, abs=0.08)
            assert fastest[view]["settling_time"] < 1.5
            assert 0.2 < fastest[view]["cot"] < 1.5
        assert fastest["estimator"]["v_x_rms"] < 0.1
        assert fastest["estimator"]["contact_wrong"] < 0.1

    def test_what_happened_when(self, metrics):
        states = [moment["state"] for moment in metrics["timeline"]]
        assert states[states.index("stand") :] == ["stand", "run"]
        assert metrics["policy"] == "go2.onnx"
        assert metrics["seconds"] == pytest.approx(SECONDS, abs=0.01)
        assert metrics["timing"]["interval"]["p50"] == pytest.approx(0.005, abs=0.001)
        assert metrics["arrivals"][JOINTS]["messages"] == SECONDS * 500
        # two and three periods of the robot in turn: ticks are 4 and 6 ms apart, and none is lost
        assert metrics["problems"] == []

    def test_a_log_of_another_deployer_goes_as_far_as_it_goes(self, log, metrics, tmp_path):
        other = without(log, tmp_path / "lcmlog-2026-01-01.00", TICK, SESSION, TRUTH)
        done = symdyn("analyze", other, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        assert TICK in done.stdout
        out = tmp_path / "out" / "lcmlog-2026-01-01.00"
        assert {path.name for path in out.iterdir()} == {
            "contacts.png", "torques.png", "velocity.png", "metrics.json", "report.md"
        }  # fmt: skip
        found = json.loads((out / "metrics.json").read_text())
        assert found["segments"] == []
        observed = found["observed"]
        # it trotted at 0.8 m/s in the end, and before that sped up
        assert 0.4 < observed["speed"] < 0.9
        assert 2.0 < observed["moving_s"] < 4.5
        trot = max((s["truth"] for s in metrics["segments"] if s["truth"]), key=lambda truth: truth["speed"])
        assert observed["cot"] == pytest.approx(trot["cot"], rel=0.3)
        # 0.35 s is the stride of 0.8 m/s; it sped up from a longer one
        assert list(observed["stride_s"].values()) == pytest.approx([0.36] * 4, abs=0.03)

    def test_what_the_robot_said_alone_gives_velocity_and_contacts(self, log, tmp_path):
        contents = read_contents(without(log, tmp_path / "other.lcmlog", TICK, SESSION))
        found = observe(contents, LegKinematics(GO2), ContactConfig())
        truth = contents.truth
        assert found is not None
        assert truth is not None
        nearest = truth.nearest(found.time)
        error = found.velocity_h - truth.velocity_h[nearest]
        moving = found.moving
        assert np.sqrt(np.mean(error[moving, 0] ** 2)) < 0.1
        assert abs(error[moving, 0].mean()) < 0.03
        assert np.mean(found.contact[moving] != truth.contact[nearest][moving]) < 0.1
        assert found.dt == pytest.approx(0.005, abs=0.0011)

    def test_a_log_with_nothing_from_the_robot(self, log, tmp_path):
        bare = without(log, tmp_path / "bare.lcmlog", TICK, SESSION, TRUTH, JOINTS, IMU)
        done = symdyn("analyze", bare, "--out", "out", cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        assert TARGETS in (tmp_path / "out" / "report.md").read_text()
        assert "out/report.md" in done.stdout

    def test_a_log_cut_short_is_analysed_with_a_warning(self, log, tmp_path):
        (tmp_path / "cut.lcmlog").write_bytes(log.read_bytes()[: int(0.9 * log.stat().st_size) + 5])
        done = symdyn("analyze", "cut.lcmlog", cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        assert "cut short" in " ".join(done.stdout.split())
        assert "cut short" in (tmp_path / "out" / "cut" / "report.md").read_text()

    def test_bad_input(self, log, tmp_path):
        (tmp_path / "text.lcmlog").write_text("trot trot trot")
        (tmp_path / "empty.lcmlog").touch()
        (tmp_path / "short.lcmlog").write_bytes(log.read_bytes()[:100])
        before = sorted(tmp_path.iterdir())
        for name, said in (
            ("none.lcmlog", "No such file"),
            ("text.lcmlog", "not an LCM event log"),
            ("empty.lcmlog", "is empty"),
            ("short.lcmlog", "cut short"),
            (".", "directory"),
        ):
            assert_refused(symdyn("analyze", name, cwd=tmp_path), said)
        assert_refused(symdyn("analyze", log, "--settle", "-1", cwd=tmp_path), "--settle", ">= 0")
        assert_refused(symdyn("analyze", log, "--settle", "nan", cwd=tmp_path), "--settle")
        assert sorted(tmp_path.iterdir()) == before
        assert_refused(symdyn("analyze", log, "--out", "text.lcmlog", cwd=tmp_path), "text.lcmlog")


class TestReplay:
    def test_the_same_bit_for_bit(self, log, tmp_path):
        done = symdyn("replay", log, cwd=tmp_path)
        assert done.returncode == 0, done.stdout + done.stderr
        ticks = sum(1 for event in LogReader(log) if event.channel == TICK)
        assert f"{ticks} ticks" in done.stdout
        assert "bit for bit" in done.stdout

    def test_the_policy_may_lie_elsewhere_but_must_be_the_same(self, log, tmp_path):
        shutil.copy(policy_path(), tmp_path / "copy.onnx")
        short = tmp_path / "short.lcmlog"
        short.write_bytes(log.read_bytes()[:500_000])
        done = symdyn("replay", short, "copy.onnx", cwd=tmp_path)
        assert done.returncode == 0, done.stdout + done.stderr
        assert "cut short" in " ".join(done.stdout.split())
        swaying(tmp_path / "other.onnx")
        assert_refused(
            symdyn("replay", short, "other.onnx", cwd=tmp_path), "other.onnx", "is not the policy", "SHA-256"
        )
        assert_refused(symdyn("replay", short, "none.onnx", cwd=tmp_path), "none.onnx", "No such file")

    def test_a_changed_target_is_found(self, log, tmp_path):
        def change(message):
            joint = 4
            message.q_des = [q + 1e-12 * (k == joint) for k, q in enumerate(message.q_des)]

        done = symdyn("replay", changed(log, tmp_path / "c.lcmlog", TARGETS, 50, change), cwd=tmp_path)
        assert done.returncode == 1, done.stdout + done.stderr
        said = " ".join(done.stdout.split())
        assert "1 ticks differ (targets in 1)" in said
        assert "of a joint target: 1e-12 rad" in said

    def test_a_changed_measurement_changes_what_the_controller_does(self, log, tmp_path):
        ticks = [event.message() for event in LogReader(log) if event.channel == TICK]
        acting = next(t for t in ticks if t.state == "run" and t.acted and t.phase > 0.5)

        def change(message):
            message.q = [q + 0.01 for q in message.q]

        done = symdyn("replay", changed(log, tmp_path / "c.lcmlog", JOINTS, acting.joints_number, change), cwd=tmp_path)
        assert done.returncode == 1, done.stdout + done.stderr
        said = " ".join(done.stdout.split())
        assert f"The first is tick {acting.tick}," in said
        assert "Its action was" in said

    def test_what_cannot_be_replayed(self, log, tmp_path):
        assert_refused(
            symdyn("replay", without(log, tmp_path / "a.lcmlog", SESSION), cwd=tmp_path), SESSION, "symdyn deploy"
        )
        assert_refused(symdyn("replay", without(log, tmp_path / "b.lcmlog", TICK), cwd=tmp_path), "no tick")
        assert_refused(symdyn("replay", "none.lcmlog", cwd=tmp_path), "No such file")

        def change(message):
            message.json = message.json.replace('"tilt"', '"tlit"')

        assert_refused(
            symdyn("replay", changed(log, tmp_path / "c.lcmlog", SESSION, 1, change), cwd=tmp_path), "settings"
        )

    def test_where_messages_are_missing_it_ends_and_says_so(self, log, tmp_path):
        spoilt = bytearray(log.read_bytes())
        early = spoilt.find(JOINTS.encode(), len(spoilt) // 20)
        spoilt[early - 5] ^= 0x7F  # in the length of its data
        (tmp_path / "d.lcmlog").write_bytes(spoilt)
        done = symdyn("replay", "d.lcmlog", cwd=tmp_path)
        assert done.returncode == 0, done.stdout + done.stderr
        assert "What follows is not compared" in " ".join(done.stdout.split())
