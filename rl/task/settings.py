"""Settings of the task: commands, rewards, starts, ends. Nothing here imports torch, so that --help is quick."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from typing import Literal

from rl.physics.randomization import RandomizationConfig
from symdyn.errors import InvalidValue
from symdyn.gait.library import PAPER_GAITS, get
from symdyn.policy.observation import get_layout
from symdyn.policy.steering import Steering


@dataclass(frozen=True)
class CommandConfig:
    """How commands are drawn; the defaults are the paper's (section III-E).

    Attributes:
        gaits: names from the library.
        choose: ``class`` draws a symmetry class first and then one of its gaits; ``gait`` draws a gait.
        weights: relative sampling weight of each gait, in the order of ``gaits``; all alike if empty.
        offset_noise: half-width of the uniform noise on each offset, strides.
        noise_keeps_class: legs in phase share their noise, so that K and the pairs sigma(i, j) of the gait survive;
            False draws it leg by leg (paper), with which a pair survives in 44% of the draws (epsilon_sigma 0.01).
        mixture_share: share of the commands that are mixtures: a random part of the way from one drawn gait to another
            (:meth:`symdyn.gait.library.Gait.towards`). With single gaits alone a policy may learn nine patterns; with
            mixtures each leg must follow its own clock.
        velocity_x: range of forward velocity, m/s.
        forward_share: share of commands with v_x > 0, where the range has both signs; None draws uniformly from the
            range (paper). Forward running is learned later than backward running.
        velocity_y: range of lateral velocity, m/s.
        yaw_rate: range of the yaw rate, rad/s.
        lateral_acceleration: largest |v_x * yaw rate|, m/s^2: fast robots are told to turn less; None for no bound.
        turn_share: share of the commands with a yaw rate; in the others it is zero.
        sidestep_share: share of the commands with a lateral velocity.
        in_place_share: share of the commands without a forward velocity.
        stand_share: share of the commands that are zero.
        steered: whether commands pass through ``steering``: small ones are zero, and at zero command the robot stands
            still. False steps in place (paper).
        steering: dead band and heading hold.
        hold_share: share of the robots, the first ones, whose heading is held while their command has no yaw rate.
        velocity_first_s: time into the episode of the first change of velocity, drawn from this range, s.
        velocity_again_s: time between later changes, s; empty for none.
        gait_first_s: time into the episode of the first change of gait, drawn from this range, s.
        gait_again_s: time between later changes of gait, s; empty for none.
        time_reversal: the map of the paper's eq. (7) for v < 0; False is an ablation of the paper.
    """

    gaits: tuple[str, ...] = PAPER_GAITS
    choose: Literal["class", "gait"] = "gait"
    weights: tuple[float, ...] = ()
    offset_noise: float = 0.02
    noise_keeps_class: bool = False
    mixture_share: float = 0.0
    velocity_x: tuple[float, float] = (-2.0, 2.0)
    forward_share: float | None = None
    velocity_y: tuple[float, float] = (0.0, 0.0)
    yaw_rate: tuple[float, float] = (0.0, 0.0)
    lateral_acceleration: float | None = None
    turn_share: float = 1.0
    sidestep_share: float = 1.0
    in_place_share: float = 0.0
    stand_share: float = 0.0
    steered: bool = False
    steering: Steering = field(default_factory=Steering)
    hold_share: float = 0.0
    velocity_first_s: tuple[float, float] = (10.0, 10.0)
    velocity_again_s: tuple[float, float] | None = None
    gait_first_s: tuple[float, float] = (20.0, 20.0)
    gait_again_s: tuple[float, float] | None = None
    time_reversal: bool = True

    def __post_init__(self) -> None:
        if not self.gaits:
            raise InvalidValue("The list of gaits to train", self.gaits, "at least one name")
        for name in self.gaits:
            get(name)
        if self.weights and not (
            len(self.weights) == len(self.gaits) and all(0.0 < weight < math.inf for weight in self.weights)
        ):
            raise InvalidValue("weights", self.weights, f"{len(self.gaits)} numbers > 0, one a gait")
        if not 0.0 <= self.offset_noise < 0.5:
            raise InvalidValue("offset_noise", self.offset_noise, "in [0, 0.5)")
        for item in fields(self):
            value = getattr(self, item.name)
            if item.name.endswith("_share") and value is not None and not 0.0 <= value <= 1.0:
                raise InvalidValue(item.name, value, "in [0, 1]")
            if item.name.endswith(("_s", "_x", "_y", "_rate")) and value is not None:
                low, high = value
                if not -math.inf < low <= high < math.inf:
                    raise InvalidValue(item.name, value, "two finite numbers, the smaller first")
                if item.name.endswith("_s") and low <= 0.0:
                    raise InvalidValue(item.name, value, "times > 0")
        if self.lateral_acceleration is not None and not 0.0 < self.lateral_acceleration < math.inf:
            raise InvalidValue("lateral_acceleration", self.lateral_acceleration, "a number > 0")
        if self.in_place_share + self.stand_share > 1.0:
            raise InvalidValue(
                "in_place_share", self.in_place_share, f"at most 1 - stand_share, {1.0 - self.stand_share:g}"
            )
        if (self.stand_share > 0.0 or self.hold_share > 0.0) and not self.steered:
            raise InvalidValue("steered", self.steered, "True where robots are told to stand or hold their heading")
        if self.forward_share is not None and not self.velocity_x[0] < 0.0 < self.velocity_x[1]:
            raise InvalidValue("velocity_x", self.velocity_x, "a range with both signs, for a forward_share")


@dataclass(frozen=True)
class RewardConfig:
    """Weights and shapes; the defaults are the paper's.

    Attributes:
        x_velocity: weight of the forward velocity. A term lies in [-weight, 0], in units of reward.
        y_velocity: weight of the lateral velocity.
        yaw_velocity: weight of the yaw rate.
        base_height: weight of the trunk's height.
        torque_change: weight of changes of torque.
        hip_action: weight of hip actions.
        clearance: weight of the clearance of swinging feet.
        temporal: weight of the clock (R_tem), for each leg.
        morphological: weight of the likeness of legs in phase (R_mor).
        x_rate: 1 - exp(-rate * error), per m/s.
        y_rate: per m/s.
        yaw_rate: per rad/s.
        height_rate: per m outside the band.
        torque_rate: per N m of summed change.
        hip_rate: per unit of action.
        clearance_rate: per m of shortfall.
        force_rate: per N on a foot that should swing.
        foot_speed_rate: per m/s of a foot that should stand.
        pair_rate: per rad of summed difference between legs in phase.
        clearance_height: height that the sole of a swinging foot should reach, m (the paper gives none).
        kappa: concentration of the von Mises smoothing of swing and stance (the paper gives none): 16 is 4% of a
            stride.
        morphological_term: False leaves out R_mor (an ablation of the paper).
        velocity_filter: time constant of a low-pass on the velocities before they are judged, in strides; 0 judges the
            instantaneous ones (paper). Asymmetric gaits sway within every stride and are not to be punished for it.
        exp_share: 0 makes the reward max(0, 1 + sum) (paper); 1 makes it exp(sum), which agrees with that to first
            order near the optimum and, never being clipped, has a slope everywhere; between them it is their mixture.
        heading: weight of the yaw rate's error averaged over several strides, whose integral is the error of the
            heading (not in the paper).
        heading_rate: per rad/s.
        heading_filter_s: time constant of that average, s.
        joint_speed: weight of joint speeds near the motors' limits (not in the paper).
        joint_speed_rate: per rad/s beyond ``joint_speed_share``, summed over joints.
        joint_speed_share: share of a joint's velocity limit that costs nothing.
        stance: weight of the deviation from the nominal stance while standing (not in the paper).
        stance_rate: per rad, summed over joints.
        softness: width of the smooth bend in place of the corner of max(0, 1 + sum), in units of reward; 0 keeps the
            corner (paper).
    """

    x_velocity: float = 0.3
    y_velocity: float = 0.3
    yaw_velocity: float = 0.3
    base_height: float = 0.3
    torque_change: float = 0.1
    hip_action: float = 0.15
    clearance: float = 0.15
    temporal: float = 0.15
    morphological: float = 0.15
    x_rate: float = 2.0
    y_rate: float = 10.0
    yaw_rate: float = 5.0
    height_rate: float = 5.0
    torque_rate: float = 0.1
    hip_rate: float = 0.5
    clearance_rate: float = 20.0
    force_rate: float = 0.001
    foot_speed_rate: float = 2.0
    pair_rate: float = 5.0
    clearance_height: float = 0.05
    kappa: float = 16.0
    morphological_term: bool = True
    velocity_filter: float = 0.0
    exp_share: float = 0.0
    softness: float = 0.0
    heading: float = 0.0
    heading_rate: float = 8.0
    heading_filter_s: float = 1.0
    joint_speed: float = 0.0
    joint_speed_rate: float = 0.5
    joint_speed_share: float = 0.85
    stance: float = 0.0
    stance_rate: float = 0.5

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if isinstance(value, float) and not 0.0 <= value < math.inf:
                raise InvalidValue(item.name, value, "a number >= 0")
        for name in ("exp_share", "joint_speed_share"):
            if getattr(self, name) > 1.0:
                raise InvalidValue(name, getattr(self, name), "in [0, 1]")
        if self.heading_filter_s == 0.0:
            raise InvalidValue("heading_filter_s", self.heading_filter_s, "a time > 0")


@dataclass(frozen=True)
class ResetConfig:
    """How an episode begins: the default pose just above the ground, disturbed.

    Attributes:
        joint_noise: half-width on every joint angle, rad.
        velocity_noise: half-width on each component of the trunk's velocity in the heading frame, m/s.
        commanded_share: the trunk already moves at up to this share of the commanded velocity, drawn uniformly: a robot
            that is thrown forward has to run, and finds out what running is worth (cf. the initial states of
            Peng et al. 2018).
    """

    joint_noise: float = 0.1
    velocity_noise: float = 0.3
    commanded_share: float = 0.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not 0.0 <= value < math.inf:
                raise InvalidValue(f"reset.{name}", value, "a number >= 0")


@dataclass(frozen=True)
class TerminationConfig:
    """When an episode ends before its time.

    Attributes:
        height: trunk origin lower than this above the ground, m.
        roll: trunk rolled further than this, rad.
        pitch: trunk pitched further than this, rad.
    """

    height: float = 0.18
    roll: float = 0.8
    pitch: float = 1.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not 0.0 < value < math.inf:
                raise InvalidValue(f"termination.{name}", value, "a number > 0")


@dataclass(frozen=True)
class EnvConfig:
    """Everything about the task.

    Attributes:
        episode_s: length of an episode, s (paper).
        observation: what the policy sees, by its name in symdyn.policy.observation; symdyn gaits --observation lists
            them.
    """

    episode_s: float = 30.0
    observation: str = "paper"
    commands: CommandConfig = field(default_factory=CommandConfig)
    rewards: RewardConfig = field(default_factory=RewardConfig)
    randomization: RandomizationConfig = field(default_factory=RandomizationConfig)
    termination: TerminationConfig = field(default_factory=TerminationConfig)
    reset: ResetConfig = field(default_factory=ResetConfig)

    def __post_init__(self) -> None:
        get_layout(self.observation)
        if not 0.0 < self.episode_s < math.inf:
            raise InvalidValue("episode_s", self.episode_s, "a finite time > 0, s")
