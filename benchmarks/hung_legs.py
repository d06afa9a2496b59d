"""Logs of a robot whose trunk is clamped and whose legs hang: each leg simulated by itself in MuJoCo, not by the clock.

Written apart from the simulated robot of hardware.robot_sim, so that both check each other: motors' law, delays and
reports are computed here from their definitions (symdyn.robot.fit.JointFit).
"""

# mujoco is a compiled module without stubs
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain

import mujoco
import numpy as np

from hardware.control.controller import State
from hardware.control.excitation import MOVE_S, RATE, TURN_S, Excitation
from hardware.control.limits import limited
from hardware.control.settings import SafetyConfig, Settings
from hardware.estimation.kinematics import JointLimits
from hardware.identification.signals import Signals
from hardware.robot_sim.sensors import SensorNoise
from hardware.running.session import Session
from hardware.wire.channels import IMU, SESSION, TARGETS, TICK
from hardware.wire.channels import JOINTS as JOINT_STATES
from hardware.wire.messages import controller_tick_lcmt, leg_control_data_lcmt, state_estimator_lcmt
from hardware.wire.readings import Floats, Joints, Targets
from hardware.wire.sdk_order import JOINTS_TO_SDK
from rl.physics.model import build_spec
from symdyn.gait.timing import GRAVITY
from symdyn.robot.definition import Robot
from symdyn.robot.fit import Fit
from symdyn.robot.legs import JOINTS, LEG_JOINTS, LEGS

STEP = 0.002
MESSAGE = 0.002
TICK_S = 0.005
SENDER = 2


@dataclass(frozen=True, eq=False)
class Turn:
    """A leg during its part of the excitation.

    Attributes:
        time: (N,) of the messages, s.
        pos: (N, 3) as the encoders show it, rad.
        vel: (N, 3) rad/s.
        torque: (N, 3) as the motors report it, N m.
        sent: (K,) when targets were sent, s.
        targets: (K, 12) rad.
    """

    time: Floats
    pos: Floats
    vel: Floats
    torque: Floats
    sent: Floats
    targets: Floats


def clamped_leg(robot: Robot, fit: Fit, leg: str) -> mujoco.MjModel:
    """One leg of the trainer's model with a machine's joints, its trunk fixed in the air."""
    spec = build_spec(robot)
    for other in LEGS:
        if other != leg:
            first = robot.joint_names[JOINTS.index(f"{other}_{LEG_JOINTS[0]}")]
            for joint in LEG_JOINTS:
                spec.delete(spec.actuator(f"{other}_{joint}"))
            for sensor in [s for s in spec.sensors if s.name.startswith(f"{other}_")]:
                spec.delete(sensor)
            spec.delete(spec.joint(first).parent)
    spec.delete(spec.body(robot.trunk).first_joint())
    model = spec.compile()
    model.opt.timestep = STEP
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    for place, joint in enumerate(JOINTS):
        if joint.startswith(leg):
            dof = model.joint(robot.joint_names[place]).dofadr[0]
            its = fit.joints[place]
            model.dof_frictionloss[dof] = its.friction.value
            model.dof_solref[dof] = (2.0 * STEP, 1.0)  # dry, not viscous at low speeds
            model.dof_damping[dof] = its.damping.value
            model.dof_armature[dof] = its.armature.value
    return model


def moved(robot: Robot, fit: Fit, leg: int, rng: np.random.Generator) -> Turn:
    """A leg, an index of LEGS, through its part of the excitation, without noise."""
    model = clamped_leg(robot, fit, LEGS[leg])
    data = mujoco.MjData(model)
    own = np.arange(len(LEG_JOINTS) * leg, len(LEG_JOINTS) * (leg + 1))
    at = np.array([model.joint(robot.joint_names[j]).qposadr[0] for j in own])
    motors = np.array([model.actuator(JOINTS[j]).id for j in own])
    delay, strength, offset = (fit.values(name)[own] for name in ("delay", "strength", "offset"))
    kp, kd = robot.kp * fit.values("kp")[own], robot.kd * fit.values("kd")[own]
    model.actuator_gainprm[motors, 0] = strength * kp
    model.actuator_biasprm[motors, 1], model.actuator_biasprm[motors, 2] = -strength * kp, -strength * kd
    limits, safety = JointLimits.of(robot), SafetyConfig(target_rate=RATE)
    excitation = Excitation(robot, limits, "hung")
    begin = MOVE_S + leg * TURN_S * len(LEG_JOINTS)
    steps = round(TURN_S * len(LEG_JOINTS) / STEP)
    targets, sent = [excitation.positions(begin)], [-1.0]
    data.qpos[at] = targets[0][own] - offset
    rows, times, due, ones = [], [], rng.random() * TICK_S, np.ones(len(JOINTS))
    for step in range(steps):
        now = step * STEP
        if step % round(MESSAGE / STEP) == 0:
            times.append(now)
            rows.append((data.qpos[at] + offset, data.qvel[at].copy()))
        while due < now + STEP:  # between messages: a deployer's clock is not in step with the robot's
            seen = Joints(targets[-1].copy(), np.zeros(len(JOINTS)), np.zeros(len(JOINTS)))
            seen.pos[own], seen.vel[own] = rows[-1]
            wanted = Targets(excitation.positions(begin + due), robot.kp * ones, robot.kd * ones)
            targets.append(limited(wanted, targets[-1], due - max(sent[-1], due - TICK_S), seen, limits, safety).pos)
            sent.append(due)
            due += TICK_S
        recent = range(max(len(sent) - 8, 0), len(sent))
        for i, motor in enumerate(motors):
            acting, left, end = 0.0, STEP, now + STEP - delay[i]
            for k in reversed(recent):  # the mean over the step of what acts
                share = min(left, max(end - sent[k], 0.0) - (STEP - left))
                if share > 0.0:
                    acting += share * targets[k][own[i]]
                    left -= share
            data.ctrl[motor] = acting / (STEP - left) - offset[i]
        mujoco.mj_step(model, data)
    time, (pos, vel) = np.array(times), (np.array(column) for column in zip(*rows, strict=True))
    told = np.array(targets)
    acting = [told[np.searchsorted(sent, time - delay[i], side="right") - 1, joint] for i, joint in enumerate(own)]
    torque = kp * (np.stack(acting, axis=1) - pos) - kd * vel
    return Turn(time, pos, vel, torque, np.array(sent), told)


