"""Logs to recordings: what a session was written from comes back, and nothing that it was not."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hardware.logs.contents import read_contents
from hardware.logs.recording import Run, clock_reverses, mirrored, of_library, runs, sample_times
from hardware.wire.channels import IMU, JOINTS, TICK
from hardware.wire.event_log import LogWriter
from symdyn.analysis import metrics
from symdyn.analysis.footfall import cut_strides
from symdyn.analysis.recording import Recording
from symdyn.gait.library import LIBRARY, PAPER_GAITS
from symdyn.gait.phase import in_swing, leg_phase
from symdyn.gait.symmetry import mirrored as mirrored_gait
from tests.hardware.logs.log_sessions import BEGIN, imu_of, joints_of, tick_of, write_session
from tests.symdyn.analysis.synthetic import MASS, recording

DT = 0.005


def of(gait: str, speed: float = 0.8, seconds: float = 2.0, **options) -> Recording:
    """As the robot measures it: joints and orientation as 32-bit numbers."""
    made = recording(LIBRARY[gait], speed, seconds=seconds, dt=DT, **options)
    rounded = {n: getattr(made, n).astype(np.float32) for n in ("joint_pos", "joint_vel", "joint_torque")}
    return replace(made, **{name: array.astype(np.float64) for name, array in rounded.items()})


def read(path: Path) -> list[Run]:
    return runs(read_contents(path), MASS)


def assert_same(found: Recording, expected: Recording, but: tuple[str, ...] = ("base_pos_w",)) -> None:
    for name, value in vars(expected).items():
        if name not in but:
            np.testing.assert_array_equal(getattr(found, name), value, err_msg=name)


class TestRoundTrip:
    @pytest.mark.parametrize(("gait", "speed"), [("trot", 0.8), ("rotary_gallop", -0.5), ("half_bound_left", 1.2)])
    def test_every_number(self, tmp_path, gait, speed):
        made = of(gait, speed)
        (run,) = read(write_session(tmp_path / "run.lcmlog", made, gait))
        assert_same(run.recording, made)
        assert run.gaits == (gait,) * len(made.time)
        assert run.filled == 0
        assert run.truth is None
        # where the trunk is, the robot does not know
        assert np.isnan(run.recording.base_pos_w).all()

    def test_a_known_gait_comes_back_with_its_phases_and_duty_factor(self, tmp_path):
        for gait in PAPER_GAITS:
            made = of(gait, seconds=4.0)
            (run,) = read(write_session(tmp_path / "run.lcmlog", made, gait))
            found = metrics.summarise(run.recording, gait)
            assert found["gc_stance"] == 0.0
            assert found["gait_identity"] == 1.0
            assert found["phase_error"] < 0.01
            strides = cut_strides(run.recording)
            assert strides.duty == pytest.approx(
                np.full(strides.duty.shape, made.duty[0]), abs=DT / made.period[0] + 0.01
            )

    @pytest.mark.parametrize("late", (-0.1, 0.05, 0.2))
    def test_a_known_shift_of_the_contacts_is_the_phase_lag(self, tmp_path, late):
        (run,) = read(write_session(tmp_path / "run.lcmlog", of("bound", late=late, seconds=4.0), "bound"))
        assert metrics.summarise(run.recording, "bound")["phase_lag"] == pytest.approx(late, abs=0.01)

    def test_messages_may_stand_after_the_tick_that_went_by_them(self, tmp_path):
        made = of("trot", seconds=1.0)
        with LogWriter(tmp_path / "run.lcmlog") as log:
            for k in range(len(made.time)):
                now = BEGIN + k * DT
                log.append(TICK, tick_of(made, k, "trot", k + 1).encode(), now)
                log.append(JOINTS, joints_of(made, k).encode(), now)
                log.append(IMU, imu_of(made, k).encode(), now)
        (run,) = read(log.path)
        assert_same(run.recording, made)


class TestWhatIsLeftOut:
    def test_other_states_than_run(self, tmp_path):
        made = of("trot")
        n = len(made.time)
        states = ["passive"] * 50 + ["stand"] * 50 + ["run"] * (n - 150) + ["damp"] * 50
        (run,) = read(write_session(tmp_path / "run.lcmlog", made, "trot", states=states))
        assert_same(run.recording, made.between(100 * DT, (n - 50) * DT))
        # the first message is 3 ms before the first tick
        assert run.begin == pytest.approx(100 * DT + 0.003, abs=1e-5)
        assert run.end == pytest.approx((n - 50) * DT + 0.003, abs=1e-5)

    def test_two_runs_stay_apart(self, tmp_path):
        made = of("trot")
        states = ["run"] * 150 + ["damp"] * 100 + ["run"] * 150
        first, second = read(write_session(tmp_path / "run.lcmlog", made, "trot", states=states))
        assert_same(first.recording, made.between(0.0, 150 * DT))
        assert_same(second.recording, made.between(250 * DT, 400 * DT))

    def test_a_log_that_never_ran(self, tmp_path):
        made = of("trot", seconds=0.5)
        assert read(write_session(tmp_path / "run.lcmlog", made, "trot", states=["stand"] * len(made.time))) == []

    def test_a_gait_that_is_not_known(self, tmp_path):
        made = of("trot")
        gaits = ["trot"] * 200 + ["waltz"] * 100 + ["trot"] * 100
        first, second = read(write_session(tmp_path / "run.lcmlog", made, gaits))
        assert_same(first.recording, made.between(0.0, 200 * DT))
        assert_same(second.recording, made.between(300 * DT, 400 * DT))

    def test_ticks_whose_messages_the_log_has_lost(self, tmp_path):
        made = of("trot", seconds=1.0)
        with LogWriter(tmp_path / "run.lcmlog") as log:
            for k in range(len(made.time)):
                now = BEGIN + k * DT
                if k < 150:  # cut short, as it were, in joints and IMU only
                    log.append(JOINTS, joints_of(made, k).encode(), now)
                    log.append(IMU, imu_of(made, k).encode(), now)
                log.append(TICK, tick_of(made, k, "trot", k + 1).encode(), now)
        (run,) = read(log.path)
        assert_same(run.recording, made.between(0.0, 150 * DT))

    def test_a_log_cut_in_an_event(self, tmp_path):
        made = of("trot")
        path = write_session(tmp_path / "run.lcmlog", made, "trot")
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2 + 7])
        log = read_contents(path)
        (run,) = runs(log, MASS)
        n = len(run.gaits)
        assert len(made.time) * 0.45 < n < len(made.time) * 0.55
        assert_same(run.recording, made.between(0.0, n * DT))
        assert any("cut short" in problem for problem in log.problems)

    def test_a_message_of_another_type_is_told_once(self, tmp_path):
        made = of("trot", seconds=0.5)
        with LogWriter(tmp_path / "run.lcmlog") as log:
            for k in range(len(made.time)):
                log.append(JOINTS, joints_of(made, k).encode(), BEGIN + k * DT)
                log.append(IMU, joints_of(made, k).encode(), BEGIN + k * DT)
                log.append(TICK, tick_of(made, k, "trot", k + 1).encode(), BEGIN + k * DT)
        found = read_contents(log.path)
        assert runs(found, MASS) == []
        assert [problem for problem in found.problems if IMU in problem and "fingerprint" in problem]
        assert len(found.problems) == 1


class TestLostTicks:
    def test_few_are_stood_for_by_the_one_before(self, tmp_path):
        made = of("trot")
        lost = {10, 57, 58, 59, 200}
        (run,) = read(write_session(tmp_path / "run.lcmlog", made, "trot", lost=lost))
        shown = [max(j for j in range(k + 1) if j not in lost) for k in range(len(made.time))]
        assert run.filled == len(lost)
        for name in ("joint_pos", "contact", "stride_phase", "velocity_h"):
            np.testing.assert_array_equal(getattr(run.recording, name), getattr(made, name)[shown])

    def test_many_part_the_recording(self, tmp_path):
        made = of("trot")
        first, second = read(write_session(tmp_path / "run.lcmlog", made, "trot", lost=range(100, 120)))
        assert_same(first.recording, made.between(0.0, 100 * DT))
        assert_same(second.recording, made.between(120 * DT, 400 * DT))
        assert second.begin - first.begin == pytest.approx(120 * DT)

    def test_late_ones_are_not_lost(self, tmp_path):
        made = of("trot")
        late = np.random.default_rng(0).uniform(0.0, 0.8 * DT, len(made.time)) * (np.arange(len(made.time)) % 7 == 3)
        (run,) = read(write_session(tmp_path / "run.lcmlog", made, "trot", late=late))
        assert run.filled == 0
        assert_same(run.recording, made)

    @given(st.sets(st.integers(1, 79)), st.lists(st.floats(0.0, 0.45), min_size=80, max_size=80), st.data())
    def test_any_pattern_of_lost_and_late_ticks(self, lost, late, data):
        kept = np.array([k for k in range(80) if k not in lost])
        for outlier in data.draw(st.sets(st.sampled_from(kept.tolist()))):
            late[outlier] = 0.95
        late[kept[0]] = 0.0
        times = 100.0 + DT * (kept + np.array(late)[kept])
        found = sample_times(times, DT)
        punctual = np.array(late)[kept] < 0.5
        np.testing.assert_array_equal(found[punctual], kept[punctual])
        # one that is a whole tick late just before others are lost may as well be the first of those
        assert set((found - kept)[~punctual].tolist()) <= {0, 1}


class TestTruth:
    def test_velocity_and_contacts_as_they_were(self, tmp_path):
        made = of("bound", seconds=4.0)
        time = made.time[:, None]
        true = replace(
            made,
            velocity_h=np.concatenate([0.5 + 0.125 * time, 0.25 * time, 1.0 - 0.5 * time], axis=1),
            contact=of("bound", late=0.1, seconds=4.0).contact,
            base_pos_w=np.concatenate([0.25 * time, -0.5 * time, 0.0 * time + 0.375], axis=1),
        )
        (run,) = read(write_session(tmp_path / "run.lcmlog", made, "bound", truth=true))
        assert_same(run.recording, made)
        assert run.truth is not None
        # every other sample has a message; between them what changes linearly is exact, but for 32 bits
        inner = slice(None, -1)
        np.testing.assert_allclose(run.truth.velocity_h[inner], true.velocity_h[inner], atol=2e-5)
        np.testing.assert_allclose(run.truth.base_pos_w[inner], true.base_pos_w[inner], atol=2e-5)
        np.testing.assert_array_equal(run.truth.contact[::2], true.contact[::2])
        assert (run.truth.contact != true.contact).mean() < 0.02
        assert metrics.summarise(run.truth, "bound")["phase_lag"] == pytest.approx(0.1, abs=0.015)
        assert_same(run.truth, made, but=("velocity_h", "contact", "base_pos_w"))

    def test_none_where_it_is_not_known_throughout(self, tmp_path):
        made = of("bound")
        path = write_session(tmp_path / "run.lcmlog", made, "bound", truth=made)
        log = read_contents(path)
        assert log.truth is not None
        half = len(log.truth.time) // 2
        short = {name: value[:half] for name, value in vars(log.truth).items()}
        (run,) = runs(replace(log, truth=replace(log.truth, **short)), MASS)
        assert run.truth is None


class TestMirrorImages:
    @pytest.mark.parametrize("gait", ("rotary_gallop", "transverse_gallop", "half_bound_left"))
    def test_of_a_gait_is_the_gait_for_the_metrics(self, tmp_path, gait):
        made = recording(mirrored_gait(LIBRARY[gait]), 0.8, seconds=4.0, dt=DT, late=0.1)
        (run,) = read(write_session(tmp_path / "run.lcmlog", made, f"{gait}_mirrored"))
        shown, name = of_library(run.recording, run.gaits[0])
        plain = recording(LIBRARY[gait], 0.8, seconds=4.0, dt=DT, late=0.1)
        found, expected = metrics.summarise(shown, name), metrics.summarise(plain, gait)
        assert name == gait
        assert found["gait_identity"] == 1.0
        assert found == pytest.approx(expected, abs=1e-6, nan_ok=True)

    def test_by_hand(self, by_hand):
        made, rng = recording(LIBRARY["walk"], 0.5, seconds=0.5, dt=DT), np.random.default_rng(1)
        n = len(made.time)
        made = replace(
            made,
            joint_pos=rng.normal(size=(n, 12)),
            joint_vel=rng.normal(size=(n, 12)),
            joint_torque=rng.normal(size=(n, 12)),
            velocity_h=rng.normal(size=(n, 3)),
            velocity_command=rng.normal(size=(n, 3)),
            base_pos_w=rng.normal(size=(n, 3)),
            base_quat_w=rng.normal(size=(n, 4)),
        )
        image = mirrored(made)
        for name in ("joint_pos", "joint_vel", "joint_torque"):
            np.testing.assert_array_equal(getattr(image, name), by_hand.joints(getattr(made, name)))
        for name in ("contact", "desired_stance", "offsets"):
            np.testing.assert_array_equal(getattr(image, name), by_hand.legs(getattr(made, name)))
        for name in ("velocity_h", "velocity_command"):
            np.testing.assert_array_equal(getattr(image, name), getattr(made, name) * [1.0, -1.0, -1.0])
        pose = np.concatenate([made.base_pos_w, made.base_quat_w, np.zeros((n, 12))], axis=1)
        expected = by_hand.qpos(pose)
        np.testing.assert_array_equal(image.base_pos_w, expected[:, :3])
        np.testing.assert_array_equal(image.base_quat_w, expected[:, 3:7])
        assert_same(mirrored(image), made, but=())


@pytest.mark.parametrize("reverses", (True, False))
def test_whether_the_clock_reverses_shows_in_the_desired_stance(reverses):
    made = recording(LIBRARY["rotary_gallop"], -0.8, seconds=2.0, dt=DT)
    phases = leg_phase(made.stride_phase, made.offsets, made.velocity_command[:, 0], time_reversal=reverses)
    assert clock_reverses(replace(made, desired_stance=~in_swing(phases, made.duty))) == reverses
