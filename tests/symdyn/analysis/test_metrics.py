from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from symdyn.analysis import metrics
from symdyn.analysis.footfall import Strides, cut_strides, touchdowns
from symdyn.errors import InvalidValue, UnknownName
from symdyn.gait.library import LIBRARY
from symdyn.gait.timing import GRAVITY, TimingCurve
from symdyn.robot.legs import JOINTS, LEGS
from tests.robots import GO2
from tests.symdyn.analysis.synthetic import MASS, recording

every_gait = pytest.mark.parametrize("name", LIBRARY)
every_speed = pytest.mark.parametrize("speed", (-2.0, -0.5, 0.5, 1.5))


def period_of(speed: float) -> float:
    return float(TimingCurve().period(np.array(speed), GO2.leg_length))


def duty_of(speed: float) -> float:
    return float(TimingCurve().duty(np.array(speed), GO2.leg_length))


def strides_of(delays: np.ndarray, gait: str = "trot") -> Strides:
    """Strides of given touchdowns, (n, 4), under one commanded gait."""
    n = len(delays)
    offsets = np.tile(LIBRARY[gait].theta, (n, 1))
    return Strides(
        start=np.arange(n),
        stop=np.arange(n) + 1,
        delays=delays,
        commanded_delays=np.mod(-offsets, 1.0),
        duty=np.full((n, 4), 0.5),
        commanded_offsets=offsets,
        commanded_duty=np.full(n, 0.5),
        gait=("none",) * n,
    )


class TestPerfection:
    @every_gait
    @every_speed
    def test_a_robot_that_obeys_the_clock(self, name, speed):
        run = recording(LIBRARY[name], speed, first_phase=0.4)
        sample = run.dt / run.period[0]
        found = metrics.summarise(run, name)
        assert set(found) == set(metrics.KEYS)
        for key in ("gc_stance", "rmsne", "speed_error", "y_error", "yaw_error", "settling_time"):
            assert found[key] == 0.0, key
        assert found["gc_morph"] == pytest.approx(0.0, abs=1e-9)
        assert found["gc"] == found["gc_stance"] + found["gc_morph"]
        assert found["gait_identity"] == 1.0
        assert found["phase_error"] < sample
        assert found["symmetry_residual"] < sample
        assert abs(found["phase_lag"]) < sample
        assert found["duty_error"] < sample
        assert found["speed"] == pytest.approx(speed)
        assert 0.0 < found["cot"] < np.inf


class TestAnotherGait:
    @pytest.mark.parametrize("speed", (-0.5, 0.5))
    def test_a_bound_for_a_rotary_gallop(self, speed):
        found = metrics.summarise(recording(LIBRARY["rotary_gallop"], speed, played=LIBRARY["bound"]), "rotary_gallop")
        assert found["gait_identity"] == 0.0
        assert found["phase_error"] == pytest.approx(0.13, abs=0.01)
        assert found["gc"] == pytest.approx(0.26, abs=0.02)

    def test_a_late_gallop_scores_no_better_in_gc_but_is_the_gallop(self):
        late = metrics.summarise(recording(LIBRARY["rotary_gallop"], 0.5, late=0.13), "rotary_gallop")
        assert late["gc"] == pytest.approx(0.26, abs=0.02)
        assert late["gait_identity"] == 1.0
        assert late["phase_error"] < 0.01
        assert late["phase_lag"] == pytest.approx(0.13, abs=0.01)

    @every_gait
    def test_every_other_gait_is_found_out(self, name):
        for other in LIBRARY:
            strides = cut_strides(recording(LIBRARY[other], 0.5, played=LIBRARY[name], seconds=2.5))
            assert metrics.gait_identity(strides, other) == float(name == other)
            assert metrics.gait_identity(strides, name) == 1.0
            assert (metrics.phase_error(strides) < 0.01) == (name == other)


class TestRMSNE:
    def test_formula(self):
        command = np.array([[1.0, 0.0, 0.0], [-2.0, 0.0, 0.5]])
        actual = np.array([[0.5, 0.1, 0.0], [-2.0, 0.2, 0.8]])
        per_sample = [(0.5 / 1.1) ** 2 + (0.1 / 0.1) ** 2, (0.2 / 0.1) ** 2 + (0.3 / 0.6) ** 2]
        assert metrics.rmsne(command, actual) == pytest.approx((sum(per_sample) / 2) ** 0.5)

    def test_epsilon(self):
        command, actual = np.zeros((5, 3)), np.tile([0.0, 0.3, 0.0], (5, 1))
        assert metrics.rmsne(command, actual, epsilon=0.01) == pytest.approx(30.0)


