"""The deployer's mind: from the newest messages to the next targets. No threads, no clock, no network in here.

    Passive --R1--> Stand --R1--> Run, or Identify
                      |            |      a fault, a stop button, a signal
                      +--> Damp <--+
    Passive <--L1---- Damp

All that decides comes in through :meth:`Controller.tick`, so that a log can be put through it again.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import IntFlag, StrEnum

import numpy as np

from hardware.control.excitation import RATE, Excitation
from hardware.control.faults import Fault
from hardware.control.health import Health
from hardware.control.joystick import check_gaits
from hardware.control.limits import damping, limited
from hardware.control.settings import TICK_HZ, Settings
from hardware.control.stand_up import StandUp
from hardware.control.velocity_command import VelocityCommand
from hardware.estimation.contact import FootContact
from hardware.estimation.kinematics import JointLimits, LegKinematics
from hardware.estimation.velocity import Estimate, VelocityEstimator
from hardware.wire.link import Received
from hardware.wire.readings import Floats, Imu, Joints, Joystick, Targets
from symdyn.errors import InvalidValue
from symdyn.gait.library import Gait
from symdyn.policy.driver import PolicyDriver
from symdyn.policy.file import Policy
from symdyn.policy.observation import Sensed
from symdyn.robot.frames import yaw

_log = logging.getLogger(__name__)


class State(StrEnum):
    """What the deployer is doing.

    PASSIVE sends nothing. STAND stands the robot up and waits. RUN runs the policy. IDENTIFY moves
    every joint by a script. DAMP streams damping.
    """

    PASSIVE = "passive"
    STAND = "stand"
    RUN = "run"
    IDENTIFY = "identify"
    DAMP = "damp"


class Request(IntFlag):
    """What came from inside the deployer; logged as bits."""

    NONE = 0
    STOP = 1
    """SIGINT or SIGTERM: damp."""
    LEAVE = 2
    """The same again: Passive, if damping."""
    RECEIVER_DEAD = 4
    OVERRUN = 8
    SECOND_DEPLOYER = 16
    WATCHDOG = 32


REQUEST_FAULTS = {
    Request.STOP: "stop_requested",
    Request.RECEIVER_DEAD: "receiver_dead",
    Request.OVERRUN: "overrun",
    Request.SECOND_DEPLOYER: "second_deployer",
    Request.WATCHDOG: "watchdog",
}
"""The fault of each request that is one."""


@dataclass(frozen=True)
class Inputs:
    """All that a tick may know.

    Attributes:
        joints: the newest joint message, or None before the first.
        imu: the newest IMU message.
        joystick: the newest joystick message.
        requests: from inside the deployer.
    """

    joints: Received | None
    imu: Received | None
    joystick: Received | None
    requests: Request = Request.NONE


@dataclass(frozen=True)
class Tick:
    """What a tick came to.

    Attributes:
        state: after the tick.
        targets: to send now, or None (Passive).
        fault: why the robot is damped (Damp), or what stands in the way of standing up (Passive), or None.
        ready: whether R1 would go on; in Identify, whether the script is at its end.
        acted: whether the policy ran.
        gait: commanded.
        velocity_command: (3,) v_x, v_y (m/s), yaw rate (rad/s).
        phase: stride phase in [0, 1).
        period: s.
        duty: duty factor.
        action: (12,) the policy's last.
        contact: (4,) bool, which feet bear load.
        desired_stance: (4,) bool, which should.
        estimate: of the trunk's velocity, or None without a state to estimate from.
        state_age: of the older of joints and IMU, s; infinite before both are there.
        contact_source: what tells of contacts, ``force`` or ``torque``.
    """

    state: State
    targets: Targets | None
    fault: Fault | None
    ready: bool
    acted: bool
    gait: Gait
    velocity_command: Floats
    phase: float
    period: float
    duty: float
    action: Floats
    contact: np.ndarray
    desired_stance: np.ndarray
    estimate: Estimate | None
    state_age: float
    contact_source: str = "force"


class Controller:
    """Passive, Stand, Run, Damp; at 200 ticks a second, of which every fourth runs the policy.

    Args:
        policy: to run.
        settings: limits, buttons, gains.
        dry: whether nothing is sent, so that the robot cannot be expected to answer.

    Raises:
        InvalidValue: if a button's gait is of no class that the policy was trained on, or the policy's control step is
            no multiple of a tick.
        PolicyMismatch: if the policy observes what the messages do not tell.
        FileProblem, ResourceProblem: if the robot's URDF is missing.
    """

    def __init__(self, policy: Policy, settings: Settings, dry: bool = False) -> None:
        check_gaits(settings.joystick, policy)
        meta = policy.metadata
        self.policy, self.settings, self._dry = policy, settings, dry
        kinematics = LegKinematics(policy.robot)
        self._kinematics = kinematics
        self.limits = JointLimits.of(policy.robot)
        self.mass = kinematics.mass
        place = settings.identify
        self._excitation = None if place == "no" else Excitation(policy.robot, self.limits, place)
        self._gaits = settings.joystick.gaits()
        self._stance = np.array(meta.default_joint_pos)
        self._health = Health(self.limits, settings.safety)
        self._driver = PolicyDriver(policy)
        self._velocity = VelocityCommand(meta)
        self._contact = FootContact(settings.contact, kinematics)
        self._estimator = VelocityEstimator(kinematics, settings.estimator)
        self._ticks_per_action = policy_ticks(meta.control_dt)
        ones = np.ones(len(self._stance))
        self._run_gains = Targets(self._stance, meta.kp * ones, meta.kd * ones)
        self.state = State.PASSIVE
        self._fault: Fault | None = None
        self._stand: StandUp | None = None
        self._stood = False
        self._began = 0.0
        self._last_time: float | None = None
        self._ticks_in_run = 0
        self._wanted = self._stance
        self._sent = self._stance
        self._held: frozenset[str] | None = None
        self._gait = self._gaits[next(iter(self._gaits))]

    def tick(self, now: float, inputs: Inputs, send: Callable[[Targets], object] | None = None) -> Tick:
        """One tick.

        Args:
            now: s, the clock of the arrivals.
            inputs: the newest messages.
            send: called with the targets as soon as they are known, before what only display and log want is computed.
        """
        dt = 1.0 / TICK_HZ if self._last_time is None else now - self._last_time
        self._last_time = now
        joints = None if inputs.joints is None else Joints.of(inputs.joints.message)
        imu = None if inputs.imu is None else Imu.of(inputs.imu.message)
        joystick = None if inputs.joystick is None else Joystick.of(inputs.joystick.message)
        state_fault = self._health.state_fault(now, inputs.joints, inputs.imu, joints, imu)
        joystick_fault = self._health.joystick_fault(now, inputs.joystick, joystick)
        fault = self._requested(inputs.requests) or state_fault or joystick_fault
        known = joints if state_fault is None else None
        pressed: frozenset[str] = frozenset()
        asked = (0.0, 0.0, 0.0)
        if joystick is not None and joystick_fault is None:
            # a button that is held when the joystick is first heard, or heard again, was not pressed for us
            pressed = frozenset() if self._held is None else joystick.held - self._held
            self._held = joystick.held
            self._gait = self._gaits[joystick.button]
            asked = self.settings.joystick.velocity(joystick)
            if joystick.held & set(self.settings.joystick.stop) and fault is None:
                fault = Fault("emergency_stop", " ".join(sorted(joystick.held)))
        else:
            self._held = None
        self._transit(now, fault, known, pressed, bool(inputs.requests & Request.LEAVE))
        acted = False
        targets = None
        if self.state is State.RUN and joints is not None and imu is not None:
            targets, acted = self._run(dt, asked, joints, imu)
        elif self.state is State.STAND and joints is not None and imu is not None:
            targets = self._stand_targets(now, dt, joints, imu)
        elif self.state is State.IDENTIFY and joints is not None:
            targets = self._identify(now, dt, joints)
        if self.state is State.DAMP:  # from the start of this tick, or since a moment ago
            # joints that tell of a fault still tell how fast they are, and so how much damping their motors can give
            fresh = inputs.joints is not None and now - inputs.joints.arrival <= self.settings.safety.stale_s
            seen = joints if fresh and joints is not None and joints.finite() else None
            at = self._sent if seen is None else seen.pos
            targets = damping(seen, at, self.limits, self.settings.safety)
        if targets is not None:
            self._sent = targets.pos
            if send is not None:
                send(targets)
        return self._told(inputs, targets, fault, acted, dt, joints, imu, state_fault is None, now)

    def fail(self, error: Exception) -> Targets:
        """An exception left :meth:`tick`: damp from now on. The targets to send."""
        self._enter(State.DAMP, Fault("internal_error", f"{type(error).__name__}: {error}"))
        return damping(None, self._stance, self.limits, self.settings.safety)

    @property
    def fault(self) -> Fault | None:
        """Why the robot is damped, or was last."""
        return self._fault

    def _requested(self, requests: Request) -> Fault | None:
        if requests:  # rarely; and the bits of a flag are slow to ask for
            for request, name in REQUEST_FAULTS.items():
                if requests & request:
                    return Fault(name)
        return None

    def _transit(
        self, now: float, fault: Fault | None, joints: Joints | None, pressed: frozenset[str], leave: bool
    ) -> None:
        on = self.settings.joystick.next_state in pressed
        match self.state:
            case State.PASSIVE if on and fault is None and joints is not None:
                self._enter(State.STAND, None)
                self._began, self._stood = now, False
                self._sent = joints.pos
                self._stand = StandUp(
                    joints.pos, self._stance, self.settings.stand, self.settings.safety, self._kinematics
                )
            case State.STAND | State.RUN | State.IDENTIFY if fault is not None:
                self._enter(State.DAMP, fault)
            case State.STAND if on and self._stood and self._excitation is not None:
                self._enter(State.IDENTIFY, None)
                self._began = now
            case State.STAND if on and self._stood:
                self._enter(State.RUN, None)
                self._ticks_in_run = 0
                self._driver = PolicyDriver(self.policy)
                self._velocity.stand_still()
            case State.DAMP if self.settings.joystick.to_passive in pressed or leave:
                self._enter(State.PASSIVE, self._fault)

    def _enter(self, state: State, fault: Fault | None) -> None:
        _log.info("%s -> %s%s", self.state, state, f" ({fault})" if fault is not None else "")
        self.state, self._fault = state, fault

    def _stand_targets(self, now: float, dt: float, joints: Joints, imu: Imu) -> Targets:
        assert self._stand is not None
        time = now - self._began
        self._stand.observe(time, joints, imu)
        if time >= self._stand.duration and not self._stood:
            verdict = None if self._dry else self._stand.verdict(joints)
            if verdict is not None:
                self._enter(State.DAMP, verdict)
            self._stood = verdict is None
        return limited(self._stand.targets(time), self._sent, dt, joints, self.limits, self.settings.safety)

    def _identify(self, now: float, dt: float, joints: Joints) -> Targets:
        assert self._excitation is not None
        wanted = Targets(self._excitation.positions(now - self._began), self._run_gains.kp, self._run_gains.kd)
        safety = self.settings.safety
        slow = replace(safety, target_rate=min(safety.target_rate, RATE))
        return limited(wanted, self._sent, dt, joints, self.limits, slow)

    def _run(self, dt: float, asked: tuple[float, float, float], joints: Joints, imu: Imu) -> tuple[Targets, bool]:
        driver = self._driver
        if self._ticks_in_run:
            driver.advance(dt)
        driver.offsets[:] = self._gait.theta
        driver.velocity[:] = self._velocity.towards(asked, dt)
        acts = self._ticks_in_run % self._ticks_per_action == 0
        self._ticks_in_run += 1
        if acts:
            try:
                wanted = driver.act(_sensed(joints, imu))[0]
            except Exception as error:  # onnxruntime's errors have no base class of their own
                self._enter(State.DAMP, Fault("policy_failed", f"{type(error).__name__}: {error}"))
                return self._run_gains, True
            if not np.isfinite(wanted).all():
                self._enter(State.DAMP, Fault("policy_failed", "an action is not finite"))
                return self._run_gains, True
            self._wanted = wanted
        targets = Targets(self._wanted, self._run_gains.kp, self._run_gains.kd)
        return limited(targets, self._sent, dt, joints, self.limits, self.settings.safety), acts

    def _told(
        self,
        inputs: Inputs,
        targets: Targets | None,
        fault: Fault | None,
        acted: bool,
        dt: float,
        joints: Joints | None,
        imu: Imu | None,
        sound: bool,
        now: float,
    ) -> Tick:
        contact = np.zeros(len(self._driver.offsets[0]), dtype=bool)
        estimate = None
        if sound and joints is not None and imu is not None:
            contact = self._contact.update(imu, joints, dt)
            estimate = self._estimator.update(dt, imu, joints, contact)
        else:
            self._estimator.reset()
        timing = self._driver.timing()
        over = (
            self.state is State.IDENTIFY
            and self._excitation is not None
            and now - self._began >= self._excitation.duration
        )
        arrivals = [np.inf if received is None else now - received.arrival for received in (inputs.joints, inputs.imu)]
        return Tick(
            state=self.state,
            targets=targets,
            fault=fault if self.state is State.PASSIVE else self._fault,
            ready=(self.state is State.PASSIVE and fault is None)
            or (self.state is State.STAND and self._stood)
            or over,
            acted=acted,
            gait=self._gait,
            velocity_command=self._driver.command[0].copy(),
            phase=float(self._driver.phase[0]),
            period=float(timing.period[0]),
            duty=float(timing.duty[0]),
            action=self._driver.action[0].copy(),
            contact=contact,
            desired_stance=timing.desired_stance[0],
            estimate=estimate,
            state_age=float(max(arrivals)),
            contact_source=self._contact.source,
        )


def _sensed(joints: Joints, imu: Imu) -> Sensed:
    """What the messages tell of one robot: every sensor that an observation can need."""
    heading = np.array([yaw(imu.quat_w)])
    return Sensed(imu.gravity_b[None], joints.pos[None], joints.vel[None], imu.angular_velocity_b[None], heading)


def policy_ticks(control_dt: float) -> int:
    """Ticks from one action to the next.

    Raises:
        InvalidValue: if the control step is no multiple of a tick.
    """
    ticks = control_dt * TICK_HZ
    if abs(ticks - round(ticks)) > 1e-6 or round(ticks) < 1:
        raise InvalidValue("The policy's control step", control_dt, f"a multiple of {1.0 / TICK_HZ:g} s")
    return round(ticks)
