"""Physics on the CPU: mujoco.batch.Batch, many simulations of one model on a thread pool."""

# mujoco is a compiled module without stubs
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import os
from typing import Any

import mujoco
import numpy as np
import torch
from mujoco.batch import Batch, SimulationError
from numpy.typing import NDArray

from rl.physics.delay_line import DelayLine
from rl.physics.dynamics import Dynamics
from rl.physics.model import FLOOR, ROOT_JOINT, foot_site, force_sensor, position_sensor, velocity_sensor
from rl.physics.protocol import Physics, Pose, RobotState
from symdyn.errors import InvalidValue, ResourceProblem
from symdyn.robot.definition import Robot
from symdyn.robot.descriptions import velocity_limits
from symdyn.robot.legs import JOINTS, LEGS
from symdyn.robot.torque_speed import torque_range

BYTES_PER_ROBOT = 0.6e6
"""Memory of one simulation with its share of the learner's, rounded up (make bench measures it)."""

_VELOCITY_STAGE = int(mujoco.mjtStage.mjSTAGE_VEL.value)
_NO_STAGE = int(mujoco.mjtStage.mjSTAGE_NONE.value)


def address_table(model: mujoco.MjModel, robot: Robot) -> dict[str, NDArray[np.int64]]:
    """Where things lie in MuJoCo's arrays, by name.

    Returns:
        ``joint_pos``: in qpos, (12,) in the order of JOINTS. ``joint_vel``: in qvel, (12,). ``torque``: in
        actuator_force and ctrl, (12,). ``force``, ``position``, ``velocity`` of the feet: in sensordata, (4, 3).
    """

    def sensors(name_of) -> NDArray[np.int64]:
        return np.array([np.arange(3) + model.sensor(name_of(leg)).adr[0] for leg in LEGS])

    return {
        "joint_pos": np.array([model.joint(name).qposadr[0] for name in robot.joint_names]),
        "joint_vel": np.array([model.joint(name).dofadr[0] for name in robot.joint_names]),
        "torque": np.array([model.actuator(joint).id for joint in JOINTS]),
        "force": sensors(force_sensor),
        "position": sensors(position_sensor),
        "velocity": sensors(velocity_sensor),
    }


