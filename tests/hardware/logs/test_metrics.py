"""Segments, metrics and timing of sessions whose truth is known."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from hardware.logs import metrics as log_metrics
from hardware.logs.contents import Ticks
from hardware.logs.metrics import HOLD_S, KEYS, Segment, judge, segments
from hardware.logs.recording import Run
from symdyn.analysis import metrics
from symdyn.analysis.recording import Recording
from symdyn.gait.library import LIBRARY
from symdyn.gait.symmetry import mirrored
from tests.hardware.logs.log_sessions import tick_of
from tests.symdyn.analysis.synthetic import recording

DT = 0.005


def run_of(made: Recording, gaits: str | list[str], truth: Recording | None = None, begin: float = 3.0) -> Run:
    names = tuple(gaits) if isinstance(gaits, list) else (gaits,) * len(made.time)
    return Run(begin, made, truth, names, 0)


def joined(*parts: Recording) -> Recording:
    arrays = [name for name, value in vars(parts[0]).items() if isinstance(value, np.ndarray)]
    return replace(parts[0], **{name: np.concatenate([getattr(part, name) for part in parts]) for name in arrays})


def commanded(made: Recording, v_x: np.ndarray) -> Recording:
    command = np.zeros((len(v_x), 3))
    command[:, 0] = v_x
    return replace(made, velocity_command=command)


def spans(found: list[Segment]) -> list[tuple[str, float, float, float, bool]]:
    return [
        (s.gait, round(s.run.begin, 6), round(s.run.end, 6), round(float(s.command[0]), 6), s.steady) for s in found
    ]


class TestSegments:
    def test_begin_where_the_gait_changes(self):
        parts = [recording(LIBRARY[gait], 0.8, seconds=2.0, dt=DT) for gait in ("trot", "bound", "trot")]
        gaits = ["trot"] * 400 + ["bound"] * 400 + ["trot"] * 400
        assert spans(segments(run_of(joined(*parts), gaits))) == [
            ("trot", 3.0, 5.0, 0.8, True),
            ("bound", 5.0, 7.0, 0.8, True),
            ("trot", 7.0, 9.0, 0.8, True),
        ]

    def test_begin_where_the_velocity_begins_to_change(self):
        made = recording(LIBRARY["trot"], 0.8, seconds=6.0, dt=DT)
        # 2 s at 0, half a second of ramp, 1.5 s at 0.8, at once to -0.4
        v_x = np.concatenate([np.zeros(400), np.linspace(0.0, 0.8, 101)[1:], np.full(300, 0.8), np.full(400, -0.4)])
        found = segments(run_of(commanded(made, v_x), "trot"))
        assert [s[3:] for s in spans(found)] == [(0.0, True), (0.8, True), (-0.4, True)]
        # a ramp is seen to begin when it has left the tolerance
        assert [s.run.begin for s in found] == pytest.approx([3.0, 5.0, 7.0], abs=0.02)
        assert found[-1].run.end == pytest.approx(9.0)

    def test_a_trembling_stick_rests_and_a_wandering_one_does_not(self):
        made = recording(LIBRARY["trot"], 0.8, seconds=4.0, dt=DT)
        rng = np.random.default_rng(0)
        trembling = 0.8 + rng.uniform(-0.004, 0.004, 800)
        assert [s[4] for s in spans(segments(run_of(commanded(made, trembling), "trot")))] == [True]
        wandering = 0.8 + 0.3 * np.sin(2.0 * np.pi * made.time)
        assert spans(segments(run_of(commanded(made, wandering), "trot"))) == [
            ("trot", 3.0, 7.0, pytest.approx(float(np.median(wandering[-100:]))), False)
        ]

    def test_nothing_is_left_out_and_nothing_counted_twice(self):
        rng = np.random.default_rng(1)
        made = recording(LIBRARY["trot"], 0.8, seconds=8.0, dt=DT)
        v_x = np.repeat(rng.uniform(-1.0, 1.0, 16), rng.multinomial(1600, np.full(16, 1 / 16)))
        gaits = ["trot"] * 333 + ["pace"] * 667 + ["trot"] * 600
        found = segments(run_of(commanded(made, v_x), gaits))
        assert [gait for s in found for gait in s.run.gaits] == gaits
        for before, after in pairwise(found):
            assert after.run.begin == pytest.approx(before.run.end)
        assert min(s.seconds for s in found if s.steady) >= HOLD_S - 1e-9


class TestJudge:
    def test_a_late_gait(self):
        made = recording(LIBRARY["bound"], 0.8, late=0.1, seconds=4.0, dt=DT)
        (segment,) = segments(run_of(made, "bound"))
        found = judge(segment, 1.0)
        assert found["robot"]["lag_s"] == pytest.approx(0.1 * made.period[0], abs=0.005)
        assert found["robot"]["gait_identity"] == 1.0
        assert {key: found["robot"][key] for key in metrics.KEYS} == metrics.summarise(made, "bound")
        assert set(found["robot"]) <= set(KEYS)
        assert (found["truth"], found["estimator"]) == (None, None)

    def test_estimates_against_truth(self):
        made = recording(LIBRARY["trot"], 0.8, seconds=4.0, dt=DT)
        time = made.time
        off = np.stack([0.1 * np.sqrt(2.0) * np.sin(2.0 * np.pi * time), np.full(800, -0.2), 0.0 * time], axis=1)
        contact = made.contact.copy()
        contact[::10, 2] ^= True
        true = replace(made, velocity_h=made.velocity_h + off, contact=contact)
        (segment,) = segments(run_of(made, "trot", true))
        found = judge(segment, 1.0)
        assert found["estimator"] == pytest.approx(
            {"v_x_rms": 0.1, "v_y_rms": 0.2, "yaw_rate_rms": 0.0, "contact_wrong": 0.1 / 4}, abs=1e-6
        )
        assert set(found["estimator"]) <= set(KEYS)
        assert found["truth"]["y_error"] == pytest.approx(0.2)
        assert found["robot"]["y_error"] == pytest.approx(0.0)

    def test_too_short_to_be_judged(self):
        (segment,) = segments(run_of(recording(LIBRARY["trot"], 0.8, seconds=1.6, dt=DT), "trot"))
        assert judge(segment, 1.0)["robot"] is None
        assert judge(segment, 0.5)["robot"]["gc_stance"] == 0.0

    def test_the_other_lead(self):
        made = recording(mirrored(LIBRARY["rotary_gallop"]), 0.8, seconds=4.0, dt=DT)
        (segment,) = segments(run_of(made, "rotary_gallop_mirrored"))
        found = judge(segment, 1.0)
        assert found["gait"] == "rotary_gallop_mirrored"
        assert found["robot"]["gait_identity"] == 1.0

    def test_a_policy_without_time_reversal(self):
        from symdyn.gait.phase import in_swing, leg_phase

        made = recording(LIBRARY["trot"], -1.0, seconds=4.0, dt=DT)
        phases = leg_phase(made.stride_phase, made.offsets, made.velocity_command[:, 0], time_reversal=False)
        stance = ~in_swing(phases, made.duty)
        (segment,) = segments(run_of(replace(made, contact=stance, desired_stance=stance), "trot"))
        assert judge(segment, 1.0)["robot"]["lag_s"] == pytest.approx(0.0, abs=0.003)


def test_by_gait_are_means_of_steady_segments_by_truth_where_it_is_known():
    def judged(gait, speed, cot, steady=True, truth=None):
        robot = None if cot is None else {"cot": cot}
        return {"gait": gait, "command": [speed, 0.0, 0.0], "steady": steady, "robot": robot, "truth": truth}

    found = log_metrics.by_gait(
        [
            judged("trot", 0.79, 0.5),
            judged("trot", 0.8, 0.7),
            judged("trot", 0.8, 9.0, steady=False),
            judged("trot", -0.01, 3.0),
            judged("bound", 0.8, 1.0, truth={"cot": 0.9}),
            judged("pace", 0.8, None),
        ]
    )
    assert found == {"trot": {"0.8": {"cot": pytest.approx(0.6)}, "0": {"cot": 3.0}}, "bound": {"0.8": {"cot": 0.9}}}


def ticks_of(states: list[str], faults: list[str] | None = None, gaits: list[str] | None = None, **columns) -> Ticks:
    made = recording(LIBRARY["trot"], 0.8, seconds=len(states) * DT, dt=DT)
    messages = [tick_of(made, k, "trot" if gaits is None else gaits[k], k + 1) for k in range(len(states))]
    for k, message in enumerate(messages):
        message.state, message.fault = states[k], "" if faults is None else faults[k]
        for name, values in columns.items():
            setattr(message, name, type(getattr(message, name))(values[k]))
    return Ticks.of(messages, 2.0)


class TestTiming:
    def test_percentiles(self):
        n = 1001
        late = np.zeros(n)
        late[500] = 0.002
        ticks = ticks_of(
            ["run"] * n,
            state_age=np.linspace(0.0, 0.01, n),
            time=1000.0 + DT * np.arange(n) + late,
            compute=np.where(np.arange(n) == 700, 0.004, 0.001),
            overruns=np.minimum(np.arange(n) // 300, 2),
        )
        found = log_metrics.timing(ticks)
        assert found["state_age"] == pytest.approx({"p50": 0.005, "p99": 0.0099, "max": 0.01})
        assert found["interval"] == pytest.approx({"p50": 0.005, "p99": 0.005, "max": 0.007})
        assert found["compute"] == pytest.approx({"p50": 0.001, "p99": 0.001, "max": 0.004})
        assert (found["ticks"], found["overruns"]) == (n, 2)

    def test_only_where_the_robot_was_driven(self):
        states = ["passive"] * 100 + ["stand"] * 60 + ["run"] * 40 + ["damp"] * 50
        ages = [1e9] * 100 + [0.001] * 100 + [30.0] * 50
        ticks = ticks_of(states, state_age=ages, compute=[1.0] * 101 + [0.002] * 100 + [0.5] * 49)
        found = log_metrics.timing(ticks)
        assert found["ticks"] == 100
        assert found["state_age"]["max"] == found["state_age"]["p50"] == 0.001
        assert found["compute"]["max"] == 0.002

    def test_nothing_came(self):
        ticks = ticks_of(["passive"] * 10, state_age=[1e9] * 10, joints_number=[0] * 10, imu_number=[0] * 10)
        assert log_metrics.timing(ticks)["state_age"] == {"p50": None, "p99": None, "max": None}


def test_timeline():
    states = ["stand"] * 10 + ["run"] * 20 + ["damp"] * 10 + ["passive"] * 5
    faults = [""] * 30 + ["tilt: 0.71 rad"] * 5 + ["tilt: 0.9 rad"] * 5 + [""] * 5
    gaits = ["trot"] * 20 + ["bound"] * 25
    time = 10.0 + DT * np.arange(45) + 0.1 * (np.arange(45) >= 25)
    found = log_metrics.timeline(ticks_of(states, faults, gaits, time=time))
    told = [(round(m["time"], 3), m["state"], m["fault"], m["gait"]) for m in found]
    assert told == [
        (2.0, "stand", "", ""),
        (2.05, "run", "", "trot"),
        (2.1, "run", "", "bound"),
        (2.225, "run", "", "bound"),
        (2.25, "damp", "tilt: 0.71 rad", ""),
        (2.3, "passive", "", ""),
    ]
    assert [None if m["gap"] is None else round(m["gap"], 3) for m in found] == [None, None, None, 0.105, None, None]
