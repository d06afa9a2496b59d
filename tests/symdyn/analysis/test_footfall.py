from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from symdyn.analysis.footfall import NO_GAIT, SHORTEST_S, cut_strides, debounce, touchdowns
from symdyn.analysis.recording import Recording
from symdyn.errors import UnknownName
from symdyn.gait.library import LIBRARY, wrap
from symdyn.gait.phase import advance
from symdyn.robot.legs import LEGS
from tests.symdyn.analysis.synthetic import recording

SPEEDS = (-1.0, 0.0, 0.5, 2.0)
every_gait = pytest.mark.parametrize("name", LIBRARY)
every_speed = pytest.mark.parametrize("speed", SPEEDS)


def column(*runs: tuple[int, bool]) -> np.ndarray:
    """Contact of every leg from (length, state) runs, (S, 4)."""
    return np.repeat(np.concatenate([np.full(length, state) for length, state in runs])[:, None], len(LEGS), axis=1)


def joined(*parts: Recording) -> Recording:
    """One recording after the other."""
    values = {
        name: np.concatenate([getattr(part, name) for part in parts]) if isinstance(value, np.ndarray) else value
        for name, value in vars(parts[0]).items()
    }
    return Recording(**values)


class TestDebounce:
    def test_removes_blips_of_both_kinds(self):
        chattering = column((20, False), (2, True), (20, False), (10, True), (3, False), (10, True), (20, False))
        assert np.array_equal(debounce(chattering, 0.004), column((42, False), (23, True), (20, False)))

    def test_keeps_what_lasts_just_long_enough(self):
        contact = column((20, False), (3, True), (20, False), (3, True), (20, False))
        assert np.array_equal(debounce(contact, 0.005, 0.015), contact)
        assert not debounce(contact, 0.005, 0.0151).any()

    def test_the_shortest_goes_first(self):
        # were the flight of three samples filled first, the single sample of contact would prolong the stance
        contact = column((9, True), (3, False), (1, True), (9, False))
        assert np.array_equal(debounce(contact, 0.004), column((9, True), (13, False)))

    def test_leaves_the_ends_alone(self):
        contact = column((1, True), (20, False), (1, True))
        assert np.array_equal(debounce(contact, 0.004), contact)

    def test_leaves_its_argument_alone(self):
        contact = column((20, False), (1, True), (20, False))
        debounce(contact, 0.004)
        assert contact.sum() == len(LEGS)

    @settings(deadline=None)
    @given(arrays(np.bool_, st.tuples(st.integers(1, 80), st.just(4))), st.floats(0.001, 0.02))
    def test_is_idempotent_and_leaves_nothing_short(self, contact, dt):
        clean = debounce(contact, dt)
        assert np.array_equal(debounce(clean, dt), clean)
        for leg in range(len(LEGS)):
            inner = np.diff(np.flatnonzero(np.diff(clean[:, leg])))
            assert (inner * dt >= SHORTEST_S - 1e-9).all()


class TestTouchdowns:
    def test_of_one_leg(self):
        contact = np.zeros((10, 4), dtype=bool)
        contact[[0, 1, 4, 5, 8], LEGS.index("RF")] = True
        assert touchdowns(contact, "RF").tolist() == [4, 8]
        assert touchdowns(contact, "LH").tolist() == []

    def test_unknown_leg(self):
        with pytest.raises(UnknownName, match="RF"):
            touchdowns(np.zeros((3, 4), dtype=bool), "FR")