class TestGaitConsistency:
    @every_gait
    @pytest.mark.parametrize("speed", (-1.5, 0.2, 1.5))
    @pytest.mark.parametrize("late", (0.05, 0.2, 0.33, 0.5, 0.8))
    def test_of_a_known_lag(self, name, speed, late):
        period, duty, samples = period_of(speed), duty_of(speed), 500
        run = recording(LIBRARY[name], speed, late=late, dt=period / samples, seconds=3 * period)
        expected = 2.0 * min(late, 1.0 - late, duty, 1.0 - duty)
        assert metrics.gc_stance(run.contact, run.desired_stance) == pytest.approx(expected, abs=2.5 / samples)

    @pytest.mark.parametrize(("name", "pairs"), [("bound", 1), ("trot", 1), ("pronk", 3), ("rotary_gallop", 0)])
    def test_morph_counts_the_pairs_of_the_gait(self, name, pairs):
        run = recording(LIBRARY[name], 0.5, seconds=1.0)
        off = run.joint_pos.copy()
        off[:, JOINTS.index("LF_thigh")] += 0.03
        off[:, JOINTS.index("LF_calf")] -= 0.04
        assert metrics.gc_morph(off, run.offsets) == pytest.approx(0.05 * pairs)

    def test_morph_compares_opposite_legs_as_mirror_images(self):
        run = recording(LIBRARY["bound"], 0.5, seconds=1.0)
        off = run.joint_pos.copy()
        off[:, JOINTS.index("LH_hip")] += 0.1
        off[:, JOINTS.index("RH_hip")] -= 0.1
        assert metrics.gc_morph(off, run.offsets) == pytest.approx(0.0, abs=1e-12)
        off[:, JOINTS.index("RH_hip")] += 0.2
        assert metrics.gc_morph(off, run.offsets) == pytest.approx(0.2)

    def test_gc_is_the_sum(self):
        run = recording(LIBRARY["bound"], 0.5, late=0.1)
        off = run.joint_pos.copy()
        off[:, JOINTS.index("LF_thigh")] += 0.1
        total = metrics.gc(run.contact, run.desired_stance, off, run.offsets)
        assert total == pytest.approx(metrics.gc_stance(run.contact, run.desired_stance) + 0.1)


class TestCostOfTransport:
    @pytest.mark.parametrize("angle", (0.0, 0.5, np.pi / 2, 2.5))
    def test_sinusoids(self, angle):
        dt, turns = 1e-3, 5
        t = dt * np.arange(turns * 1000)
        torque = 3.0 * np.sin(2.0 * np.pi * t)[:, None] * np.ones(12)
        joint_vel = 2.0 * np.sin(2.0 * np.pi * t + angle)[:, None] * np.ones(12)
        # the positive part of sin x sin(x + a) averages ((pi - a) cos a + sin a) / 2 pi
        mean_power = 12 * 6.0 * ((np.pi - angle) * np.cos(angle) + np.sin(angle)) / (2.0 * np.pi)
        expected = mean_power * turns / (MASS * GRAVITY * 4.0)
        for displacement in (4.0, -4.0):
            found = metrics.cost_of_transport(torque, joint_vel, dt, MASS, GRAVITY, displacement)
            assert found == pytest.approx(expected, rel=1e-4)

    def test_on_the_spot(self):
        one = np.ones((3, 12))
        assert metrics.cost_of_transport(one, one, 0.01, MASS, GRAVITY, 0.0) == np.inf

    def test_of_a_recording(self):
        run = recording(LIBRARY["trot"], -0.5, seconds=3.0)
        ones = replace(run, joint_torque=np.ones((1500, 12)), joint_vel=np.tile([2.0, -1.0, 0.0], (1500, 4)))
        # four joints do 2 W each, at 0.5 m/s
        assert metrics.summarise(ones, "trot")["cot"] == pytest.approx(8.0 / (MASS * GRAVITY * 0.5))


