"""The environment: N robots told to run gaits, rewarded for symmetry."""

from __future__ import annotations

import logging
import math
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import torch
from rsl_rl.env import VecEnv
from tensordict import TensorDict

from rl.physics.dynamics import Dynamics
from rl.physics.protocol import Physics, Pose, RobotState, heading_velocity
from rl.task import rewards
from rl.task.commands import Commands, uniform
from rl.task.draw_dynamics import draw
from rl.task.privileged import PRIVILEGED, constant_terms, privileged_terms
from rl.task.settings import EnvConfig
from rl.task.termination import fallen
from symdyn.errors import InvalidValue
from symdyn.gait import phase as clock
from symdyn.gait.timing import TimingCurve
from symdyn.io.files import write_json
from symdyn.policy.layout import Layout
from symdyn.policy.observation import Sensed, Situation, get_layout, observe
from symdyn.policy.steering import STANDING_DUTY, stands
from symdyn.robot.definition import Robot
from symdyn.robot.descriptions import velocity_limits
from symdyn.robot.frames import projected_gravity, rotate_inverse, yaw
from symdyn.robot.legs import JOINTS

_log = logging.getLogger(__name__)


class GaitEnv(VecEnv):
    """rsl_rl's vector environment over a :class:`rl.physics.protocol.Physics`.

    Observation groups: ``policy``, the observation that the configuration names, noisy; ``privileged``, what only a
    simulator knows (rl.task.privileged), for the critic.

    Args:
        config: the task.
        physics: the engine, already built for ``num_envs`` robots.
        timing: T(v) and beta(v).
        robot: whose names, pose and gains.
        seed: of everything random in here.
        dump_dir: where the state of a diverged simulation is written, or None.
        layout: what the policy sees, if it is not what the configuration names.

    Raises:
        InvalidValue: for a setting out of range.
    """

    def __init__(
        self,
        config: EnvConfig,
        physics: Physics,
        timing: TimingCurve,
        robot: Robot,
        seed: int = 0,
        dump_dir: Path | None = None,
        layout: Layout | None = None,
    ) -> None:
        self.physics = physics
        self.timing = timing
        self.robot = robot
        self.layout = layout or get_layout(config.observation)
        self.num_envs = n = physics.num_envs
        self.num_actions = len(JOINTS)
        self.device = "cpu"
        self.generator = torch.Generator().manual_seed(seed)
        self.commands = Commands(config.commands, n, self.generator)
        self._dump_dir = dump_dir
        self._default_pos = torch.tensor(robot.default_joint_pos, dtype=torch.float32)
        self._noise = torch.tensor(self.layout.noise_amplitude(), dtype=torch.float32)
        self.episode_length_buf = torch.zeros(n, dtype=torch.int64)
        self.phase = torch.zeros(n)
        self.last_action = torch.zeros(n, self.num_actions)
        self.last_torque = torch.zeros(n, self.num_actions)
        self.velocity_h = torch.zeros(n, 3)
        self.yaw_error = torch.zeros(n)
        self.heading_held = torch.zeros(n)
        self.told = torch.zeros(n, 3)
        self.push_due = torch.zeros(n)
        self._kappa = math.nan
        self.begin_stage(config, physics)

    def begin_stage(self, config: EnvConfig, physics: Physics | None = None) -> None:
        """Take other settings, and another engine if one is given: robots are drawn anew, all episodes begin anew.

        Raises:
            InvalidValue: for a setting out of range.
        """
        if config.episode_s < self.robot.control_dt:
            raise InvalidValue("episode_s", config.episode_s, f"at least one control step, {self.robot.control_dt} s")
        self.physics = physics or self.physics
        self.set_rewards(config)
        self.max_episode_length = round(config.episode_s / self.robot.control_dt)
        self.commands.configure(config.commands)
        held = config.commands.hold_share * self.num_envs
        self._held = torch.arange(self.num_envs) < held
        self._set_dynamics(draw(config.randomization, self.num_envs, self.generator))
        self._reset(torch.arange(self.num_envs))
        state = self.physics.read()
        self.last_torque.copy_(state.joint_torque)
        self._observation = self._observe(state)

    def set_rewards(self, config: EnvConfig) -> None:
        """Take the settings of a task that differs in its rewards alone; episodes go on."""
        self.config = self.cfg = config  # cfg is rsl_rl's name for it
        self.rewards = config.rewards
        if self._kappa != config.rewards.kappa:
            self._kappa = config.rewards.kappa
            self._expectation = clock.SwingExpectation.of(self._kappa, torch.zeros(1))

    def get_observations(self) -> TensorDict:
        """The observations of the present state: the tensors that the last step returned."""
        return self._observation

    def step(self, actions: torch.Tensor) -> tuple[TensorDict, torch.Tensor, torch.Tensor, dict[str, Any]]:
        """One control step.

        Args:
            actions: (N, 12); target = default_joint_pos + action_scale * action.

        Returns:
            observations (of the new episode where one ended), rewards (N,), dones (N,) int64, and extras: ``time_outs``
            (N,) and ``log`` (means of the weighted reward terms, of speed error and of falls).
        """
        self.physics.step(self._default_pos + self.robot.action_scale * actions)
        state = self.physics.read()
        self.episode_length_buf += 1
        diverged = ~state.finite()
        if diverged.any():
            state = self._discard(state, diverged)
        self._advance_clock()
        self._filter_velocity(state)
        height, sole_height = self._heights(state)
        terms = self._reward_terms(state, actions, height, sole_height)
        reward = rewards.total(terms, self.rewards.exp_share, self.rewards.softness)
        reward[diverged] = 0.0
        fell = fallen(state, self.config.termination, state.base_pos_w[:, 2] - height) | diverged
        time_out = (self.episode_length_buf >= self.max_episode_length) & ~fell
        extras = {"time_outs": time_out.float(), "log": self._log_values(terms, fell)}
        self.last_action = actions.clone()  # a reset writes to it, and the learner keeps its own
        self.last_torque = state.joint_torque
        changed = self.commands.update(self.episode_length_buf * self.robot.control_dt)
        pushed = self._push_due()
        done = fell | time_out
        ids = torch.nonzero(done).flatten()
        if len(ids):
            self._reset(ids)
        if len(ids) or pushed:
            state = self.physics.read()
            self.last_torque[ids] = state.joint_torque[ids]
        if changed or len(ids):
            self.set_clock()
        self._observation = self._observe(state)
        return self._observation, reward, done.long(), extras

    def state_dict(self) -> dict[str, Any]:
        """All that decides what comes next: the engine, the clock, the commands and the random numbers."""
        return {
            "physics": self.physics.state_dict(),
            "commands": self.commands.state_dict(),
            "generator": self.generator.get_state(),
            "observation": {k: v.clone() for k, v in self._observation.items()},
            **{name: getattr(self, name).clone() for name in self._STATE},
        }

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Go on from :meth:`state_dict`."""
        self.physics.load_state_dict(state["physics"])
        self._set_dynamics(None)
        self.commands.load_state_dict(state["commands"])
        self.generator.set_state(state["generator"])
        self._observation = TensorDict(state["observation"], batch_size=[self.num_envs])
        for name in self._STATE:
            setattr(self, name, state[name].clone())
        self.set_clock()

    _STATE = (
        "episode_length_buf",
        "phase",
        "last_action",
        "last_torque",
        "velocity_h",
        "yaw_error",
        "heading_held",
        "told",
        "push_due",
    )

    def set_clock(self) -> None:
        """What the commands ask of the legs: ``standing``, ``duty``, ``period`` (N,), and ``leg_phases`` (N, 4). To be
        called after a change of the commands or the phase.
        """
        c, v, length = self.commands, self.commands.velocity[:, 0], self.robot.leg_length
        self.standing = stands(c.velocity) & c.config.steered
        self.duty = torch.where(self.standing, STANDING_DUTY, self.timing.duty(v, length, c.duty_delta))
        self.period = self.timing.period(v, length, c.period_delta)
        self._clock_dt = torch.where(self.standing, 0.0, self.robot.control_dt)
        self._set_phases()

    def _set_phases(self) -> None:
        v, reversal = self.commands.velocity[:, 0], self.config.commands.time_reversal
        self.leg_phases = clock.leg_phase(self.phase, self.commands.offsets, v, reversal)

    def _advance_clock(self) -> None:
        self.phase = clock.advance(self.phase, self.period, self._clock_dt)
        self._set_phases()

    def _filter_velocity(self, state: RobotState) -> None:
        strides, dt = self.rewards.velocity_filter, self.robot.control_dt
        now = heading_velocity(state)
        if strides > 0.0:
            gain = -torch.expm1(-dt / (strides * self.period))[:, None]
            now = self.velocity_h + gain * (now - self.velocity_h)
        self.velocity_h = now
        gain = -math.expm1(-dt / self.rewards.heading_filter_s)
        self.yaw_error = self.yaw_error + gain * (now[:, 2] - self.told[:, 2] - self.yaw_error)

    @cached_property
    def _speed_limits(self) -> torch.Tensor:
        return torch.tensor(velocity_limits(self.robot), dtype=torch.float32)

    def _heights(self, state: RobotState) -> tuple[torch.Tensor, torch.Tensor]:
        """Of the trunks, (N,), and of the soles, (N, 4), above the ground below them, m."""
        base, foot = state.base_pos_w, state.foot_pos_w
        return base[:, 2] - self.physics.ground(base), foot[..., 2] - self.physics.ground(
            foot
        ) - self.physics.foot_radius

    def _reward_terms(
        self, state: RobotState, actions: torch.Tensor, height: torch.Tensor, sole_height: torch.Tensor
    ) -> dict[str, torch.Tensor]:
        c, told = self.rewards, self.told
        phases, duty = self.leg_phases, self.duty
        swing, progress = clock.in_swing(phases, duty), clock.swing_progress(phases, duty)
        force, speed = state.foot_force_w.norm(dim=-1), state.foot_vel_w.norm(dim=-1)
        x, y, yaw_rate = self.velocity_h.unbind(dim=1)
        band = self.robot.base_height_range
        expected = self._expectation(phases, duty)
        terms = {
            "x_velocity": c.x_velocity * rewards.velocity_error(x, told[:, 0], c.x_rate),
            "y_velocity": c.y_velocity * rewards.velocity_error(y, told[:, 1], c.y_rate),
            "yaw_velocity": c.yaw_velocity * rewards.velocity_error(yaw_rate, told[:, 2], c.yaw_rate),
            "base_height": c.base_height * rewards.base_height(height, band, c.height_rate),
            "torque_change": c.torque_change
            * rewards.torque_change(state.joint_torque, self.last_torque, c.torque_rate),
            "hip_action": c.hip_action * rewards.hip_action(actions, c.hip_rate),
            "clearance": c.clearance
            * rewards.clearance(sole_height, swing, progress, c.clearance_height, c.clearance_rate),
            "temporal": c.temporal * rewards.temporal(force, speed, expected, c.force_rate, c.foot_speed_rate),
        }
        if c.morphological_term:
            terms["morphological"] = c.morphological * rewards.morphological(
                state.joint_pos, self.commands.offsets, c.pair_rate
            )
        if c.heading > 0.0:
            terms["heading"] = -c.heading * rewards.saturating(self.yaw_error.abs(), c.heading_rate)
        if c.joint_speed > 0.0:
            free = c.joint_speed_share * self._speed_limits
            terms["joint_speed"] = c.joint_speed * rewards.joint_speed(state.joint_vel, free, c.joint_speed_rate)
        if c.stance > 0.0:
            deviation = state.joint_pos - self._default_pos
            terms["stance"] = c.stance * rewards.stance(deviation, self.standing, c.stance_rate)
        return terms

    def _log_values(self, terms: dict[str, torch.Tensor], fell: torch.Tensor) -> dict[str, torch.Tensor]:
        means = torch.stack(list(terms.values())).mean(dim=1)
        log = {f"reward/{name}": mean for name, mean in zip(terms, means, strict=True)}
        error = (self.velocity_h - self.told).abs().mean(dim=0)
        log["task/x_velocity_error"], log["task/y_velocity_error"], log["task/yaw_rate_error"] = error
        log["task/fell_per_s"] = fell.float().mean() / self.robot.control_dt
        return log

    def _observe(self, state: RobotState) -> TensorDict:
        self._steer(state)
        situation = Situation(
            sensed=Sensed(
                projected_gravity(state.base_quat_w),
                state.joint_pos + self._joint_offset,
                state.joint_vel,
                state.base_ang_vel_b,
            ),
            default_joint_pos=self._default_pos,
            last_action=self.last_action,
            offsets=self.commands.offsets,
            velocity=self.told,
            leg_phases=self.leg_phases,
            duty=self.duty,
        )
        policy = observe(self.layout, situation)
        if self.config.randomization.observation_noise:
            policy += self._noise * uniform((-1.0, 1.0), tuple(policy.shape), self.generator)
        height, sole_height = self._heights(state)
        changing = privileged_terms(
            state, self.velocity_h, self.leg_phases, self._default_pos, height - self.robot.base_height, sole_height
        )
        privileged = PRIVILEGED.assemble(changing | self._constant)
        return TensorDict({"policy": policy, "privileged": privileged}, batch_size=[self.num_envs])

    def _steer(self, state: RobotState) -> None:
        """What the policy is told: the commands, with the yaw rate of heading hold where that is on."""
        command = self.commands.velocity
        if not self.config.commands.hold_share:
            self.told = command.clone()
            return
        hold = self.config.commands.steering.heading_hold
        held, self.heading_held = hold.apply(command, yaw(state.base_quat_w), self.heading_held)
        self.told = torch.where(self._held[:, None], held, command)

    def _set_dynamics(self, dynamics: Dynamics | None) -> None:
        """Make the robots others; None takes those that the engine has."""
        if dynamics is not None:
            self.physics.set_dynamics(dynamics)
        self._constant = constant_terms(self.physics.dynamics)
        self._joint_offset = torch.from_numpy(self.physics.dynamics.joint_offset).float()

    def _reset(self, ids: torch.Tensor) -> None:
        n, r = len(ids), self.config.reset
        joint_noise = uniform((-r.joint_noise, r.joint_noise), (n, self.num_actions), self.generator)
        velocity = uniform((-r.velocity_noise, r.velocity_noise), (n, 3), self.generator)
        heading = uniform((-np.pi, np.pi), (n,), self.generator)
        self.commands.reset(ids)
        if r.commanded_share > 0.0:
            share = uniform((0.0, r.commanded_share), (n, 1), self.generator)
            velocity[:, :2] += share * self.commands.velocity[ids, :2]
        quat = torch.stack([torch.cos(heading / 2), 0 * heading, 0 * heading, torch.sin(heading / 2)], dim=1)
        position = torch.zeros(n, 3)
        position[:, 2] = self.robot.base_height
        pose = Pose(
            base_pos_w=position.double().numpy(),
            base_quat_w=quat.double().numpy(),
            # drawn in the heading frame; the rotation's inverse is that by minus the angle
            base_vel_w=rotate_inverse(quat * torch.tensor([1.0, -1.0, -1.0, -1.0]), velocity).double().numpy(),
            joint_pos=(self._default_pos + joint_noise).double().numpy(),
        )
        self.physics.reset(ids.numpy(), pose)
        self.episode_length_buf[ids] = 0
        self.phase[ids] = torch.rand(n, generator=self.generator)
        self.last_action[ids] = 0.0
        self.velocity_h[ids] = torch.cat([velocity[:, :2], torch.zeros(n, 1)], dim=1)
        self.yaw_error[ids] = 0.0
        self.heading_held[ids] = heading
        self.push_due[ids] = uniform(self.config.randomization.push_interval_s, (n,), self.generator)
        self.set_clock()

    def _push_due(self) -> bool:
        time = self.episode_length_buf * self.robot.control_dt
        ids = torch.nonzero(time >= self.push_due).flatten()
        if not len(ids):
            return False
        r = self.config.randomization
        velocity = torch.zeros(len(ids), 3)
        velocity[:, :2] = uniform(r.push, (len(ids), 2), self.generator)
        self.physics.push(ids.numpy(), velocity.double().numpy())
        self.push_due[ids] = time[ids] + uniform(r.push_interval_s, (len(ids),), self.generator)
        return True

    def _discard(self, state: RobotState, diverged: torch.Tensor) -> RobotState:
        """Log and dump simulations that diverged; the state returned has zeros for them (they are reset next)."""
        ids = torch.nonzero(diverged).flatten().tolist()
        _log.warning("%d of %d simulations diverged and are reset: %s", len(ids), self.num_envs, ids[:8])
        if self._dump_dir is not None:
            commands = {k: _as_text(v[ids[0]].tolist()) for k, v in self.commands.state_dict().items()}
            dump = {"env": ids[0], "commands": commands}
            dump |= {k: _as_text(v) for k, v in self.physics.dump(ids[0]).items()}
            write_json(self._dump_dir / f"diverged_env{ids[0]}.json", dump)
        clean = {}
        for name, value in vars(state).items():
            value = value.clone()
            value[diverged] = 0.0
            clean[name] = value
        return RobotState(**clean)


def _as_text(value: Any) -> Any:
    """Numbers as JSON holds them exactly; those that are no JSON (nan, inf) as Python writes them."""
    if isinstance(value, list):
        return [_as_text(item) for item in value]
    return value if not isinstance(value, float) or math.isfinite(value) else repr(value)
