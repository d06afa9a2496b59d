"""A simulated robot, the person at its joystick and what goes wrong, period by period; without clock and network."""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass
from typing import Any

from hardware.robot_sim.effects import Effect
from hardware.robot_sim.faults import get_fault
from hardware.robot_sim.joystick_operator import JoystickOperator, Seen
from hardware.robot_sim.scenarios import Scenario
from hardware.robot_sim.settings import PERIOD, Since
from hardware.robot_sim.simulated_robot import SimulatedRobot
from hardware.robot_sim.target_monitor import TargetMonitor
from hardware.wire.channels import IMU, JOINTS, JOYSTICK, TRUTH
from hardware.wire.messages import leg_control_data_lcmt, pd_tau_targets_lcmt
from hardware.wire.readings import Joints
from symdyn.errors import InvalidValue

_log = logging.getLogger(__name__)

TRUTH_EVERY = 5
"""Periods between two messages of the truth: 100 Hz."""

FALLEN_HEIGHT, FALLEN_TILT = 0.18, 0.8
"""m and rad; a robot told to run that is lower or more tilted has fallen (as in training: rl.task.termination)."""


@dataclass(frozen=True)
class PlannedFault:
    """What shall go wrong, and when.

    Attributes:
        name: of :data:`hardware.robot_sim.faults.FAULTS`.
        at: when, s.
        since: what ``at`` counts from: the start of the simulator, the first targets of Stand, or those of Run.
        lasts: s, or None for as long as is usual for this fault.
        size: how much, or None for what is usual.

    Raises:
        UnknownName: if there is no such fault.
        InvalidValue: if a number is out of range.
    """

    name: str
    at: float = 1.0
    since: Since = "start"
    lasts: float | None = None
    size: float | None = None

    def __post_init__(self) -> None:
        get_fault(self.name)
        if not 0.0 <= self.at < math.inf:
            raise InvalidValue("--fault-at", self.at, "a time >= 0, s")
        if self.lasts is not None and not self.lasts > 0.0:
            raise InvalidValue("--fault-for", self.lasts, "a time > 0, s")
        if self.size is not None and not math.isfinite(self.size):
            raise InvalidValue("--fault-size", self.size, "a number")


class Rig:
    """All that there is on the robot's side of the protocol.

    Args:
        robot: to be simulated.
        scenario: what the person does.
        fault: what goes wrong, or None.
        seed: of what is random in the fault.

    Attributes:
        robot: the simulated robot.
        person: at the joystick.
        monitor: of the targets that came.
        fault_began: by the caller's clock, s, or None.
        damping_after_fault: when the first damping targets came after that, s, or None.
        max_tilt: of the trunk, rad.
        fell_at: time of the simulation, s, or None.
    """

    def __init__(
        self, robot: SimulatedRobot, scenario: Scenario, fault: PlannedFault | None = None, seed: int = 0
    ) -> None:
        self.robot = robot
        self.person = JoystickOperator(scenario.steps)
        self.monitor = TargetMonitor(robot.robot, robot.joint_range, robot.torque_limit)
        self.fault_began: float | None = None
        self.damping_after_fault: float | None = None
        self.max_tilt = 0.0
        self.fell_at: float | None = None
        self._plan: PlannedFault | None = None
        self._effect: Effect | None = None
        self._begins_at: float | None = None
        self._lasts = self._ends_at = math.inf
        self._active = self._over = False
        self._ticks = 0
        self._doing = ""
        if fault is not None:
            self.plan(fault, seed)

    def plan(self, fault: PlannedFault, seed: int = 0) -> None:
        """Let something go wrong; to be called once, before what the fault counts from.

        Args:
            fault: what goes wrong.
            seed: of what is random in it.
        """
        kind = get_fault(fault.name)
        self._plan = fault
        self._effect = kind.effect(kind.size if fault.size is None else fault.size, self.robot, seed)
        self._lasts = kind.lasts if fault.lasts is None else fault.lasts
        self._begins_at = fault.at if fault.since == "start" else None

    def receive(self, now: float, message: pd_tau_targets_lcmt) -> None:
        """Targets have come, at ``now`` s of the caller's clock."""
        before = self.monitor.mode
        self.monitor.received(now, message)
        mode = self.monitor.mode
        if mode != before:
            _log.info("%7.2f s: the targets ask for %s", self.robot.time, mode)
            self._time_fault(mode)
        began = self.fault_began
        if mode == "damping" and began is not None and now >= began and self.damping_after_fault is None:
            self.damping_after_fault = now
        self.robot.command(self._effect.incoming(message) if self._active and self._effect else message)

    def tick(self, now: float) -> list[tuple[str, bytes]]:
        """One period of the messages: the physics goes on, and what is to be published comes back."""
        self.robot.step()
        self._ticks += 1
        self.monitor.measured(self.robot.measured_joints)
        self._watch()
        self._begin_or_end_fault(now)
        seen = Seen(self.robot.time, self.robot.height, self.robot.speed, self.monitor.mode)
        messages = {JOINTS: self.robot.joints(), IMU: self.robot.imu(), JOYSTICK: self.person.message(seen)}
        if self.person.doing != self._doing:
            self._doing = self.person.doing
            _log.info("%7.2f s: the person %s", self.robot.time, self._doing)
        published = [pair for channel, message in messages.items() for pair in self._publish(channel, message)]
        if self._active and self._effect is not None:
            published += self._effect.besides()
        if self._ticks % TRUTH_EVERY == 0:
            published.append((TRUTH, self.robot.truth().encode()))
        return published

    def damaged(self, low_state: bytes) -> bytes:
        """What goes over DDS instead of a LowState, as the fault has it."""
        return self._effect.damaged(low_state) if self._active and self._effect is not None else low_state

    def _publish(self, channel: str, message: Any) -> list[tuple[str, bytes]]:
        sent = (message,)
        if self._active and self._effect is not None:
            sent = self._effect.outgoing(channel, message)
            for one in sent:
                if isinstance(one, leg_control_data_lcmt):
                    self.monitor.said(Joints.of(one))
        # not through hardware.wire.channels.encode: a fault may want to send NaN
        return [(channel, one.encode()) for one in sent]

    def _watch(self) -> None:
        tilt = self.robot.tilt
        self.max_tilt = max(self.max_tilt, tilt)
        down = self.robot.height < FALLEN_HEIGHT or tilt > FALLEN_TILT
        if self.fell_at is None and self.monitor.mode == "running" and down:
            self.fell_at = self.robot.time
            _log.info("%7.2f s: the robot has fallen", self.robot.time)

    def _time_fault(self, mode: str) -> None:
        plan = self._plan
        if plan is not None and self._begins_at is None and mode == {"stand": "standing", "run": "running"}[plan.since]:
            self._begins_at = self.robot.time + plan.at

    def _begin_or_end_fault(self, now: float) -> None:
        if self._effect is None or self._plan is None or self._begins_at is None or self._over:
            return
        time = self.robot.time + PERIOD / 2
        if not self._active and time >= self._begins_at:
            self._active, self.fault_began = True, now
            self._ends_at = self._begins_at + self._lasts
            self._effect.begin()
            _log.info("%7.2f s: fault %s begins", self.robot.time, self._plan.name)
        elif self._active and time >= self._ends_at:
            self._active, self._over = False, True
            self._effect.end()
            _log.info("%7.2f s: fault %s is over", self.robot.time, self._plan.name)