class TestStrideAverage:
    def test_takes_out_what_repeats_with_the_stride(self):
        period, dt = 0.193, 0.02  # a stride is 9.65 samples
        t = dt * np.arange(400)
        sway = np.sin(2.0 * np.pi * t / period)
        average = metrics.stride_average(1.0 + sway, np.full(400, period), dt)
        assert np.abs(average[10:] - 1.0).max() < 0.03
        ten_samples = np.convolve(sway, np.ones(10) / 10, mode="valid")
        assert np.abs(ten_samples).max() > 0.03

    def test_of_a_ramp_lags_half_a_stride(self):
        dt = 0.01
        t = dt * np.arange(200)
        average = metrics.stride_average(t, np.full(200, 0.4), dt)
        assert average[50:] == pytest.approx(t[50:] - 0.2 + dt / 2)
        assert average[:40] == pytest.approx(t[:40] / 2)

    def test_of_less_than_a_sample_is_the_sample(self):
        values = np.array([1.0, 5.0, -2.0])
        assert metrics.stride_average(values, np.full(3, 1e-3), 0.02) == pytest.approx(values)

    def test_follows_a_changing_period(self):
        values = np.array([0.0] * 10 + [1.0] * 10)
        period = np.array([0.1] * 19 + [2.0])
        average = metrics.stride_average(values, period, 0.1)
        assert average[[9, 10, 18, 19]] == pytest.approx([0.0, 1.0, 1.0, 0.5])


class TestSettlingTime:
    @pytest.mark.parametrize("command", (-2.0, 0.5, 2.0))
    @pytest.mark.parametrize("constant", (0.1, 0.5))
    def test_first_order_step_response(self, command, constant):
        dt, period = 0.005, period_of(command)
        time = dt * np.arange(1000)
        speed = command * (1.0 - np.exp(-time / constant))
        tolerance = max(0.1 * abs(command), 0.1)
        expected = constant * np.log(abs(command) / tolerance)
        found = metrics.settling_time(time, speed, command, np.full(1000, period))
        assert expected <= found <= expected + period
        # the average over a window of T of the exponential is the exponential times (e^(T/tau) - 1) tau / T
        window = (np.exp(period / constant) - 1.0) * constant / period
        if expected + constant * np.log(window) > period:
            assert found == pytest.approx(expected + constant * np.log(window), abs=2 * dt)

    def test_tolerance_is_an_argument(self):
        time = 0.01 * np.arange(1000)
        speed, period = 1.0 - np.exp(-time), np.full(1000, 0.01)
        assert metrics.settling_time(time, speed, 1.0, period, tolerance=0.3) == pytest.approx(-np.log(0.3), abs=0.03)

    def test_sway_within_the_stride_does_not_count(self):
        time = 0.005 * np.arange(800)
        speed = 0.5 + 0.4 * np.cos(2.0 * np.pi * time / 0.4)
        assert metrics.settling_time(time, speed, 0.5, np.full(800, 0.4)) < 0.4
        assert metrics.settling_time(time, speed, 0.5, np.full(800, 0.01)) == np.inf

    def test_the_last_departure_counts(self):
        time = 0.01 * np.arange(500)
        speed = np.ones(500)
        speed[300:310] = 0.0
        assert metrics.settling_time(time, speed, 1.0, np.full(500, 0.01)) == pytest.approx(3.1)

    def test_never_and_at_once(self):
        time, period = 0.01 * np.arange(100), np.full(100, 0.1)
        assert metrics.settling_time(time, np.zeros(100), 1.0, period) == np.inf
        assert metrics.settling_time(time, np.full(100, np.nan), 1.0, period) == np.inf
        assert metrics.settling_time(time, np.ones(100), 1.0, period) == 0.0

    def test_starts_at_the_recording_s_start(self):
        run = recording(LIBRARY["trot"], 0.5)
        velocity = run.velocity_h.copy()
        velocity[:250, 0] = 0.0
        found = metrics.summarise(replace(run, velocity_h=velocity), "trot")
        assert 0.5 < found["settling_time"] < 0.5 + period_of(0.5)
        assert found["speed_error"] == 0.0


