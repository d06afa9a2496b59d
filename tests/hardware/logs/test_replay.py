"""What a log gives back to the controller: every time with all its bits."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from hardware.control.controller import Controller, Inputs, Request
from hardware.control.settings import TICK_HZ, Settings
from hardware.logs.replay import replay
from hardware.running.deadline_loop import DeadlineLoop
from hardware.running.session import Session
from hardware.running.tick_record import record
from hardware.wire import clock
from hardware.wire.channels import IMU, JOINTS, SESSION, TICK
from hardware.wire.event_log import LogReader, LogWriter
from hardware.wire.link import Link
from hardware.wire.messages import leg_control_data_lcmt, state_estimator_lcmt
from tests.hardware.control.lockstep import shipped

A_YEAR_US = 366 * 24 * 3600 * 1_000_000

MOMENTS = st.integers(0, A_YEAR_US)
"""us since a computer was started."""


@given(MOMENTS, MOMENTS, MOMENTS)
def test_a_log_gives_back_a_time_with_all_its_bits(arrival, tick, first):
    # the log has whole microseconds since its first event, the tick in it the time by the clock
    from_log = tick / 1e6 + ((arrival - first) / 1e6 - (tick - first) / 1e6)
    assert clock.whole_microseconds(from_log) == arrival / 1e6


@given(st.floats(0.0, A_YEAR_US / 1e6))
def test_no_time_is_moved_by_more_than_half_a_microsecond(seconds):
    assert abs(clock.whole_microseconds(seconds) - seconds) <= 0.5e-6 + 1e-8  # and by what a float of a year leaves out


def test_the_age_of_a_state_has_the_same_bits_in_replay(tmp_path: Path):
    settings, loop = Settings(), DeadlineLoop(1.0 / TICK_HZ)
    controller, session = Controller(shipped(), settings), Session("policy.onnx", "", settings, False, 2, "unknown")
    imu = state_estimator_lcmt()
    imu.quat = [1.0, 0.0, 0.0, 0.0]
    ages = set()
    with LogWriter(tmp_path / "run.lcmlog") as log:
        log.append(SESSION, session.message().encode(), clock.now())
        link = Link("memq://", [], on_message=lambda channel, data, arrival, _: log.append(channel, data, arrival))
        for _ in range(200):
            link.take(JOINTS, leg_control_data_lcmt().encode())
            link.take(IMU, imu.encode())
            now, inputs = clock.now(), Inputs(link.latest(JOINTS), link.latest(IMU), None, Request.NONE)
            tick = controller.tick(now, inputs)
            loop.ticks += 1
            log.append(TICK, record(now, inputs, tick, loop, 0, 0.0).encode(), now)
            ages.add(tick.state_age)
    found = replay(LogReader(tmp_path / "run.lcmlog"), session, shipped())
    assert (found.ticks, found.different, found.problems) == (200, 0, []), dataclasses.asdict(found)
    assert len(ages) > 20
