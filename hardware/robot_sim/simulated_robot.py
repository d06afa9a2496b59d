"""A robot of MuJoCo, by itself or behind its bridge: takes the bridge's targets, gives the bridge's messages."""

# mujoco is a compiled module without stubs
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import copy
import math
from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from hardware.robot_sim.fitted_motors import SUBSTEP, FittedMotors
from hardware.robot_sim.sensors import SensorNoise, Sensors, Truth, roll_pitch_yaw, rotate, rotate_inverse
from hardware.robot_sim.settings import PERIOD, Start
from hardware.robot_sim.world import TRAINING, World
from hardware.wire.messages import leg_control_data_lcmt, pd_tau_targets_lcmt, state_estimator_lcmt
from hardware.wire.readings import Joints
from hardware.wire.sdk_order import JOINTS_FROM_SDK, JOINTS_TO_SDK, LEGS_TO_SDK
from symdyn.robot.definition import Robot
from symdyn.robot.descriptions import velocity_limits
from symdyn.robot.fit import Fit
from symdyn.robot.legs import JOINTS
from symdyn.robot.torque_speed import torque_range

Floats = NDArray[np.float64]


BRIDGE_KP, BRIDGE_KD = 20.0, 0.5
"""Gains with which the bridge, from its start to the first targets, holds the pose that it finds
(lcm_position_go2.cpp, SetNominalPose and the first run of LowCmdWrite)."""

BRIDGE_TILT = 0.8
"""rad of roll or pitch over which the bridge stops (lcm_position_go2.cpp, LowCmdWrite)."""

CONTACT_FORCE = 1.0
"""N; a foot that bears more is in contact."""

LYING_HEIGHT = 0.3
"""Leg lengths above the floor at which a robot is put on its belly."""

HANGING_HEIGHT = 1.625
"""Leg lengths of the hook of the harness above the floor: straight legs end above it."""

_SETTLING = 2.0  # s; longer than any start pose takes to come to rest
_SETTLING_KD = 2.0  # N m s/rad
# the harness: soft enough to be stable when integrated by explicit steps of 2 ms, and yields 5 cm to a Go2's weight
_HARNESS_STIFFNESS, _HARNESS_DAMPING = 3000.0, 300.0  # N/m, N s/m
_HARNESS_TURN_STIFFNESS, _HARNESS_TURN_DAMPING = 60.0, 5.0  # N m/rad, N m s/rad

_UP = np.array([0.0, 0.0, 1.0])
_FROM_SDK, _TO_SDK = list(JOINTS_FROM_SDK), list(JOINTS_TO_SDK)
_LEGS_TO_SDK = list(LEGS_TO_SDK)


