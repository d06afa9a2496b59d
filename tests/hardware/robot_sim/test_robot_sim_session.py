"""A rig in real time: late periods are simulated but not published, and a stall is not caught up with."""

from __future__ import annotations

import threading
import time

import pytest

from hardware.robot_sim.ends import LcmEnd
from hardware.robot_sim.rig import Rig
from hardware.robot_sim.scenarios import get_scenario
from hardware.robot_sim.session import STALL_S, Session
from hardware.robot_sim.settings import PERIOD
from hardware.wire.channels import JOINTS, TARGETS
from hardware.wire.link import Link
from tests.hardware.lcm_urls import multicast_url
from tests.hardware.robot_sim.simulated import go2


class SlowRig(Rig):
    """One that takes its time in some periods.

    Args:
        every: in every so many, and not in the first.
        pause: s.
    """

    def __init__(self, every: int, pause: float) -> None:
        super().__init__(go2(), get_scenario("idle"))
        self._every, self._pause, self._count = every, pause, 0

    def tick(self, now: float) -> list[tuple[str, bytes]]:
        self._count += 1
        if self._count % self._every == 0:
            time.sleep(self._pause)
        return super().tick(now)


def run(rig: Rig, duration: float) -> tuple[Session, list[float]]:
    """The session after its end, and when joint messages arrived."""
    url, arrivals = multicast_url(), []
    listener = Link(url, [JOINTS], lambda _, __, arrival, ___: arrivals.append(arrival))
    listener.start()
    session = Session(LcmEnd(url), rig)
    session.run(duration, threading.Event())
    end = time.monotonic() + 10.0
    while len(arrivals) < session.pace.periods - session.pace.late and time.monotonic() < end:
        time.sleep(0.01)
    listener.close()
    return session, arrivals


def test_late_periods_are_simulated_and_left_out_so_that_there_is_no_burst():
    session, arrivals = run(SlowRig(every=50, pause=0.02), 1.0)
    pace = session.pace
    assert pace.periods == round(1.0 / PERIOD)
    assert pace.worst_lateness > 0.015
    # ten times 20 ms, of which each makes some nine periods late
    assert pace.late > 50
    assert len(arrivals) == pace.periods - pace.late
    assert pace.stalled == 0.0
    # caught up: simulated time is the time that has passed
    assert session.rig.robot.time == pytest.approx(pace.wall, abs=0.1 + pace.worst_lateness)


def test_a_stall_is_given_up_and_not_caught_up_with():
    session, _ = run(SlowRig(every=150, pause=STALL_S + 0.3), 0.5)
    assert session.pace.stalled > STALL_S
    assert session.rig.robot.time == pytest.approx(session.pace.wall - session.pace.stalled, abs=0.3)


def test_targets_reach_the_robot_and_wrong_bytes_do_not():
    url = multicast_url()
    session, stop, sender = Session(LcmEnd(url), Rig(go2(), get_scenario("idle"))), threading.Event(), Link(url, [])
    thread = threading.Thread(target=session.run, args=(30.0, stop))
    thread.start()
    try:
        end = time.monotonic() + 20.0
        while session.rig.monitor.count == 0 and time.monotonic() < end:
            sender.send_bytes(TARGETS, b"no targets")
            sender.send(TARGETS, _limp())
            time.sleep(0.01)
    finally:
        stop.set()
        thread.join()
    told = session.summary()["targets"]
    assert told["received"] == session.rig.monitor.count > 0
    assert told["refused"] > 0
    assert session.rig.monitor.mode == "limp"


def test_the_deadline_is_the_end_of_a_period():
    session, arrivals = run(Rig(go2(), get_scenario("idle")), 0.4)
    assert session.pace.periods == round(0.4 / PERIOD)
    assert arrivals[-1] >= session.pace.began + 0.4 - PERIOD * session.pace.late


def _limp():
    from hardware.wire.messages import pd_tau_targets_lcmt

    return pd_tau_targets_lcmt()