class BatchPhysics(Physics):
    """N copies of one model. Each keeps its MjData, so that its sensors describe the state after the step at no cost.

    Args:
        model: from :func:`rl.physics.model.build_model`.
        robot: whose model it is.
        num_envs: N.
        num_threads: 0 means one a processor.

    Raises:
        InvalidValue: if the control step is no multiple of the model's time step.
        ResourceProblem: if the machine has no memory for so many.
    """

    def __init__(self, model: mujoco.MjModel, robot: Robot, num_envs: int, num_threads: int = 0) -> None:
        substeps = robot.control_dt / model.opt.timestep
        if abs(substeps - round(substeps)) > 1e-9 or round(substeps) < 1:
            raise InvalidValue("The control step", robot.control_dt, f"a multiple of {model.opt.timestep} s")
        _check_memory(num_envs)
        # a diverging simulation shall be seen and dumped, not silently put back to its initial pose
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
        self.num_envs = num_envs
        self.substeps = round(substeps)
        self.model = model
        self.robot = robot
        self.batch = Batch(model, num_envs, num_threads, persistent=True)
        self.foot_radius = float(model.geom(foot_site(LEGS[0])).size[0])
        self._at = address_table(model, robot)
        self._flat_sensors = np.concatenate([self._at[k].ravel() for k in ("force", "position", "velocity")])
        root = model.joint(ROOT_JOINT)
        self._root_pos = slice(root.qposadr[0], root.qposadr[0] + 7)
        self._root_vel = slice(root.dofadr[0], root.dofadr[0] + 6)
        self._qpos = self.batch.bind("qpos")
        self._qvel = self.batch.bind("qvel")
        self._ctrl = self.batch.bind("ctrl")
        self._torque = self.batch.bind("actuator_force")
        self._sensors = self.batch.bind("sensordata")
        self._failed = np.zeros(num_envs, dtype=bool)
        self._delay_line = DelayLine(num_envs, len(JOINTS), self.substeps)
        self._substep = 0
        self._no_load_speed = velocity_limits(robot) if robot.torque_knee is not None else None
        self.dynamics = Dynamics.nominal(num_envs)
        self._set_motors()

    def reset(self, ids: NDArray[np.int64], pose: Pose) -> None:
        self.batch.reset(ids, stage=_NO_STAGE)
        qpos = np.tile(self.model.qpos0, (len(ids), 1))
        qpos[:, self._root_pos] = np.concatenate([pose.base_pos_w, pose.base_quat_w], axis=1)
        qpos[:, self._at["joint_pos"]] = pose.joint_pos
        self._qpos[ids] = qpos
        qvel = np.zeros((len(ids), self.model.nv))
        qvel[:, self._root_vel.start : self._root_vel.start + 3] = pose.base_vel_w
        self._qvel[ids] = qvel
        self._delay_line.fill(ids, pose.joint_pos - self.dynamics.joint_offset[ids])
        self._act(0)
        self._failed[ids] = False
        # the whole forward pass: forces and torques, too, are those of the new pose
        self.batch.forward(ids)

    def step(self, joint_targets: torch.Tensor) -> None:
        self.set_targets(joint_targets.double().numpy())
        for _ in range(self.substeps):
            self.substep()

    def substep(self) -> None:
        """Advance one physics step: the next of the control step that :meth:`set_targets` began."""
        if self._substep:
            self._act(self._substep)
        self._substep += 1
        try:
            self.batch.step(stage=_VELOCITY_STAGE)
        except SimulationError as error:
            # they kept the state before the call, the others went on
            self._failed[error.ids] = True

    def set_targets(self, joint_targets: NDArray[np.float64]) -> None:
        """Joint targets, (N, 12) rad, for :meth:`substep`. A robot whose target is no number counts as diverged."""
        # MuJoCo would take a NaN for zero and go on
        self._failed |= ~np.isfinite(joint_targets).all(axis=1)
        self._delay_line.push(joint_targets - self.dynamics.joint_offset)
        self._substep = 0
        self._act(0)

    def _act(self, substep: int) -> None:
        """Give every motor the target that has reached it, and the torque that it has at its speed."""
        self._ctrl[:, self._at["torque"]] = self._delay_line.at(min(substep, self.substeps - 1))
        if self._no_load_speed is not None:
            assert self.robot.torque_knee is not None
            speed = self._qvel[:, self._at["joint_vel"]]
            low, high = torque_range(speed, self._peak, self._no_load_speed, self.robot.torque_knee)
            self._force_range[:, self._at["torque"], 0] = low
            self._force_range[:, self._at["torque"], 1] = high

    def read(self) -> RobotState:
        def tensor(values: NDArray[np.float64]) -> torch.Tensor:
            return torch.from_numpy(np.ascontiguousarray(values, dtype=np.float32))

        qpos, qvel = self._qpos, self._qvel
        root = tensor(qpos[:, self._root_pos])
        if self._failed.any():
            root[torch.from_numpy(self._failed)] = torch.nan
        velocity = tensor(qvel[:, self._root_vel])
        # MuJoCo's contact sensor gives the force of the foot on the floor; the ground's reaction is its negative
        feet = tensor(self._sensors[:, self._flat_sensors]).view(self.num_envs, 3, len(LEGS), 3)
        return RobotState(
            base_pos_w=root[:, :3],
            base_quat_w=root[:, 3:],
            base_lin_vel_w=velocity[:, :3],
            base_ang_vel_b=velocity[:, 3:],
            joint_pos=tensor(qpos[:, self._at["joint_pos"]]),
            joint_vel=tensor(qvel[:, self._at["joint_vel"]]),
            joint_torque=tensor(self._torque[:, self._at["torque"]]),
            foot_force_w=-feet[:, 0],
            foot_pos_w=feet[:, 1],
            foot_vel_w=feet[:, 2],
        )

    def push(self, ids: NDArray[np.int64], velocity_w: NDArray[np.float64]) -> None:
        self._qvel[ids, self._root_vel.start : self._root_vel.start + 3] += velocity_w

    def set_dynamics(self, dynamics: Dynamics) -> None:
        self.dynamics = dynamics
        added = dynamics.added_mass[:, None]
        trunk = self.model.body(self.robot.trunk)
        own = trunk.mass[0]
        self.batch.expand("body_mass")[:, trunk.id] = own + dynamics.added_mass
        # the added mass as a point, the trunk's principal axes taken for the axes of the trunk
        shift = dynamics.com_shift_b + added / (own + added) * dynamics.mass_pos_b
        self.batch.expand("body_ipos")[:, trunk.id] = trunk.ipos + shift
        square = dynamics.mass_pos_b**2
        reduced = own * added / (own + added)
        inertia = trunk.inertia + reduced * (square.sum(axis=1, keepdims=True) - square)
        if not ((own + added > 0.0).all() and (inertia > 0.0).all()):
            raise InvalidValue(
                "The trunk with the added mass", "without mass or inertia", "of positive mass and inertia: change less"
            )
        self.batch.expand("body_inertia")[:, trunk.id] = inertia
        floor = self.model.geom(FLOOR)
        self.batch.expand("geom_friction")[:, floor.id, 0] = floor.friction[0] * dynamics.friction
        if dynamics.slope.any() or self.batch.expanded("geom_quat") is not None:
            self.batch.expand("geom_quat")[:, floor.id] = _tilted(dynamics.slope)
        self._set_motors()
        self.batch.set_const()

    def _set_motors(self) -> None:
        d, motors = self.dynamics, self._at["torque"]
        self._delay_line.set_delay(np.rint(d.delay / self.model.opt.timestep).astype(np.int64))
        self._peak = d.strength * self.model.actuator_forcerange[motors, 1]
        self._force_range = self.batch.expand("actuator_forcerange")
        self._force_range[:, motors] = np.stack([-self._peak, self._peak], axis=2)
        kp, kd = d.strength * d.kp, d.strength * d.kd
        self.batch.expand("actuator_gainprm")[:, motors, 0] = kp * self.model.actuator_gainprm[motors, 0]
        self.batch.expand("actuator_biasprm")[:, motors, 1] = kp * self.model.actuator_biasprm[motors, 1]
        self.batch.expand("actuator_biasprm")[:, motors, 2] = kd * self.model.actuator_biasprm[motors, 2]

    def ground(self, position_w: torch.Tensor) -> torch.Tensor:
        slope = torch.as_tensor(self.dynamics.slope, dtype=position_w.dtype)
        slope = slope.view(self.num_envs, *([1] * (position_w.ndim - 2)), 2)
        return (slope * position_w[..., :2]).sum(dim=-1)

    def state_dict(self) -> dict[str, Any]:
        return {
            "state": torch.from_numpy(self.batch.state.copy()),
            "failed": torch.from_numpy(self._failed.copy()),
            "targets": torch.from_numpy(self._delay_line.kept.copy()),
            "dynamics": {k: torch.from_numpy(v.copy()) for k, v in vars(self.dynamics).items()},
        }

    def load_state_dict(self, state: dict[str, Any]) -> None:
        self.set_dynamics(Dynamics(**{k: v.numpy().copy() for k, v in state["dynamics"].items()}))
        self._delay_line.kept[:] = state["targets"].numpy()
        self.batch.state[:] = state["state"].numpy()
        self.batch.forward(
            stage=_VELOCITY_STAGE
        )  # where the feet are; forces and torques are known after the next step
        self.batch.state[:] = state["state"].numpy()
        self._failed[:] = state["failed"].numpy()

    def dump(self, env: int) -> dict[str, Any]:
        return {
            "qpos": self._qpos[env].tolist(),
            "qvel": self._qvel[env].tolist(),
            "ctrl": self._ctrl[env].tolist(),
            **self.dynamics.of(env),
        }


def _tilted(slope: NDArray[np.float64]) -> NDArray[np.float64]:
    """Orientation of a plane with these gradients, (N, 2) -> (N, 4): its normal is turned the shortest way."""
    normal = np.column_stack([-slope, np.ones(len(slope))])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    quat = np.column_stack([1.0 + normal[:, 2], -normal[:, 1], normal[:, 0], np.zeros(len(slope))])
    return quat / np.linalg.norm(quat, axis=1, keepdims=True)


def _check_memory(num_envs: int) -> None:
    # asking for too much would not fail: the system would kill the process once the pages are touched
    needed, present = num_envs * BYTES_PER_ROBOT, os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    if needed > present:
        fit = int(present / BYTES_PER_ROBOT)
        raise ResourceProblem(
            f"{num_envs} robots need {needed / 2**30:.0f} GiB of memory, and this machine has "
            f"{present / 2**30:.0f} GiB: use at most {fit}."
        )
