"""Policy files made on the spot: a robot that stands and sways to its clock."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

from symdyn.gait.library import LIBRARY
from symdyn.gait.timing import GRAVITY, TimingCurve
from symdyn.policy.file import METADATA_KEY
from symdyn.policy.metadata import PolicyMetadata
from symdyn.policy.observation import LAYOUTS
from symdyn.robot.legs import JOINTS
from tests.robots import GO2


def swaying(path: Path, amount: float = 0.03, seed: int = 0) -> Path:
    """Write a linear policy with small random weights.

    Args:
        path: of the file.
        amount: standard deviation of the weights; 0 stands still, 1 falls.
        seed: of the weights.
    """
    metadata = PolicyMetadata(
        robot=GO2.name,
        joint_names=GO2.joint_names,
        default_joint_pos=tuple(GO2.default_joint_pos.tolist()),
        action_scale=GO2.action_scale,
        kp=GO2.kp,
        kd=GO2.kd,
        control_dt=GO2.control_dt,
        leg_length=GO2.leg_length,
        gravity=GRAVITY,
        observation=LAYOUTS["paper"],
        gaits=dict(LIBRARY),
        timing=TimingCurve(),
        command_range={"velocity_x": (-2.0, 2.0), "velocity_y": (0.0, 0.0), "yaw_rate": (0.0, 0.0)},
        time_reversal=True,
        training={"commit": "unknown", "config": {}, "samples": 0, "seed": seed},
    )
    shape = (LAYOUTS["paper"].size, len(JOINTS))
    weight = amount * np.random.default_rng(seed).normal(size=shape)
    graph = helper.make_graph(
        [helper.make_node("MatMul", ["obs", "weight"], ["actions"])],
        "policy",
        [helper.make_tensor_value_info("obs", TensorProto.FLOAT, ["N", shape[0]])],
        [helper.make_tensor_value_info("actions", TensorProto.FLOAT, ["N", shape[1]])],
        [numpy_helper.from_array(weight.astype(np.float32), "weight")],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=10)
    helper.set_model_props(model, {METADATA_KEY: metadata.to_json()})
    onnx.save(model, path)
    return path
