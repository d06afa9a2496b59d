"""The deployable policy: one ONNX file that carries everything needed to run it, run by onnxruntime alone.

The network takes ``obs`` (N, numbers of its observation) and gives ``actions`` (N, 12); beside it, under the metadata
key ``symdyn``, the file holds :class:`symdyn.policy.metadata.PolicyMetadata` as JSON. Evaluation, the viewer and the
robot load nothing else.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import onnxruntime
from numpy.typing import ArrayLike, NDArray

from symdyn.errors import FileProblem, InvalidValue, PolicyMismatch
from symdyn.gait.library import Gait
from symdyn.gait.timing import TimingCurve
from symdyn.policy.metadata import PolicyMetadata
from symdyn.policy.steering import HeadingHold
from symdyn.robot.definition import Robot
from symdyn.robot.legs import JOINTS
from symdyn.robot.robot_file import ROBOTS, get_robot

METADATA_KEY = "symdyn"
GOLDEN_KEY = "symdyn_golden"
"""Metadata key of the golden trace (symdyn.policy.golden)."""

INPUT, OUTPUT = "obs", "actions"

_LARGEST = 256 * 2**20
# ONNX marks a tensor that lies in another file by an entry of this key; these are the entry's first bytes in protobuf.
_EXTERNAL_MARK = b"\n\x08location"


class Policy:
    """A policy, ready to run on one thread. Made by :meth:`load`.

    Attributes:
        metadata: what the file says about itself.
        robot: that it runs on, with the stance, gains and rate that the file asks for.
    """

    def __init__(self, session: onnxruntime.InferenceSession, metadata: PolicyMetadata, robot: Robot) -> None:
        self._session = session
        self._default_joint_pos = np.array(metadata.default_joint_pos)
        self.metadata = metadata
        self.robot = metadata.applied_to(robot)

    def __deepcopy__(self, memo: object) -> Policy:
        return self  # nothing in it ever changes

    @classmethod
    def load(cls, path: Path | str, robot: Robot | None = None) -> Policy:
        """Read a policy file.

        Args:
            path: of the .onnx file.
            robot: that it is to run on; if None, the one that comes with symdyn under the name in the file.

        Raises:
            FileProblem: if the file is missing, no ONNX, not whole in itself, or lacks sound metadata.
            PolicyMismatch: if it was made for another robot or format, observes what this symdyn cannot supply, or its
                golden trace comes out otherwise.
        """
        path = Path(path)
        session = _open_session(path)
        text = session.get_modelmeta().custom_metadata_map.get(METADATA_KEY)
        if text is None:
            raise FileProblem(path, f"is an ONNX file, but not a symdyn policy: it lacks metadata {METADATA_KEY!r}.")
        metadata = PolicyMetadata.from_json(text, path)
        if robot is None:
            robot = _robot_named(metadata.robot, path)
        metadata.check_made_for(robot, path)
        _check_tensor(path, "input", session.get_inputs(), INPUT, metadata.observation.size)
        _check_tensor(path, "output", session.get_outputs(), OUTPUT, len(JOINTS))
        policy = cls(session, metadata, robot)
        policy._try_out(path)
        golden_trace = session.get_modelmeta().custom_metadata_map.get(GOLDEN_KEY)
        if golden_trace is not None:  # older files have none
            from symdyn.policy import golden  # which uses this module

            golden.check(policy, golden_trace, path)
        return policy

    def with_timing(self, timing: TimingCurve) -> Policy:
        """The same network under other curves."""
        return Policy(self._session, replace(self.metadata, timing=timing), self.robot)

    def with_heading_hold(self, hold: HeadingHold) -> Policy:
        """The same network with another heading hold; itself, if it is not steered."""
        steering = self.metadata.steering
        if steering is None:
            return self
        steering = replace(steering, heading_hold=hold)
        return Policy(self._session, replace(self.metadata, steering=steering), self.robot)

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
            obs: (n, size) as :func:`symdyn.policy.observation.observe` assembles them for the observation of the
                policy; n >= 1.

        Returns:
            (n, 12) float32, a fresh array.

        Raises:
            InvalidValue: for another shape.
        """
        batch = np.ascontiguousarray(obs, dtype=np.float32)
        size = self.metadata.observation.size
        if batch.ndim != 2 or batch.shape[1] != size or not len(batch):
            raise InvalidValue("The shape of the observations", batch.shape, f"(n, {size}), n >= 1")
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
                actions = self.act(np.zeros((n, self.metadata.observation.size)))
            except Exception as error:  # onnxruntime's errors have no base class of their own
                raise FileProblem(path, f"does not run ({_sentence(error)}).") from error
            if actions.shape != (n, len(JOINTS)):
                raise FileProblem(path, f"turns {n} observations into actions of shape {actions.shape}.")
            if not np.isfinite(actions).all():
                raise FileProblem(path, "gives actions that are not finite; its weights are damaged.")


def _robot_named(name: str, path: Path) -> Robot:
    if name not in ROBOTS:
        raise PolicyMismatch(
            f"{path}: was made for the robot {name!r}, which does not come with symdyn "
            f"(known: {', '.join(map(repr, ROBOTS))}). Give its robot file with --robot."
        )
    return get_robot(name)


def _open_session(path: Path) -> onnxruntime.InferenceSession:
    try:
        with path.open("rb") as stream:
            content = stream.read(_LARGEST + 1)
    except OSError as error:
        raise FileProblem(path, f"cannot be read: {error.strerror or error}.") from error
    if not content:
        raise FileProblem(path, "is empty.")
    if len(content) > _LARGEST:
        raise FileProblem(path, f"is larger than {_LARGEST // 2**20} MiB, the limit for a policy file.")
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
        raise FileProblem(path, f"cannot be loaded as an ONNX model ({_sentence(error)}).") from error


def _sentence(error: Exception) -> str:
    """The reason in onnxruntime's text: without its codes, without where in its source it arose, and without a stop."""
    text = re.sub(r"^\[ONNXRuntimeError\] : \d+ : \w+ : ", "", str(error)).strip()
    line = text.splitlines()[0] if text else type(error).__name__
    # /src/onnxruntime/model.cc:181 onnxruntime::Model::Model(ModelProto&&, const PathString&, ...) The reason
    line = re.sub(r"(?:^|(?<=: ))\S+\.(?:cc|h|cpp):\d+ .*?\)(?: const)?(?: \[with [^\]]*\])? (?=[A-Z\w])", "", line)
    return line.rstrip(". ")


def _check_tensor(path: Path, role: str, tensors: Any, name: str, size: int) -> None:
    """Check that there is one tensor (N, size) of float32 of that name, N free."""
    found = [(t.name, t.type, list(t.shape)) for t in tensors]
    match found:
        case [(its_name, "tensor(float)", [rows, columns])] if (its_name, columns) == (name, size):
            if not isinstance(rows, int):
                return
    text = ", ".join(f"{n} {kind} {shape}" for n, kind, shape in found)
    raise FileProblem(path, f"has the {role} {text}, but must have one, {name} tensor(float) ['N', {size}].")