class TestPhase:
    delays = arrays(np.float64, st.tuples(st.integers(1, 6), st.just(4)), elements=st.floats(0.0, 0.999))

    @settings(deadline=None)
    @given(delays, st.floats(-1.0, 1.0))
    def test_a_common_shift_changes_no_error(self, delays, shift):
        before, after = strides_of(delays), strides_of(np.mod(delays + shift, 1.0))
        assert metrics.phase_error(after) == pytest.approx(metrics.phase_error(before), abs=1e-6)
        assert metrics.symmetry_residual(after) == pytest.approx(metrics.symmetry_residual(before), abs=1e-9)
        assert metrics.phase_error(before) <= 0.25 + 1e-6

    @settings(deadline=None, max_examples=25)
    @given(st.sampled_from(sorted(LIBRARY)), st.sampled_from((-1.0, 1.0)), st.floats(-0.5, 0.5))
    def test_a_common_lag_of_a_recording_changes_neither_error_nor_identity(self, name, speed, late):
        strides = cut_strides(recording(LIBRARY[name], speed, late=late, seconds=2.0))
        assert len(strides) >= 4
        assert metrics.gait_identity(strides, name) == 1.0
        assert metrics.phase_error(strides) < 0.01

    @pytest.mark.parametrize("speed", (-1.0, 1.0))
    @pytest.mark.parametrize("late", (-0.3, -0.1, 0.0, 0.2, 0.45))
    def test_lag_is_signed(self, speed, late):
        strides = cut_strides(recording(LIBRARY["walk"], speed, late=late))
        assert metrics.phase_lag(strides) == pytest.approx(late, abs=0.01)

    def test_error_of_one_late_leg(self):
        delays = LIBRARY["trot"].touchdown_delays[None] + np.array([[0.0, 0.1, 0.0, 0.0]])
        # the common lag is a quarter of the leg's (nearly: the mean is circular), the error what remains
        assert metrics.phase_error(strides_of(delays)) == pytest.approx((0.075 + 3 * 0.025) / 4, abs=1e-3)
        assert metrics.phase_lag(strides_of(delays)) == pytest.approx(0.025, abs=1e-3)

    def test_every_stride_has_a_lag_of_its_own(self):
        delays = LIBRARY["trot"].touchdown_delays + np.array([[0.1], [-0.1], [0.3]])
        assert metrics.phase_error(strides_of(np.mod(delays, 1.0))) == pytest.approx(0.0, abs=1e-9)
        assert metrics.phase_lag(strides_of(np.mod(delays, 1.0))) == pytest.approx(0.1, abs=0.01)

    def test_incomplete_strides_have_no_phase(self):
        good, bad = LIBRARY["trot"].touchdown_delays, np.array([np.nan, 0.3, 0.2, 0.1])
        assert metrics.phase_error(strides_of(np.stack([good, bad]))) == pytest.approx(0.0, abs=1e-9)
        for measure in (metrics.phase_error, metrics.phase_lag, metrics.symmetry_residual):
            assert np.isnan(measure(strides_of(bad[None])))


class TestIdentity:
    def test_missing_touchdowns_count_as_not_identical(self):
        run = recording(LIBRARY["trot"], 0.5, seconds=6.0)
        contact = run.contact.copy()
        landings = touchdowns(contact, "RF")
        stance = round(float(run.duty[0] * run.period[0]) / run.dt)
        for landing in landings[3:8]:
            contact[landing - 2 : landing + stance + 2, LEGS.index("RF")] = False
        strides = cut_strides(replace(run, contact=contact))
        assert metrics.gait_identity(strides, "trot") == pytest.approx(1.0 - 5 / len(strides))
        assert metrics.phase_error(strides) < 0.01

    def test_unknown_gait(self):
        with pytest.raises(UnknownName, match="trot"):
            metrics.gait_identity(strides_of(np.zeros((1, 4))), "trott")

    def test_no_stride(self):
        empty = cut_strides(recording(LIBRARY["trot"], 0.5, seconds=0.2))
        assert np.isnan(metrics.gait_identity(empty, "trot"))
        for measure in (metrics.phase_error, metrics.phase_lag, metrics.symmetry_residual, metrics.duty_error):
            assert np.isnan(measure(empty))


class TestDuty:
    @pytest.mark.parametrize("signs", ((1, 1, 1, 1), (-1, -1, -1, -1), (1, -1, 1, -1)))
    def test_error_of_legs_that_lift_off_at_another_time(self, signs):
        run = recording(LIBRARY["trot"], 0.5)
        contact = run.contact.copy()
        for leg, sign in enumerate(signs):
            for lift_off in np.flatnonzero(run.contact[:-1, leg] & ~run.contact[1:, leg]):
                moved = lift_off + 20 * sign
                contact[min(lift_off, moved) : max(lift_off, moved), leg] = sign > 0
        found = metrics.duty_error(cut_strides(replace(run, contact=contact)))
        assert found == pytest.approx(20 * run.dt / run.period[0], abs=0.01)

    def test_a_leg_that_drags_counts(self):
        run = recording(LIBRARY["trot"], 0.5)
        contact = run.contact.copy()
        contact[:, LEGS.index("LH")] = True
        found = metrics.duty_error(cut_strides(replace(run, contact=contact)))
        assert found == pytest.approx((1.0 - run.duty[0]) / 4, abs=0.01)


