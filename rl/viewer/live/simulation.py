"""One robot under a policy, told what to do while it runs.

The steps are those of rl.judging.simulate, sample for sample: a test holds the two together.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

import numpy as np
import torch
from numpy.typing import NDArray

from rl.judging.simulate import Script, Segment, sample, sensed, standing
from rl.physics.batch import BatchPhysics
from rl.physics.dynamics import Dynamics
from rl.physics.model import build_model
from rl.physics.terrain import Terrain
from rl.task.settings import TerminationConfig
from rl.task.termination import fallen
from rl.viewer.live.history import History
from symdyn.errors import InvalidValue
from symdyn.gait.library import Gait
from symdyn.gait.timing import GRAVITY
from symdyn.policy.driver import PolicyDriver
from symdyn.policy.file import Policy
from symdyn.policy.metadata import COMMANDS
from symdyn.robot.frames import yaw

HISTORY_S = 4.0
"""s that are remembered: two windows of the strips."""

LIES_S = 1.5
"""s that a robot lies where it fell before it is put back on its feet: long enough to see what happened."""

BUMPS = Terrain(half_size=40.0)
"""The uneven ground: bumps as in the experiments, and room for 20 s at full speed."""

_MARGIN = 1.0
"""m from the edge of the ground, where a robot is taken back to the middle."""

_ALL = np.array([0])

Cause = Literal["begun", "reset", "fell", "edge", "ground"]


@dataclass(frozen=True)
class World:
    """What the robot is and runs on, where it differs from the nominal.

    Attributes:
        payload: mass added to the trunk, kg.
        friction: factor on the nominal friction of the ground.
        terrain: the ground; flat if None.
    """

    payload: float = 0.0
    friction: float = 1.0
    terrain: Terrain | None = None

    def __post_init__(self) -> None:
        if not -5.0 <= self.payload <= 30.0:  # the trunk weighs 6.9 kg, and must not vanish
            raise InvalidValue("The payload", self.payload, "from -5 to 30 kg")
        if not 0.01 <= self.friction <= 10.0:
            raise InvalidValue("The friction factor", self.friction, "from 0.01 to 10")


class LiveSimulation:
    """A robot that starts on its feet, runs, is put back on its feet when it has fallen, and forgets what was before.

    Not to be called from several threads at once, but for ``history``.

    Args:
        policy: to run.
        seed: decides the stride phases of all starts.

    Attributes:
        policy: that runs.
        robot: that it drives.
        driver: clock and memory of the policy.
        physics: of the present ground.
        history: of the last :data:`HISTORY_S`, since the last start.
        gait: commanded.
        velocity: commanded v_x, v_y (m/s) and yaw rate (rad/s).
        world: as it is now.
        fell_at: time of the fall, s, or None.
        falls: how many there were.
        cause: why it was put on its feet the last time.
    """

    def __init__(self, policy: Policy, seed: int = 0) -> None:
        self.policy = policy
        self.robot = policy.robot
        self.gait: Gait = next(iter(policy.gaits.values()))
        self.velocity = (0.0, 0.0, 0.0)
        self.world = World()
        self.falls = 0
        self._rng = np.random.default_rng(seed)
        self._limits = TerminationConfig()
        self._grounds: dict[Terrain | None, BatchPhysics] = {}
        self.physics = self._physics_on(None)
        self._dt = self.robot.control_dt / self.physics.substeps
        self.history = History(HISTORY_S, self._dt, GRAVITY)
        self._start("begun")

    @property
    def mass(self) -> float:
        """Of the robot with its payload, kg."""
        return float(self.physics.model.body_mass.sum()) + self.world.payload

    @property
    def command_range(self) -> Mapping[str, tuple[float, float]]:
        """What the policy was trained for, by the name of each command."""
        return MappingProxyType(dict(self.policy.metadata.command_range))

    def command(self, gait: Gait | None = None, velocity: tuple[float, float, float] | None = None) -> None:
        """Tell the robot to run so from the next step on; what is None stays.

        Raises:
            InvalidValue: if a velocity is outside of the range of the training.
        """
        if velocity is not None:
            for name, value in zip(COMMANDS, velocity, strict=True):
                low, high = self.command_range[name]
                if not low <= value <= high:
                    raise InvalidValue(f"The commanded {name}", value, f"from {low:g} to {high:g}")
            self.velocity = velocity
        if gait is not None:
            self.gait = gait
        self._pass_on()

    def set_world(self, world: World) -> None:
        """Change payload, friction or ground. On another ground the robot starts anew, in its middle."""
        ground_changes = world.terrain != self.world.terrain
        weight_changes = world.payload != self.world.payload
        if ground_changes:
            self.physics = self._physics_on(world.terrain)
        self.world = world
        self.physics.set_dynamics(
            Dynamics.nominal(1, added_mass=np.array([world.payload]), friction=np.array([world.friction]))
        )
        if ground_changes:
            self._start("ground")
        elif weight_changes:
            self.history.mass = self.mass

    def push(self, momentum_h: tuple[float, float]) -> None:
        """Give the robot a momentum at once, N s forwards and to its left: all of its parts gain the same velocity."""
        heading = float(yaw(self._state.base_quat_w.double().numpy())[0])
        forward, left = momentum_h
        cos, sin = np.cos(heading), np.sin(heading)
        momentum_w = np.array([[cos * forward - sin * left, sin * forward + cos * left, 0.0]])
        self.physics.push(_ALL, momentum_w / self.mass)

    def reset(self) -> None:
        """Put the robot on its feet in the middle of the ground, with a new stride phase."""
        self._start("reset")

    def step(self) -> None:
        """One control step; a fallen robot that has lain for long enough, or one at the edge, starts anew after it."""
        down = self.fell_at is not None
        targets = self.driver.act(sensed(self._state))
        self.physics.set_targets(self.policy.targets(np.zeros_like(self.driver.action)) if down else targets)
        for _ in range(self.physics.substeps):
            self.physics.substep()
            self.driver.advance(self._dt)
            self._state = self.physics.read()
            self.history.append(sample(self._state, self.driver))
        self._steps += 1
        self._judge()

    @property
    def time(self) -> float:
        """Since the last start, s."""
        return self._steps * self.robot.control_dt

    def _judge(self) -> None:
        state, terrain = self._state, self.world.terrain
        if not bool(state.finite()[0]):
            self.falls += self.fell_at is None
            self._start("fell")
            return
        position = _array(state.base_pos_w)[:, :2]
        ground = 0.0 if terrain is None else terrain.height(position)
        if self.fell_at is None and bool(fallen(state, self._limits, torch.as_tensor(ground))[0]):
            self.fell_at = self.time
            self.falls += 1
        if self.fell_at is not None and self.time >= self.fell_at + LIES_S - 1e-9:
            self._start("fell")
        elif terrain is not None and np.abs(position).max() > terrain.half_size - _MARGIN:
            self._start("edge")

    def _start(self, cause: Cause) -> None:
        self.cause: Cause = cause
        self.fell_at: float | None = None
        self._steps = 0
        place = Script("live", (Segment(0.0, self.gait, self.velocity),), self.robot.control_dt)
        self.physics.reset(_ALL, standing([place], self.robot, self.world.terrain))
        self.driver = PolicyDriver(self.policy, [self._rng.random()])
        self._pass_on()
        self._state = self.physics.read()
        self.history.restart(self.mass)

    def _pass_on(self) -> None:
        self.driver.offsets[0] = self.gait.theta
        self.driver.velocity[0] = self.velocity

    def _physics_on(self, terrain: Terrain | None) -> BatchPhysics:
        if terrain not in self._grounds:
            self._grounds[terrain] = BatchPhysics(build_model(self.robot, terrain), self.robot, 1, num_threads=1)
        return self._grounds[terrain]


def _array(tensor: torch.Tensor) -> NDArray[np.float64]:
    return tensor.double().numpy()
