"""What the motors are told, event by event."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hardware.bridge.relay import Relay, State
from hardware.bridge.settings import GENTLE_KP, PERIOD, SILENCE_S, STALL_S
from hardware.dds.messages import LOW_CMD_CODEC, damps, targets_message
from hardware.wire.messages import pd_tau_targets_lcmt

KD = 4.0


def targets(kp: float = 40.0) -> pd_tau_targets_lcmt:
    message = pd_tau_targets_lcmt()
    message.q_des, message.qd_des = [0.1 * i for i in range(12)], [0.01 * i for i in range(12)]
    message.tau_ff, message.kp, message.kd = [0.5] * 12, [kp] * 12, [1.0] * 12
    return message


class Played:
    """A relay and the time; what it wrote and when."""

    def __init__(self) -> None:
        self.relay, self.now, self.written = Relay(KD), 100.0, []

    def take(self, message: pd_tau_targets_lcmt) -> None:
        self._write(self.relay.take(self.now, message))

    def ticks(self, seconds: float) -> None:
        for _ in range(round(seconds / PERIOD)):
            self.now += PERIOD
            self._write(self.relay.tick(self.now))

    def run(self, seconds: float, kp: float = 40.0) -> None:
        """With targets at 200 Hz."""
        for _ in range(round(seconds / 0.005)):
            self.now += 0.001
            self.take(targets(kp))
            self.ticks(0.004)

    def _write(self, data: bytes | None) -> None:
        if data is not None:
            self.written.append((self.now, LOW_CMD_CODEC.decode(data)))
            self.relay.wrote(self.now)

    @property
    def damping(self) -> bool:
        motors = self.written[-1][1]["motor_cmd"][:12]
        return damps(self.written[-1][1]) and (motors["kd"] == KD).all() and not motors["dq"].any()


@pytest.fixture
def running() -> Played:
    played = Played()
    played.run(0.5)
    assert played.relay.state is State.FORWARDING and not played.damping
    return played


def test_nothing_is_sent_before_the_first_targets():
    played = Played()
    played.ticks(1.0)
    assert not played.written and played.relay.state is State.WAITING


def test_targets_go_out_at_once_and_unchanged():
    played = Played()
    played.take(targets())
    ((at, command),) = played.written
    assert at == played.now and LOW_CMD_CODEC.crc_fits(command)
    back, meant = targets_message(command), targets()
    for field in ("q_des", "qd_des", "tau_ff", "kp", "kd"):
        assert getattr(back, field) == np.float32(getattr(meant, field)).tolist()


def test_they_are_repeated_500_times_a_second(running):
    times = [at for at, _ in running.written]
    assert len(times) == pytest.approx(0.5 / PERIOD, rel=0.25)
    assert np.diff(times).max() <= PERIOD + 1e-9


def test_silence_is_damping_after_100_ms_and_not_before(running):
    running.ticks(SILENCE_S - 0.01)
    assert not running.damping
    running.ticks(0.02)
    assert running.damping and running.relay.state is State.SILENCE


def test_after_a_silence_stiff_targets_are_not_forwarded_and_gentle_ones_are(running):
    running.ticks(0.2)
    running.take(targets())
    running.ticks(0.02)
    assert running.damping and running.relay.ignored == 1
    running.take(targets(kp=GENTLE_KP))
    assert not running.damping and running.relay.state is State.FORWARDING
    running.run(0.1)
    assert not running.damping


@pytest.mark.parametrize("value", [math.nan, math.inf])
@pytest.mark.parametrize("field", ["q_des", "qd_des", "tau_ff", "kp", "kd"])
def test_targets_that_are_not_finite_are_refused_and_count_as_silence(running, field, value):
    bad = targets()
    getattr(bad, field)[7] = value
    for _ in range(30):
        running.take(bad)
        running.ticks(0.004)
    assert running.relay.refused == 30
    assert running.damping
    assert all(np.isfinite(command["motor_cmd"]["q"]).all() for _, command in running.written)


@pytest.mark.parametrize("first", ["take", "tick"])
def test_a_bridge_that_stood_still_damps_for_good_whatever_it_hears_first(running, first):
    before = len(running.written)
    running.now += STALL_S + 0.001
    if first == "take":
        running.take(targets(kp=0.0))
    running.ticks(0.02)
    assert all(damps(command) for _, command in running.written[before:])
    running.run(0.2, kp=0.0)
    assert running.relay.state is State.LATCHED and running.damping
    assert "stalled" in running.relay.why


def test_latched_it_damps_for_good_and_keeps_the_first_reason(running):
    running.relay.latch("first")
    running.relay.latch("second")
    running.run(0.3)
    running.run(0.3, kp=0.0)
    assert running.damping and running.relay.why == "first"


def test_latched_before_the_first_targets_it_sends_nothing():
    played = Played()
    played.relay.latch("another program commands the motors")
    played.run(0.1)
    assert not played.written