def measured_turn(robot: Robot, fit: Fit, leg: int, seed: int) -> Signals:
    """What :func:`hardware.identification.signals.signals_of` makes of :func:`log_events` of one leg, but quicker."""
    noise, rng = SensorNoise(), np.random.default_rng(seed)
    turn = moved(robot, fit, leg, rng)
    n, own = len(turn.time), slice(len(LEG_JOINTS) * leg, len(LEG_JOINTS) * (leg + 1))
    pos, torque = np.tile(turn.targets[0], (n, 1)), np.zeros((n, len(JOINTS)))
    pos[:, own], torque[:, own] = turn.pos, turn.torque
    ones, up = np.ones(len(JOINTS)), np.array([0.0, 0.0, GRAVITY])
    return Signals(
        time=turn.time,
        pos=pos + noise.joint_pos * rng.standard_normal(pos.shape),
        torque=torque + noise.torque * rng.standard_normal(pos.shape),
        angular_velocity_b=noise.angular_velocity * rng.standard_normal((n, 3)),
        acceleration_b=up + noise.acceleration * rng.standard_normal((n, 3)),
        sent=turn.sent,
        targets=turn.targets,
        kp=robot.kp * ones,
        kd=robot.kd * ones,
        session=Session("none", "", Settings(identify="hung"), False, SENDER, "unknown", robot.name),
    )


def _resting(robot: Robot, at_rest: Floats) -> Turn:
    """The time in which the deployer moves the robot into the pose at rest, or out of it: here it is there already."""
    time, sent = np.arange(0.0, MOVE_S, MESSAGE), np.arange(0.0, MOVE_S, TICK_S)
    still = np.zeros((len(time), len(LEG_JOINTS)))
    first = at_rest[: len(LEG_JOINTS)]
    return Turn(time, still + first, still, still, sent, np.tile(at_rest, (len(sent), 1)))


def log_events(
    robot: Robot, fit: Fit, seed: int, legs: Iterable[int] = range(len(LEGS)), noise: SensorNoise | None = None
) -> Iterator[tuple[str, bytes, float]]:
    """The events of a log of ``symdyn deploy --identify hung``: channel, bytes, s. The legs are moved one by one.

    Args:
        robot: what the machine is one of.
        fit: the machine.
        seed: of noise and of when targets are sent.
        legs: which, indices of LEGS; their turns follow 2 s of rest and are followed by as
            much.
        noise: of the sensors; the simulated robot's usual one if None.
    """
    noise, rng = SensorNoise() if noise is None else noise, np.random.default_rng(seed)
    noise_rng = np.random.default_rng((seed, 1))
    settings = Settings(identify="hung")
    yield SESSION, Session("none", "", settings, False, SENDER, "unknown", robot.name).message().encode(), 0.0
    ones, order, number = np.ones(len(JOINTS)), list(JOINTS_TO_SDK), 0
    at_rest = Excitation(robot, JointLimits.of(robot), "hung").positions(MOVE_S)
    resting, began = _resting(robot, at_rest), 0.0
    for leg, turn in chain([(0, resting)], ((leg, moved(robot, fit, leg, rng)) for leg in legs), [(0, resting)]):
        own = slice(len(LEG_JOINTS) * leg, len(LEG_JOINTS) * (leg + 1))
        due = [(time, 0, k) for k, time in enumerate(turn.time)] + [(t, 1, k) for k, t in enumerate(turn.sent[1:], 1)]
        for time, kind, k in sorted(due):
            now = began + time
            if kind == 0:
                state = np.stack([at_rest, np.zeros(len(JOINTS)), np.zeros(len(JOINTS))])
                state[:, own] = turn.pos[k], turn.vel[k], turn.torque[k]
                scale = np.array([noise.joint_pos, noise.joint_vel, noise.torque])[:, None]
                state += scale * noise_rng.standard_normal(state.shape)
                joints, imu = leg_control_data_lcmt(), state_estimator_lcmt()
                joints.q, joints.qd, joints.tau_est = state[:, order].tolist()
                imu.quat = [1.0, 0.0, 0.0, 0.0]
                imu.omegaBody = (noise.angular_velocity * noise_rng.standard_normal(3)).tolist()
                imu.aBody = (np.array([0.0, 0.0, GRAVITY]) + noise.acceleration * noise_rng.standard_normal(3)).tolist()
                yield JOINT_STATES, joints.encode(), now
                yield IMU, imu.encode(), now
            else:
                number += 1
                sent = Targets(turn.targets[k], robot.kp * ones, robot.kd * ones)
                yield TARGETS, sent.message(number, SENDER).encode(), now
                tick = controller_tick_lcmt()
                tick.tick, tick.time, tick.state = number, now, State.IDENTIFY
                yield TICK, tick.encode(), now
        began += MOVE_S if turn is resting else TURN_S * len(LEG_JOINTS)