class SimulatedRobot:
    """A robot and its bridge (``lcm_position_go2`` of walk-these-ways-go2).

    The bridge forwards the last targets for ever, without clamp or timeout. Before the first, it holds the pose in
    which it found the robot. Over 0.8 rad of roll or pitch, or on L2+B (:meth:`stop_bridge`), it ceases to forward, for
    good; it prepares a damping command, but waits before it would write it, so the motors keep what they had (what
    their firmware does when nothing comes is not documented; this is the worst case).

    Until ``wakes_at`` it has not heard of the robot, and its messages are zeros.

    Without a bridge, none of this: the motors hold the law of the last targets, and before the first they are limp.

    Args:
        model: of MuJoCo, with position actuators named as symdyn's JOINTS; a copy of it is taken.
        robot: whose model it is.
        foot_force_sensors: names of the sensors of the force on each foot, in the order of LEGS.
        seed: decides noise, biases and the feet's units.
        start: ``lying`` on the belly, without torque until the bridge wakes; ``standing``, held in the default pose
            with the robot's gains; ``hung`` in a harness that keeps the trunk in the air, held with the bridge's gains.
        noise: of the sensors; None for the usual.
        wakes_at: s.
        bridge: whether there is one between this robot and the messages.
        world: floor, joints, motors and feet.
        fit: the machine that it shall be; the model as it is if None. Its motors' law then holds continuously.

    Attributes:
        model: the copy.
        data: MuJoCo's.
        bridge_stopped: whether the bridge has ceased to forward.
        wrench_w: (6,) force and torque on the trunk from outside, world frame, N and N m.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        robot: Robot,
        foot_force_sensors: Sequence[str],
        seed: int = 0,
        start: Start = "lying",
        noise: SensorNoise | None = None,
        wakes_at: float = 0.0,
        bridge: bool = True,
        world: World = TRAINING,
        fit: Fit | None = None,
    ) -> None:
        self.model = copy.copy(model)
        self.model.opt.timestep = PERIOD
        self._fitted = None if fit is None else FittedMotors(fit, seed)
        # a simulation that diverges shall be seen, not be silently put back to its initial pose
        self.model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
        self.data = mujoco.MjData(self.model)
        self.robot = robot
        self.bridge_stopped = False
        self.wrench_w = np.zeros(6)
        self._joint_pos = np.array([model.joint(name).qposadr[0] for name in robot.joint_names])
        self._joint_vel = np.array([model.joint(name).dofadr[0] for name in robot.joint_names])
        self._motors = np.array([model.actuator(joint).id for joint in JOINTS])
        self._feet = np.array([model.sensor(name).adr[0] + np.arange(3) for name in foot_force_sensors])
        self._trunk = model.body(robot.trunk).id
        self._peak_torque = model.actuator_forcerange[self._motors, 1].copy()
        self._no_load_speed = velocity_limits(robot) if robot.torque_knee is not None else None
        root = model.body_jntadr[self._trunk]
        self._pos = slice(model.jnt_qposadr[root], model.jnt_qposadr[root] + 3)
        self._quat = slice(self._pos.stop, self._pos.stop + 4)
        self._vel = slice(model.jnt_dofadr[root], model.jnt_dofadr[root] + 3)
        self._turn = slice(self._vel.stop, self._vel.stop + 3)
        self._hung = start == "hung"
        self._sensors = Sensors(SensorNoise() if noise is None else noise, seed)
        self._wakes_at = wakes_at
        self._bridge = bridge
        self._awake = not bridge
        self._world = world
        self._enter(self._world)
        if fit is not None:
            self._become(fit)
        self._settle(start)
        self._truth = self._sense(self._velocity())
        self._measured = self._sensors.measure(self._truth)
        self._wake()

    @property
    def time(self) -> float:
        """s since the start."""
        return self.data.time

    @property
    def height(self) -> float:
        """Of the trunk's origin above the floor, m."""
        return float(self.data.qpos[self._pos][2])

    @property
    def joint_range(self) -> Floats:
        """Lower and upper end of each joint's range, (12, 2) rad."""
        return self.model.jnt_range[[self.model.joint(name).id for name in self.robot.joint_names]]

    @property
    def torque_limit(self) -> Floats:
        """Of each motor, as it reports its torque, (12,) N m."""
        return self._peak_torque.copy() if self._fitted is None else self._peak_torque / self._fitted.strength

    @property
    def tilt(self) -> float:
        """Angle between the trunk's z axis and the vertical, rad."""
        return math.acos(min(1.0, max(-1.0, float(rotate(self._truth.quat_w, _UP)[2]))))

    @property
    def speed(self) -> float:
        """Of the trunk, m/s."""
        return math.hypot(*self.data.qvel[self._vel].tolist())

    def command(self, message: pd_tau_targets_lcmt) -> None:
        """Take over targets from the wire, to be held until the next.

        Targets that are not finite are dropped: what a motor makes of them is not known.
        """
        arrays = (message.q_des, message.kp, message.kd, message.qd_des, message.tau_ff)
        pos, kp, kd, vel, torque = (np.array(array)[_FROM_SDK] for array in arrays)
        if all(np.isfinite(array).all() for array in (pos, kp, kd, vel, torque)) and not self.bridge_stopped:
            self._drive(pos, kp, kd, vel, torque)

    def stop_bridge(self) -> None:
        """L2+B: the bridge ceases to forward."""
        self.bridge_stopped = True

    def step(self) -> None:
        """Advance by one period of the messages."""
        before = self._velocity()
        self.data.xfrc_applied[self._trunk] = self.wrench_w + self._harness()
        self._advance()
        self._truth = self._sense(before)
        self._measured = self._sensors.measure(self._truth)
        self._wake()
        if self._bridge and self._awake and max(map(abs, roll_pitch_yaw(self._measured.quat_w)[:2])) > BRIDGE_TILT:
            self.bridge_stopped = True

    def kick(self, velocity_w: Floats) -> None:
        """Change the trunk's velocity, (3,) m/s, at once."""
        self.data.qvel[self._vel] += velocity_w

    def load(self, mass: float) -> None:
        """Add a mass to the trunk, kg."""
        self.model.body_mass[self._trunk] += mass
        mujoco.mj_setConst(self.model, mujoco.MjData(self.model))

    @property
    def measured_joints(self) -> Joints:
        """As the sensors see them now, whether or not the bridge has woken."""
        return Joints(self._measured.joint_pos, self._measured.joint_vel, self._measured.torque)

    def joints(self) -> leg_control_data_lcmt:
        """What the bridge says of the joints now."""
        message = leg_control_data_lcmt()
        if self._awake:
            message.q = _wire(self._measured.joint_pos, _TO_SDK)
            message.qd = _wire(self._measured.joint_vel, _TO_SDK)
            message.tau_est = _wire(self._measured.torque, _TO_SDK)
        return message

    def imu(self) -> state_estimator_lcmt:
        """What the bridge says of trunk and feet now."""
        message = state_estimator_lcmt()
        if self._awake:
            message.quat = _wire(self._measured.quat_w)
            message.rpy = _wire(np.array(roll_pitch_yaw(self._measured.quat_w)))
            message.omegaBody = _wire(self._measured.angular_velocity_b)
            message.aBody = _wire(self._measured.acceleration_b)
            if self._world.foot_sensors:
                message.contact_estimate = _wire(self._measured.foot_force, _LEGS_TO_SDK)
        return message

    def truth(self) -> state_estimator_lcmt:
        """Everything of the message's fields as it is, without noise; contacts 0 or 1."""
        truth, velocity_w = self._truth, self.data.qvel[self._vel]
        message = state_estimator_lcmt()
        message.p = _wire(self.data.qpos[self._pos])
        message.quat = _wire(truth.quat_w)
        message.rpy = _wire(np.array(roll_pitch_yaw(truth.quat_w)))
        message.vWorld = _wire(velocity_w)
        message.vBody = _wire(rotate_inverse(truth.quat_w, velocity_w))
        message.omegaBody = _wire(truth.angular_velocity_b)
        message.omegaWorld = _wire(rotate(truth.quat_w, truth.angular_velocity_b))
        message.aBody = _wire(truth.acceleration_b)
        message.aWorld = _wire(rotate(truth.quat_w, truth.acceleration_b))
        message.contact_estimate = _wire((truth.foot_force > CONTACT_FORCE).astype(float), _LEGS_TO_SDK)
        message.timestamp_us = round(1e6 * self.time)
        return message

    def _enter(self, world: World) -> None:
        if world.floor_friction is not None:
            self.model.geom_friction[self.model.geom_bodyid == 0, 0] = world.floor_friction
        self.model.dof_frictionloss[self._joint_vel] += world.joint_friction

    def _become(self, fit: Fit) -> None:
        model = self.model
        model.dof_frictionloss[self._joint_vel] += fit.values("friction")
        # MuJoCo's default lets dry friction be viscous below 0.2 rad/s; this is as stiff as the time step allows
        model.dof_solref[self._joint_vel] = (2.0 * SUBSTEP, 1.0)
        model.dof_damping[self._joint_vel] = fit.values("damping")
        model.dof_armature[self._joint_vel] = fit.values("armature")
        mujoco.mj_setConst(model, mujoco.MjData(model))
        self._peak_torque *= fit.values("strength")
        model.actuator_forcerange[self._motors] = np.column_stack([-self._peak_torque, self._peak_torque])
        # the law of a motor holds at every moment; an implicit step of 2 ms would damp, and report, otherwise
        model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
        model.opt.timestep = SUBSTEP

    def _advance(self) -> None:
        if self._fitted is not None:
            for _ in range(round(PERIOD / SUBSTEP)):
                self._act(*self._fitted.acting(self.data.time))
                self._limit_torque()
                mujoco.mj_step(self.model, self.data)
            return
        self._limit_torque()
        if not self._world.explicit:
            mujoco.mj_step(self.model, self.data)
            return
        # the same law, but of the state as it is now: a torque that the step does not change
        gain, bias = self.model.actuator_gainprm, self.model.actuator_biasprm
        law = gain[self._motors, 0].copy(), bias[self._motors, :3].copy()
        pos, vel = self.data.qpos[self._joint_pos], self.data.qvel[self._joint_vel]
        constant, stiffness, damping = law[1].T
        torque = law[0] * self.data.ctrl[self._motors] + constant + stiffness * pos + damping * vel
        gain[self._motors, 0] = 0.0
        bias[self._motors, 0], bias[self._motors, 1], bias[self._motors, 2] = torque, 0.0, 0.0
        mujoco.mj_step(self.model, self.data)
        gain[self._motors, 0], bias[self._motors, :3] = law

    def _drive(self, pos: Floats, kp: Floats | float, kd: Floats | float, vel: Floats | float, torque: Floats | float):
        if self._fitted is not None:
            ones = np.ones(len(JOINTS))
            self._fitted.command(self.data.time, pos, kp * ones, kd * ones, vel * ones, torque * ones)
            return
        self._act(pos, kp, kd, vel, torque)

    def _act(self, pos: Floats, kp: Floats | float, kd: Floats | float, vel: Floats | float, torque: Floats | float):
        # kp (pos - q) + kd (vel - qd) + torque, the gains where MuJoCo's implicit integrator and saturation see them
        gain, bias = self.model.actuator_gainprm, self.model.actuator_biasprm
        gain[self._motors, 0] = kp
        bias[self._motors, 0] = torque + kd * vel
        bias[self._motors, 1] = -kp
        bias[self._motors, 2] = -kd
        self.data.ctrl[self._motors] = pos

    def _limit_torque(self) -> None:
        if self._no_load_speed is not None:
            assert self.robot.torque_knee is not None
            speed = self.data.qvel[self._joint_vel]
            limits = torque_range(speed, self._peak_torque, self._no_load_speed, self.robot.torque_knee)
            self.model.actuator_forcerange[self._motors] = np.column_stack(limits)

    def _wake(self) -> None:
        if not self._awake and self.time >= self._wakes_at:
            self._awake = True
            if self._at_rest:
                self._drive(self._measured.joint_pos, BRIDGE_KP, BRIDGE_KD, 0.0, 0.0)

    def _settle(self, start: Start) -> None:
        robot, qpos = self.robot, self.data.qpos
        pose, height = _start_pose(robot, start)
        qpos[self._pos] = (0.0, 0.0, height)
        qpos[self._joint_pos] = pose
        gains = {"lying": (0.0, _SETTLING_KD), "standing": (robot.kp, robot.kd), "hung": (BRIDGE_KP, BRIDGE_KD)}[start]
        self._drive(pose, *gains, 0.0, 0.0)
        if self._fitted is not None:
            self._fitted.forget(self.data.time)
        for _ in range(round(_SETTLING / PERIOD)):
            self.data.xfrc_applied[self._trunk] = self._harness()
            self._advance()
        self.data.time = 0.0
        self._at_rest = start == "lying"
        if self._at_rest:
            self._drive(pose, 0.0, 0.0, 0.0, 0.0)
        if self._fitted is not None:
            self._fitted.forget(self.data.time)

    def _harness(self) -> Floats:
        # a spring and a damper to the hook, and the same against turning
        if not self._hung:
            return np.zeros(6)
        offset = np.array([0.0, 0.0, HANGING_HEIGHT * self.robot.leg_length]) - self.data.qpos[self._pos]
        force = _HARNESS_STIFFNESS * offset - _HARNESS_DAMPING * self.data.qvel[self._vel]
        w, v = self.data.qpos[self._quat][0], self.data.qpos[self._quat][1:]
        turn_w = -2.0 * _HARNESS_TURN_STIFFNESS * np.sign(w) * v
        turn_w -= _HARNESS_TURN_DAMPING * rotate(self.data.qpos[self._quat], self.data.qvel[self._turn])
        return np.concatenate([force, turn_w])

    def _velocity(self) -> Floats:
        return self.data.qvel[self._vel].copy()

    def _sense(self, velocity_before_w: Floats) -> Truth:
        # mj_step leaves torque and contact forces of the step that it made; the acceleration is the mean over that step
        data = self.data
        quat_w = data.qpos[self._quat].copy()
        specific_force_w = (data.qvel[self._vel] - velocity_before_w) / PERIOD - self.model.opt.gravity
        # an encoder shows its offset, too, and a motor the torque that it takes itself to give
        shown, torque = data.qpos[self._joint_pos], data.actuator_force[self._motors]
        if self._fitted is not None:
            shown = shown + self._fitted.offset
            low, high = self.model.actuator_forcerange[self._motors].T / self._fitted.strength
            reported = self._fitted.reported(data.time, shown, data.qvel[self._joint_vel])
            torque = np.minimum(np.maximum(reported, low), high)
        return Truth(
            joint_pos=shown,
            joint_vel=data.qvel[self._joint_vel],
            torque=torque,
            quat_w=quat_w,
            angular_velocity_b=data.qvel[self._turn].copy(),
            acceleration_b=rotate_inverse(quat_w, specific_force_w),
            foot_force=np.sqrt(np.square(data.sensordata[self._feet]).sum(axis=1)),
        )


def _start_pose(robot: Robot, start: Start) -> tuple[Floats, float]:
    """Joint positions, (12,) rad, and height of the trunk, m, at the start."""
    legs = robot.legs.in_order()
    if start == "hung":
        return np.array([leg.hanging or leg.stance for leg in legs]).ravel(), HANGING_HEIGHT * robot.leg_length
    lying = [leg.lying for leg in legs]
    if start == "lying" and None not in lying:
        return np.array(lying).ravel(), LYING_HEIGHT * robot.leg_length
    return robot.default_joint_pos, robot.base_height


def _wire(values: Floats, order: list[int] | None = None) -> list[float]:
    # through float32: what a receiver sees, also of a message that was never encoded
    return (values if order is None else values[order]).astype(np.float32).tolist()