class TestStrides:
    @every_gait
    @every_speed
    def test_of_the_commanded_gait(self, name, speed):
        run = recording(LIBRARY[name], speed, first_phase=0.123)
        strides = cut_strides(run)
        strides_run = 4.0 / run.period[0]
        assert strides_run - 2 < len(strides) <= strides_run
        sample = run.dt / run.period[0]
        assert strides.complete.all()
        assert set(strides.gait) == {name}
        assert np.abs(wrap(strides.delays - strides.commanded_delays)).max() <= sample / 2 + 1e-9
        assert strides.duty == pytest.approx(np.broadcast_to(run.duty[0], strides.duty.shape), abs=2 * sample)
        assert np.array_equal(strides.start[1:], strides.stop[:-1])

    @every_speed
    def test_the_pattern_is_minus_the_offsets_in_both_directions(self, speed):
        walk = LIBRARY["walk"]
        strides = cut_strides(recording(walk, speed))
        pattern = strides.delays - strides.delays[:, :1]
        assert np.abs(wrap(pattern + walk.theta)).max() < 0.02

    @every_gait
    @pytest.mark.parametrize("late", np.linspace(-0.5, 0.5, 9))
    def test_no_common_lag_splits_touchdowns(self, name, late):
        run = recording(LIBRARY[name], 0.5, late=late, seconds=6.0)
        rng = np.random.default_rng(0)
        jittered = replace(run, contact=np.stack([np.roll(c, rng.integers(-3, 4)) for c in run.contact.T], axis=1))
        strides = cut_strides(jittered)
        assert strides.complete.all()

    def test_touchdowns_that_jitter_about_the_commanded_gap_are_not_split(self):
        # the middle of a largest gap of the rotary gallop's touchdowns, 0.0 and 0.5, is where a bound lands
        run = recording(LIBRARY["rotary_gallop"], 0.5, played=LIBRARY["bound"], seconds=10.0)
        contact = run.contact.copy()
        rng = np.random.default_rng(1)
        for leg in range(len(LEGS)):
            for landing in touchdowns(run.contact, LEGS[leg]):
                shift = rng.integers(-8, 9)
                contact[min(landing, landing + shift) : max(landing, landing + shift), leg] = shift < 0
        strides = cut_strides(replace(run, contact=contact))
        assert strides.complete.all()
        assert set(strides.gait) == {"bound"}

    def test_a_leg_that_does_not_land_or_lands_twice(self):
        run = recording(LIBRARY["trot"], 0.5)
        contact = run.contact.copy()
        contact[:, LEGS.index("LF")] = True
        stance = touchdowns(contact, "RH")[4]
        contact[stance + 30 : stance + 50, LEGS.index("RH")] = False
        strides = cut_strides(replace(run, contact=contact))
        assert set(strides.gait) == {NO_GAIT}
        assert np.isnan(strides.delays[:, LEGS.index("LF")]).all()
        assert np.isnan(strides.delays[:, LEGS.index("RH")]).sum() == 1
        assert np.isfinite(strides.delays[:, [LEGS.index("LH"), LEGS.index("RF")]]).all()
        assert (strides.duty[:, LEGS.index("LF")] == 1.0).all()

    def test_chatter_is_no_second_landing(self):
        run = recording(LIBRARY["trot"], 0.5)
        contact = run.contact.copy()
        for landing in touchdowns(contact, "RH"):
            contact[landing + 20 : landing + 25, LEGS.index("RH")] = False
        assert cut_strides(replace(run, contact=contact)).complete.all()
        assert not cut_strides(replace(run, contact=contact), shortest_s=0.0).complete.any()

    def test_no_stride_spans_a_transition(self):
        first = recording(LIBRARY["trot"], 0.5)
        second = recording(LIBRARY["bound"], 0.5, first_phase=float(first.stride_phase[-1]))
        strides = cut_strides(joined(first, second))
        change = len(first.contact)
        assert not ((strides.start < change) & (strides.stop > change)).any()
        assert [strides.gait[i] for i in np.flatnonzero(strides.stop <= change)] == ["trot"] * 9
        assert {strides.gait[i] for i in np.flatnonzero(strides.start >= change)} == {"bound"}
        assert (strides.commanded_offsets[strides.start >= change] == LIBRARY["bound"].theta).all()

    @every_gait
    def test_strides_start_anew_where_the_clock_is_set(self, name):
        parts, phase = [], 0.3
        for speed in (-2.0, -1.0, 0.2, 2.0):
            parts.append(recording(LIBRARY[name], speed, first_phase=phase))
            phase = float(advance(parts[-1].stride_phase[-1], parts[-1].period[-1], parts[-1].dt))
        strides = cut_strides(joined(*parts))
        assert strides.complete.all()
        assert set(strides.gait) == {name}
        assert set(np.round(strides.commanded_duty, 6)) == {round(float(part.duty[0]), 6) for part in parts}
        sample = parts[-1].dt / parts[-1].period[-1]
        assert np.abs(wrap(strides.delays - strides.commanded_delays)).max() < sample
        for change in 2 * len(parts[0].contact), 3 * len(parts[0].contact):
            assert not ((strides.start < change) & (strides.stop > change)).any()

    @every_gait
    def test_a_clock_that_ticks_more_slowly_than_the_samples_come(self, name):
        run = recording(LIBRARY[name], 2.0, dt=0.005)
        held = replace(run, stride_phase=run.stride_phase[np.arange(len(run.stride_phase)) // 4 * 4])
        strides = cut_strides(held)
        assert len(strides) >= len(cut_strides(run)) - 1
        assert set(strides.gait) == {name}

    def test_time_reversal_switched_off(self):
        run = recording(LIBRARY["trot"], -1.0)
        on, off = cut_strides(run), cut_strides(run, time_reversal=False)
        difference = wrap(off.commanded_delays[0] - on.commanded_delays[0])
        assert difference == pytest.approx(np.full(4, wrap(1.0 - run.duty[0])))

    def test_nothing_whole(self):
        strides = cut_strides(recording(LIBRARY["trot"], 0.5, seconds=0.3))
        assert len(strides) == 0
        assert strides.delays.shape == strides.duty.shape == strides.commanded_offsets.shape == (0, 4)
        assert strides.gait == ()