class TestSymmetryResidual:
    @pytest.mark.parametrize("late", (0.02, 0.1, 0.25))
    def test_one_late_leg_of_a_trot(self, late):
        # each of the three elements swaps the leg with another: two legs of four differ from their image by ``late``
        delays = LIBRARY["trot"].touchdown_delays[None] + np.array([[0.0, late, 0.0, 0.0]])
        assert metrics.symmetry_residual(strides_of(delays)) == pytest.approx(late / 2)

    def test_a_bound_for_a_trot(self):
        # g_t of a bound is half a stride late as that of a trot is; g_s and g_r are half a stride off
        found = metrics.symmetry_residual(strides_of(LIBRARY["bound"].touchdown_delays[None]))
        assert found == pytest.approx(1.0 / 3.0)

    def test_a_lame_gallop_with_its_symmetry_kept(self):
        # g_r takes LH to RF and LF to RH; moving such a pair together leaves the rotary gallop's symmetry alone
        delays = LIBRARY["rotary_gallop"].touchdown_delays[None] + np.array([[0.1, 0.0, 0.1, 0.0]])
        kept = strides_of(np.mod(delays, 1.0), "rotary_gallop")
        assert metrics.symmetry_residual(kept) == pytest.approx(0.0, abs=1e-9)
        assert metrics.phase_error(kept) > 0.04

    def test_trivial_group(self):
        delays = np.random.default_rng(0).random((5, 4))
        assert metrics.symmetry_residual(strides_of(delays, "half_bound_left")) == 0.0
        assert metrics.symmetry_residual(strides_of(delays, "trot")) > 0.05


class TestSummarise:
    def test_velocities_are_means_over_whole_strides(self):
        run = recording(LIBRARY["rotary_gallop"], 0.5)
        sway = np.sin(2.0 * np.pi * run.stride_phase)
        velocity = run.velocity_h + np.stack([-0.1 + sway, 0.2 - sway, -0.3 + 2.0 * sway], axis=1)
        found = metrics.summarise(replace(run, velocity_h=velocity), "rotary_gallop")
        assert found["speed"] == pytest.approx(0.4, abs=0.002)
        assert found["speed_error"] == pytest.approx(0.1, abs=0.002)
        assert found["y_error"] == pytest.approx(0.2, abs=0.002)
        assert found["yaw_error"] == pytest.approx(0.3, abs=0.004)
        assert found["rmsne"] > 3.0

    def test_what_comes_before_counts_for_the_settling_time_only(self):
        run = recording(LIBRARY["bound"], 1.0)
        early = run.time < 0.8
        spoilt = replace(
            run,
            velocity_h=np.where(early[:, None], -1.0, run.velocity_h),
            contact=np.where(early[:, None], False, run.contact),
            joint_pos=np.where(early[:, None], 0.0, run.joint_pos),
            joint_torque=np.where(early[:, None], 99.0, run.joint_torque),
        )
        clean, found = metrics.summarise(run, "bound"), metrics.summarise(spoilt, "bound")
        assert {key for key in clean if clean[key] != found[key]} == {"settling_time"}
        assert metrics.summarise(spoilt, "bound", settle_s=0.0)["gc"] > clean["gc"] + 0.01

    def test_time_reversal_switched_off(self):
        run = recording(LIBRARY["trot"], -1.0)
        on, off = metrics.summarise(run, "trot"), metrics.summarise(run, "trot", time_reversal=False)
        # the commanded touchdown moves from 0 to 1 - beta of the leg phase, and beta is less than a half here
        assert off["phase_lag"] - on["phase_lag"] == pytest.approx(run.duty[0], abs=0.01)
        assert off["gait_identity"] == on["gait_identity"] == 1.0

    def test_too_short(self):
        with pytest.raises(InvalidValue, match="1 s"):
            metrics.summarise(recording(LIBRARY["trot"], 0.5, seconds=0.9), "trot")

    def test_unknown_gait(self):
        with pytest.raises(UnknownName, match="bound"):
            metrics.summarise(recording(LIBRARY["trot"], 0.5), "bond")

    def test_keys_name_their_unit(self):
        for key, text in metrics.KEYS.items():
            unit, separator, meaning = text.partition(": ")
            assert separator, key
            assert unit in {"1", "m/s", "rad/s", "s", "rad", "strides"}, key
            assert meaning, key
