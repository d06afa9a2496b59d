"""The deployable policy: one ONNX file that carries everything needed to run it, run by onnxruntime alone.

The network takes ``obs`` (N, 52) and gives ``actions`` (N, 12); beside it, under the metadata key ``symdyn``, the file
holds :class:`PolicyMetadata` as JSON. Evaluation, the viewer and the robot load nothing else.
"""

from __future__ import annotations

import json
import math
import os
import re
import reprlib
import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import onnxruntime
from numpy.typing import ArrayLike, NDArray

from symdyn.errors import FileProblem, InvalidValue, PolicyMismatch
from symdyn.gait.library import Gait
from symdyn.gait.timing import GRAVITY, TimingCurve
from symdyn.policy.observation import OBSERVATION
from symdyn.robot.definition import GO2, Robot
from symdyn.robot.legs import JOINTS, LEGS

FORMAT_VERSION = 1
METADATA_KEY = "symdyn"
INPUT, OUTPUT = "obs", "actions"
COMMANDS = ("velocity_x", "velocity_y", "yaw_rate")
"""The order of velocity commands."""

_LARGEST = 256 * 2**20
_POSITIVE = ("action_scale", "kp", "kd", "control_dt", "leg_length", "gravity")
# ONNX marks a tensor that lies in another file by an entry of this key; these are the entry's first bytes in protobuf.
_EXTERNAL_MARK = b"\n\x08location"


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
        observation: name, size and scale of each term in order (:meth:`symdyn.policy.observation.Layout.as_list`).
        gaits: those that it was trained for, by name.
        timing: T(v) and beta(v).
        command_range: (low, high) of each of :data:`COMMANDS` in training, m/s, m/s, rad/s.
        time_reversal: whether the phase map for v < 0 was used in training.
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
    observation: tuple[Mapping[str, Any], ...]
    gaits: Mapping[str, Gait]
    timing: TimingCurve
    command_range: Mapping[str, tuple[float, float]]
    time_reversal: bool
    training: Mapping[str, Any]

    def to_json(self) -> str:
        """As the policy file holds it. Numbers are exact."""
        data = {
            "format_version": FORMAT_VERSION,
            "robot": self.robot,
            "joint_names": list(self.joint_names),
            "default_joint_pos": list(self.default_joint_pos),
            **{name: getattr(self, name) for name in _POSITIVE},
            "observation": [dict(term) for term in self.observation],
            "gaits": {name: gait.by_leg() for name, gait in self.gaits.items()},
            "timing": self.timing.as_dict(),
            "command_range": {name: list(bounds) for name, bounds in self.command_range.items()},
            "time_reversal": self.time_reversal,
            "training": dict(self.training),
        }
        return json.dumps(data, allow_nan=False)

    @classmethod
    def from_json(cls, text: str, origin: object) -> PolicyMetadata:
        """From :meth:`to_json`.

        Args:
            text: JSON.
            origin: what to call its source in an error.

        Raises:
            PolicyMismatch: if it is of another format version.
            FileProblem: if it is no JSON, or a key is missing, of a wrong type or length, or not finite.
        """
        try:
            data = json.loads(text, parse_float=_finite, parse_constant=_finite)
        except (ValueError, RecursionError) as error:
            raise FileProblem(origin, f"has metadata that is not valid JSON ({error}).") from error
        fields = _Fields(data, origin)
        version = fields["format_version"]
        if type(version) is not int or version != FORMAT_VERSION:
            raise PolicyMismatch(
                f"{origin}: is of format_version {version!r}, but this symdyn reads only {FORMAT_VERSION}."
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
        )

    def check_made_for(self, robot: Robot, origin: object) -> None:
        """Check that a policy with this metadata can run on a robot, with this version of the observation.

        Args:
            robot: at hand.
            origin: what to call the policy in an error.

        Raises:
            PolicyMismatch: if robot, joints, observation or gravity differ.
        """
        if self.robot != robot.name:
            raise PolicyMismatch(f"{origin}: was made for the robot {self.robot!r}, not for {robot.name!r}.")
        if self.joint_names != robot.joint_names:
            pairs = enumerate(zip(self.joint_names, robot.joint_names, strict=True))
            number, (its, ours) = next((i, pair) for i, pair in pairs if pair[0] != pair[1])
            raise PolicyMismatch(
                f"{origin}: has other joints than {robot.name}: number {number} is {its!r}, but must be {ours!r}."
            )
        layout = OBSERVATION.as_list()
        if list(self.observation) != layout:
            raise PolicyMismatch(
                f"{origin}: observes {_layout_text(self.observation)}, but this symdyn observes {_layout_text(layout)}."
            )
        if self.gravity != GRAVITY:
            raise PolicyMismatch(
                f"{origin}: has a timing curve for a gravity of {self.gravity} m/s^2, but this symdyn uses {GRAVITY}."
            )


