"""What a policy file says about itself: all that deploys its network, as JSON inside the file."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from symdyn.errors import FileProblem, InvalidValue, PolicyMismatch
from symdyn.gait.library import Gait
from symdyn.gait.timing import GRAVITY, TimingCurve
from symdyn.io.settings_data import plain, rebuild
from symdyn.policy.json_fields import Fields
from symdyn.policy.layout import Layout
from symdyn.policy.observation import read_layout
from symdyn.policy.steering import Steering
from symdyn.robot.definition import Robot
from symdyn.robot.legs import JOINTS, LEGS

FORMAT_VERSION = 1
COMMANDS = ("velocity_x", "velocity_y", "yaw_rate")
"""The order of velocity commands."""

_POSITIVE = ("action_scale", "kp", "kd", "control_dt", "leg_length", "gravity")


@dataclass(frozen=True)
class PolicyMetadata:
    """What stands in a policy file beside the network. target = default_joint_pos + action_scale * action.

    Attributes:
        robot: name of the robot.
        joint_names: the URDF's names in the order of the actions, which is that of :data:`symdyn.robot.legs.JOINTS`.
        default_joint_pos: (12,) rad.
        action_scale: rad of target per unit of action.
        kp: N m/rad.
        kd: N m s/rad.
        control_dt: time between two actions, s.
        leg_length: the length of the timing curve, m.
        gravity: the gravity of the timing curve, m/s^2.
        observation: what the network sees; the file holds name, size, scale, labels, unit and frame of each term.
        gaits: those that it was trained for, by name.
        timing: T(v) and beta(v).
        command_range: (low, high) of each of :data:`COMMANDS` in training, m/s, m/s, rad/s.
        time_reversal: whether the phase map for v < 0 was used in training.
        steering: dead band and heading hold of its commands; None for a policy that was trained without, which steps in
            place at zero command.
        training: where it came from: ``commit`` of the checkout that made the file (``-dirty`` if it had changes, or
            ``unknown``); ``config``, the nested settings of the run; ``samples`` learned from; ``seed`` of the run.
    """

    robot: str
    joint_names: tuple[str, ...]
    default_joint_pos: tuple[float, ...]
    action_scale: float
    kp: float
    kd: float
    control_dt: float
    leg_length: float
    gravity: float
    observation: Layout
    gaits: Mapping[str, Gait]
    timing: TimingCurve
    command_range: Mapping[str, tuple[float, float]]
    time_reversal: bool
    training: Mapping[str, Any]
    steering: Steering | None = None

    def to_json(self) -> str:
        """As the policy file holds it. Numbers are exact."""
        data = {
            "format_version": FORMAT_VERSION,
            "robot": self.robot,
            "joint_names": list(self.joint_names),
            "default_joint_pos": list(self.default_joint_pos),
            **{name: getattr(self, name) for name in _POSITIVE},
            "observation": self.observation.as_list(),
            "gaits": {name: gait.by_leg() for name, gait in self.gaits.items()},
            "timing": self.timing.as_dict(),
            "command_range": {name: list(bounds) for name, bounds in self.command_range.items()},
            "time_reversal": self.time_reversal,
            "training": dict(self.training),
        }
        if self.steering is not None:
            data["steering"] = plain(self.steering)
        return json.dumps(data, allow_nan=False)

    @classmethod
    def from_json(cls, text: str, origin: object) -> PolicyMetadata:
        """From :meth:`to_json`.

        Args:
            text: JSON.
            origin: what to call its source in an error.

        Raises:
            PolicyMismatch: if it is of another format version, or observes what this symdyn cannot supply.
            FileProblem: if it is no JSON, or a key is missing, of a wrong type or length, or not finite.
        """
        try:
            data = json.loads(text, parse_float=_finite, parse_constant=_finite)
        except (ValueError, RecursionError) as error:
            raise FileProblem(origin, f"has metadata that is not valid JSON ({error}).") from error
        fields = Fields(data, origin)
        version = fields["format_version"]
        if type(version) is not int or version != FORMAT_VERSION:
            raise PolicyMismatch(
                f"{origin}: is of format_version {version!r}, but this version of symdyn reads only {FORMAT_VERSION}."
            )
        training, ranges = fields.nested("training"), fields.nested("command_range")
        return cls(
            robot=fields.text("robot"),
            joint_names=fields.texts("joint_names", len(JOINTS)),
            default_joint_pos=fields.numbers("default_joint_pos", len(JOINTS)),
            **{name: fields.number(name, positive=True) for name in _POSITIVE},
            observation=_read_observation(fields),
            gaits=_read_gaits(fields),
            timing=TimingCurve.from_dict(fields["timing"], origin),
            command_range={name: ranges.bounds(name) for name in COMMANDS},
            time_reversal=fields.flag("time_reversal"),
            training={
                "commit": training.text("commit"),
                "config": training.nested("config").data,
                "samples": training.whole("samples"),
                "seed": training.whole("seed"),
            },
            steering=rebuild(Steering, data["steering"], origin) if "steering" in data else None,
        )

    def check_made_for(self, robot: Robot, origin: object) -> None:
        """Check that a policy with this metadata can run on a robot.

        Args:
            robot: at hand.
            origin: what to call the policy in an error.

        Raises:
            PolicyMismatch: if robot, joints or gravity differ.
        """
        if self.robot != robot.name:
            raise PolicyMismatch(f"{origin}: was made for the robot {self.robot!r}, not for {robot.name!r}.")
        if self.joint_names != robot.joint_names:
            pairs = enumerate(zip(self.joint_names, robot.joint_names, strict=True))
            number, (its, ours) = next((i, pair) for i, pair in pairs if pair[0] != pair[1])
            raise PolicyMismatch(
                f"{origin}: does not have the joints of {robot.name}: joint {number} is {its!r}, but must be {ours!r}."
            )
        if self.gravity != GRAVITY:
            raise PolicyMismatch(
                f"{origin}: has a timing curve for a gravity of {self.gravity} m/s^2, but this symdyn uses {GRAVITY}."
            )

    def applied_to(self, robot: Robot) -> Robot:
        """The robot with the stance, gains, rate and leg length that the policy was trained with."""
        return replace(
            robot.standing_at(np.array(self.default_joint_pos)),
            action_scale=self.action_scale,
            kp=self.kp,
            kd=self.kd,
            control_dt=self.control_dt,
            leg_length=self.leg_length,
        )


def _finite(text: str) -> float:
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"{text} is not finite")
    return number


def _read_observation(fields: Fields) -> Layout:
    terms = fields["observation"]
    if not isinstance(terms, list):
        raise fields.wrong("observation", terms, "a list of terms")
    found = []
    for number, value in enumerate(terms):
        term = Fields(value, fields.origin, f"observation[{number}].")
        entry: dict[str, Any] = {"name": term.text("name"), "size": term.whole("size"), "scale": term.number("scale")}
        if "labels" in term.data:  # older files have none
            labels = term["labels"]
            if not isinstance(labels, list):
                raise term.wrong("labels", labels, "a list of names")
            entry["labels"] = labels
        found.append(entry)
    if not found:
        raise fields.wrong("observation", terms, "at least one term")
    return read_layout(found, fields.origin)


def _read_gaits(fields: Fields) -> dict[str, Gait]:
    table = fields.nested("gaits")
    if not table.data:
        raise fields.wrong("gaits", {}, "at least one gait")
    found = {}
    for name in table.data:
        legs = table.nested(name)
        lh, lf, rf, rh = (legs.number(leg) for leg in LEGS)
        try:
            found[name] = Gait(name, (lh, lf, rf, rh))
        except InvalidValue as error:
            raise FileProblem(fields.origin, f"contains an invalid gait. {error}") from error
    return found
