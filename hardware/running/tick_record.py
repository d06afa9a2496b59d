"""A tick as the log keeps it."""

from __future__ import annotations

from hardware.control.controller import Inputs, Tick
from hardware.running.deadline_loop import DeadlineLoop
from hardware.wire.link import Received
from hardware.wire.messages import controller_tick_lcmt

_FOR_EVER = 1e9  # s; an age that is infinite is no number for a log


def _number_of(received: Received | None) -> int:
    return 0 if received is None else received.number


def record(
    now: float, inputs: Inputs, tick: Tick, loop: DeadlineLoop, sent: int, compute: float
) -> controller_tick_lcmt:
    """The message of a tick.

    Args:
        now: when it was, s of hardware.wire.clock.
        inputs: what it knew.
        tick: what it came to.
        loop: counts ticks and overruns.
        sent: number of the last targets.
        compute: how long the tick before took, s.
    """
    message = controller_tick_lcmt()
    message.tick, message.time = loop.ticks, now
    message.joints_number, message.imu_number = _number_of(inputs.joints), _number_of(inputs.imu)
    message.joystick_number = _number_of(inputs.joystick)
    message.targets_number = sent if tick.targets is not None else 0
    message.requests = int(inputs.requests)
    message.state, message.fault = str(tick.state), "" if tick.fault is None else str(tick.fault)
    message.acted, message.gait = tick.acted, tick.gait.name
    message.velocity_command = tick.velocity_command.tolist()
    message.phase, message.period, message.duty = tick.phase, tick.period, tick.duty
    message.action = tick.action.tolist()
    if tick.estimate is not None:
        message.velocity_estimate_h = tick.estimate.velocity_h.tolist()
    message.contact, message.desired_stance = tick.contact.tolist(), tick.desired_stance.tolist()
    message.state_age = min(tick.state_age, _FOR_EVER)
    message.compute, message.overruns = compute, loop.overruns
    return message