class Policy:
    """A policy, ready to run on one thread. Made by :meth:`load`.

    Attributes:
        metadata: what the file says about itself.
    """

    def __init__(self, session: onnxruntime.InferenceSession, metadata: PolicyMetadata) -> None:
        self._session = session
        self._default_joint_pos = np.array(metadata.default_joint_pos)
        self.metadata = metadata

    @classmethod
    def load(cls, path: Path | str, robot: Robot = GO2) -> Policy:
        """Read a policy file.

        Args:
            path: of the .onnx file.
            robot: that it is to run on.

        Raises:
            FileProblem: if the file is missing, no ONNX, not whole in itself, or lacks sound metadata.
            PolicyMismatch: if it was made for another robot, observation or format.
        """
        path = Path(path)
        session = _open_session(path)
        text = session.get_modelmeta().custom_metadata_map.get(METADATA_KEY)
        if text is None:
            raise FileProblem(path, f"is an ONNX file, but no policy of symdyn: it has no metadata {METADATA_KEY!r}.")
        metadata = PolicyMetadata.from_json(text, path)
        metadata.check_made_for(robot, path)
        _check_tensor(path, "input", session.get_inputs(), INPUT, OBSERVATION.size)
        _check_tensor(path, "output", session.get_outputs(), OUTPUT, len(JOINTS))
        policy = cls(session, metadata)
        policy._try_out(path)
        return policy

    def with_timing(self, timing: TimingCurve) -> Policy:
        """The same network under other curves."""
        return Policy(self._session, replace(self.metadata, timing=timing))

    @property
    def timing(self) -> TimingCurve:
        """T(v) and beta(v) of the training; with ``metadata.leg_length``."""
        return self.metadata.timing

    @property
    def gaits(self) -> Mapping[str, Gait]:
        """The gaits of the training, by name."""
        return self.metadata.gaits

    def act(self, obs: ArrayLike) -> NDArray[np.float32]:
        """The policy's mean actions.

        Args:
            obs: (n, 52) as :data:`symdyn.policy.observation.OBSERVATION` assembles them; n >= 1.

        Returns:
            (n, 12) float32, a fresh array.

        Raises:
            InvalidValue: for another shape.
        """
        batch = np.ascontiguousarray(obs, dtype=np.float32)
        if batch.ndim != 2 or batch.shape[1] != OBSERVATION.size or not len(batch):
            raise InvalidValue("The shape of the observations", batch.shape, f"(n, {OBSERVATION.size}), n >= 1")
        return np.asarray(self._session.run([OUTPUT], {INPUT: batch})[0])

    def targets(self, actions: ArrayLike) -> NDArray[np.float64]:
        """Joint targets, default_joint_pos + action_scale * action.

        Args:
            actions: (..., 12).

        Returns:
            (..., 12) rad.

        Raises:
            InvalidValue: for another shape.
        """
        array = np.asarray(actions, dtype=np.float64)
        if array.ndim == 0 or array.shape[-1] != len(JOINTS):
            raise InvalidValue("The shape of the actions", array.shape, f"(..., {len(JOINTS)})")
        return self._default_joint_pos + self.metadata.action_scale * array

    def _try_out(self, path: Path) -> None:
        for n in (1, 2):
            try:
                actions = self.act(np.zeros((n, OBSERVATION.size)))
            except Exception as error:  # onnxruntime's errors have no base class of their own
                raise FileProblem(path, f"does not run ({_sentence(error)}).") from error
            if actions.shape != (n, len(JOINTS)):
                raise FileProblem(path, f"turns {n} observations into actions of shape {actions.shape}.")
            if not np.isfinite(actions).all():
                raise FileProblem(path, "gives actions that are not finite; its weights are damaged.")


def _open_session(path: Path) -> onnxruntime.InferenceSession:
    try:
        with path.open("rb") as stream:
            content = stream.read(_LARGEST + 1)
    except OSError as error:
        raise FileProblem(path, f"cannot be read: {error.strerror or error}.") from error
    if not content:
        raise FileProblem(path, "is empty.")
    if len(content) > _LARGEST:
        raise FileProblem(path, f"is larger than {_LARGEST // 2**20} MiB, which is no policy.")
    if _EXTERNAL_MARK in content:
        raise FileProblem(path, "keeps weights in another file (external data), but a policy must be one file.")
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = 4  # what goes wrong is raised; it need not be printed as well
    # should external data hide from the check above, it is looked for where there is none
    options.add_session_config_entry("session.model_external_initializers_file_folder_path", os.devnull)
    try:
        return onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"])
    except Exception as error:  # onnxruntime's errors have no base class of their own
        raise FileProblem(path, f"is no ONNX file that can be run ({_sentence(error)}).") from error


def _sentence(error: Exception) -> str:
    """The first line of onnxruntime's text without its codes and the full stop."""
    text = re.sub(r"^\[ONNXRuntimeError\] : \d+ : \w+ : ", "", str(error)).strip()
    line = text.splitlines()[0] if text else type(error).__name__
    return line[:200].rstrip(". ")


def _check_tensor(path: Path, role: str, tensors: Any, name: str, size: int) -> None:
    """Check that there is one tensor (N, size) of float32 of that name, N free."""
    found = [(t.name, t.type, list(t.shape)) for t in tensors]
    match found:
        case [(its_name, "tensor(float)", [rows, columns])] if (its_name, columns) == (name, size):
            if not isinstance(rows, int):
                return
    text = ", ".join(f"{n} {kind} {shape}" for n, kind, shape in found)
    raise FileProblem(path, f"has the {role} {text}, but must have one, {name} tensor(float) ['N', {size}].")


def _layout_text(layout: Any) -> str:
    return ", ".join(f"{term['name']} ({term['size']}, x{term['scale']:g})" for term in layout) or "nothing"


def _finite(text: str) -> float:
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"{text} is not finite")
    return number


def _read_observation(fields: _Fields) -> tuple[dict[str, Any], ...]:
    terms = fields["observation"]
    if not isinstance(terms, list):
        raise fields.wrong("observation", terms, "a list of terms")
    found = []
    for number, value in enumerate(terms):
        term = _Fields(value, fields.origin, f"observation[{number}].")
        found.append({"name": term.text("name"), "size": term.whole("size"), "scale": term.number("scale")})
    return tuple(found)


def _read_gaits(fields: _Fields) -> dict[str, Gait]:
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
            raise FileProblem(fields.origin, f"holds an absurd gait. {error}") from error
    return found


class _Fields:
    """The keys of a JSON object, each checked as it is taken.

    Args:
        data: the object.
        origin: the file, for errors.
        prefix: where in the file the object stands, for errors.

    Raises:
        FileProblem: from every method, for a key that is missing or not what it should be.
    """

    def __init__(self, data: Any, origin: object, prefix: str = "") -> None:
        self.origin = origin
        self._prefix = prefix
        if not isinstance(data, dict):
            name = prefix.rstrip(".") or "top level"
            raise FileProblem(origin, f"has metadata whose {name} is {reprlib.repr(data)}, but must be an object.")
        self.data: dict[str, Any] = data

    def __getitem__(self, key: str) -> Any:
        if key not in self.data:
            raise FileProblem(self.origin, f"has metadata without {self._prefix}{key}.")
        return self.data[key]

    def wrong(self, key: str, value: object, allowed: str) -> FileProblem:
        """The error for a value that is not as it must be."""
        where = f"{self._prefix}{key}"
        return FileProblem(self.origin, f"has metadata whose {where} is {reprlib.repr(value)}, but must be {allowed}.")

    def nested(self, key: str) -> _Fields:
        return _Fields(self[key], self.origin, f"{self._prefix}{key}.")

    def text(self, key: str) -> str:
        value = self[key]
        if not isinstance(value, str):
            raise self.wrong(key, value, "text")
        return value

    def flag(self, key: str) -> bool:
        value = self[key]
        if not isinstance(value, bool):
            raise self.wrong(key, value, "true or false")
        return value

    def whole(self, key: str) -> int:
        value = self[key]
        if type(value) is not int or value < 0:
            raise self.wrong(key, value, "a whole number >= 0")
        return value

    def number(self, key: str, positive: bool = False) -> float:
        value = self[key]
        if not _is_number(value) or (positive and not value > 0):
            raise self.wrong(key, value, "a finite number > 0" if positive else "a finite number")
        return float(value)

    def numbers(self, key: str, length: int) -> tuple[float, ...]:
        value = self[key]
        if not isinstance(value, list) or len(value) != length or not all(map(_is_number, value)):
            raise self.wrong(key, value, f"a list of {length} finite numbers")
        return tuple(map(float, value))

    def texts(self, key: str, length: int) -> tuple[str, ...]:
        value = self[key]
        if not isinstance(value, list) or len(value) != length or not all(isinstance(v, str) for v in value):
            raise self.wrong(key, value, f"a list of {length} names")
        return tuple(value)

    def bounds(self, key: str) -> tuple[float, float]:
        low, high = self.numbers(key, 2)
        if low > high:
            raise self.wrong(key, [low, high], "two numbers, the smaller first")
        return low, high


def _is_number(value: object) -> bool:
    """Whether a JSON value is a number that fits a float; NaN and infinity were refused by the parser."""
    return (isinstance(value, float) or type(value) is int) and abs(value) <= sys.float_info.max
