"""The policy file: what a good one gives, and that every bad one is refused in a sentence."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper, numpy_helper

import symdyn.policy.file
from symdyn.errors import FileProblem, InvalidValue, PolicyMismatch, SymdynError
from symdyn.gait.library import LIBRARY
from symdyn.gait.timing import GRAVITY, TimingCurve
from symdyn.policy.file import METADATA_KEY, Policy
from symdyn.policy.metadata import PolicyMetadata
from symdyn.policy.observation import LAYOUTS
from symdyn.robot.legs import JOINTS
from tests.robots import GO2

RNG = np.random.default_rng(0)
WEIGHT = RNG.normal(size=(LAYOUTS["paper"].size, len(JOINTS))).astype(np.float32)
BIAS = RNG.normal(size=len(JOINTS)).astype(np.float32)

METADATA = PolicyMetadata(
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
    gaits={name: LIBRARY[name] for name in ("trot", "half_bound_left")},
    timing=TimingCurve(a_T=1.0 / 3.0, source="a test"),
    command_range={"velocity_x": (-2.0, 0.1 + 0.2), "velocity_y": (0.0, 0.0), "yaw_rate": (-1.0, 1.0)},
    time_reversal=False,
    training={"commit": "unknown", "config": {"seed": 7, "env": {"episode_s": 20.0}}, "samples": 12, "seed": 7},
)


def network(
    inputs: tuple[str, int, Any, int] = ("obs", TensorProto.FLOAT, "N", LAYOUTS["paper"].size),
    outputs: tuple[str, int, Any, int] = ("actions", TensorProto.FLOAT, "N", len(JOINTS)),
    weight: np.ndarray = WEIGHT,
) -> onnx.ModelProto:
    """A linear policy with these tensors: (name, type, rows, columns)."""
    kind = helper.tensor_dtype_to_np_dtype(inputs[1])
    nodes = [
        helper.make_node("MatMul", [inputs[0], "weight"], ["product"]),
        helper.make_node("Add", ["product", "bias"], [outputs[0]]),
    ]
    value = [helper.make_tensor_value_info(name, t, [rows, n]) for name, t, rows, n in (inputs, outputs)]
    tensors = [
        numpy_helper.from_array(weight.astype(kind), "weight"),
        numpy_helper.from_array(BIAS.astype(kind), "bias"),
    ]
    graph = helper.make_graph(nodes, "policy", value[:1], value[1:], tensors)
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=10)


def write(path: Path, model: onnx.ModelProto | None = None, metadata: str | None = None) -> Path:
    """A policy file; without arguments a good one."""
    model = network() if model is None else model
    helper.set_model_props(model, {METADATA_KEY: METADATA.to_json() if metadata is None else metadata})
    onnx.save(model, path)
    return path


def edited(edit: Callable[[dict[str, Any]], object]) -> str:
    """The good metadata with something changed in place."""
    data = json.loads(METADATA.to_json())
    edit(data)
    return json.dumps(data)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "policy.onnx"


def assert_refused(path: Path, kind: type[SymdynError], *words: str) -> None:
    """One sentence or two that name the file and the problem, and none of onnxruntime's codes."""
    with pytest.raises(kind) as caught:
        Policy.load(path)
    text = str(caught.value)
    assert type(caught.value) is kind
    assert text.startswith(f"{path}: ")
    assert text.endswith(".")
    assert "\n" not in text
    assert "ONNXRuntimeError" not in text
    for word in words:
        assert word in text


class TestGood:
    def test_acts_as_the_network_does(self, path: Path) -> None:
        policy = Policy.load(write(path))
        obs = RNG.normal(size=(7, LAYOUTS["paper"].size))
        actions = policy.act(obs)
        assert actions.shape == (7, 12)
        assert actions.dtype == np.float32
        np.testing.assert_allclose(actions, obs @ WEIGHT + BIAS, rtol=1e-5, atol=1e-5)

    def test_rows_do_not_depend_on_the_batch(self, path: Path) -> None:
        policy = Policy.load(write(path))
        obs = RNG.normal(size=(7, LAYOUTS["paper"].size)).astype(np.float32)
        together = policy.act(obs)
        for row, wanted in zip(obs, together, strict=True):
            np.testing.assert_allclose(policy.act(row[None])[0], wanted, rtol=1e-5, atol=1e-5)

    def test_actions_are_fresh_and_repeatable(self, path: Path) -> None:
        policy = Policy.load(write(path))
        first = policy.act(np.ones((2, LAYOUTS["paper"].size)))
        kept = first.copy()
        first += 1.0
        np.testing.assert_array_equal(policy.act(np.ones((2, LAYOUTS["paper"].size))), kept)

    def test_a_strided_view_is_as_good_as_a_copy(self, path: Path) -> None:
        policy = Policy.load(write(path))
        wide = RNG.normal(size=(LAYOUTS["paper"].size, 6)).astype(np.float32)
        np.testing.assert_array_equal(policy.act(wide.T[::2]), policy.act(wide.T[::2].copy()))

    def test_targets(self, path: Path) -> None:
        policy = Policy.load(write(path))
        np.testing.assert_array_equal(policy.targets(np.zeros(12)), GO2.default_joint_pos)
        actions = RNG.normal(size=(3, 12)).astype(np.float32)
        wanted = GO2.default_joint_pos + GO2.action_scale * actions.astype(np.float64)
        np.testing.assert_allclose(policy.targets(actions), wanted, rtol=1e-15)

    def test_metadata_is_exact(self, path: Path) -> None:
        policy = Policy.load(write(path))
        assert policy.metadata == METADATA
        assert policy.timing == METADATA.timing
        assert dict(policy.gaits) == dict(METADATA.gaits)
        assert list(policy.gaits) == ["trot", "half_bound_left"]

    @pytest.mark.parametrize("shape", [(52,), (1, 51), (2, 53), (0, 52), (1, 1, 52)])
    def test_observations_of_another_shape(self, path: Path, shape: tuple[int, ...]) -> None:
        with pytest.raises(InvalidValue, match=r"\(n, 52\)"):
            Policy.load(write(path)).act(np.zeros(shape))

    @pytest.mark.parametrize("shape", [(), (1,), (3, 1), (2, 13)])
    def test_actions_of_another_shape(self, path: Path, shape: tuple[int, ...]) -> None:
        with pytest.raises(InvalidValue, match=r"\(..., 12\)"):
            Policy.load(write(path)).targets(np.zeros(shape))

    def test_a_not_finite_observation_does_not_pass_as_an_action(self, path: Path) -> None:
        obs = np.zeros((1, LAYOUTS["paper"].size))
        obs[0, 5] = math.nan
        assert np.isnan(Policy.load(write(path)).act(obs)).all()

    def test_nothing_heavy_is_imported(self, path: Path) -> None:
        code = (
            "import sys; from pathlib import Path; from symdyn.policy.file import Policy; import numpy as np;"
            f"Policy.load(Path({str(write(path))!r})).act(np.zeros((1, {LAYOUTS['paper'].size})));"
            "print(sorted({'torch', 'mujoco', 'onnx', 'casadi', 'pinocchio', 'rl', 'tensordict'} & set(sys.modules)))"
        )
        found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        assert found.stdout.strip() == "[]"


class TestBadFile:
    def test_missing(self, path: Path) -> None:
        assert_refused(path, FileProblem, "cannot be read", "No such file")

    def test_directory(self, tmp_path: Path) -> None:
        assert_refused(tmp_path, FileProblem, "cannot be read", "directory")

    def test_empty(self, path: Path) -> None:
        path.touch()
        assert_refused(path, FileProblem, "is empty")

    @pytest.mark.parametrize("content", [b"hello\n", b"format_version: 1\n" * 40, b"PK\x03\x04" + bytes(99), bytes(64)])
    def test_something_else(self, path: Path, content: bytes) -> None:
        path.write_bytes(content)
        assert_refused(path, FileProblem, "cannot be loaded as an ONNX model")

    @pytest.mark.parametrize("part", [0.01, 0.5, 0.99])
    def test_truncated(self, path: Path, part: float) -> None:
        content = write(path).read_bytes()
        path.write_bytes(content[: int(part * len(content))])
        assert_refused(path, FileProblem)

    def test_larger_than_any_policy(self, path: Path) -> None:
        with path.open("wb") as stream:
            stream.truncate(2**30)  # sparse
        assert_refused(path, FileProblem, "larger than 256 MiB")

    @pytest.mark.parametrize("beside", [True, False])
    def test_external_data(self, path: Path, beside: bool, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.chdir(path.parent)  # where onnxruntime would look for it
        model = network()
        helper.set_model_props(model, {METADATA_KEY: METADATA.to_json()})
        onnx.save_model(model, path.name, save_as_external_data=True, location="policy.onnx.data", size_threshold=0)
        data = path.with_name("policy.onnx.data")
        assert data.stat().st_size > 0
        if not beside:
            data.unlink()
        assert_refused(path, FileProblem, "another file", "must be one file")
        monkeypatch.setattr(symdyn.policy.file, "_EXTERNAL_MARK", b"the check that recognises it is passed by")
        assert_refused(path, FileProblem, "External data path")

    def test_a_file_of_a_newer_format_is_refused_with_the_reason(self, path: Path) -> None:
        model = network()
        helper.set_model_props(model, {METADATA_KEY: METADATA.to_json()})
        model.ir_version = 99
        path.write_bytes(model.SerializeToString())
        with pytest.raises(FileProblem) as raised:
            Policy.load(path)
        assert "(Unsupported model IR version: 99, max supported IR version" in str(raised.value)
        model.ir_version, model.opset_import[0].version = 8, 99
        path.write_bytes(model.SerializeToString())
        assert_refused(path, FileProblem, "Opset 99", "Current official support for domain ai.onnx is till opset")

    def test_no_metadata(self, path: Path) -> None:
        onnx.save(network(), path)
        assert_refused(path, FileProblem, "not a symdyn policy", METADATA_KEY)

    @pytest.mark.parametrize(
        ("inputs", "outputs"),
        [
            (("obs", TensorProto.FLOAT, 1, 52), ("actions", TensorProto.FLOAT, 1, 12)),
            (("observation", TensorProto.FLOAT, "N", 52), ("actions", TensorProto.FLOAT, "N", 12)),
            (("obs", TensorProto.FLOAT, "N", 52), ("action", TensorProto.FLOAT, "N", 12)),
            (("obs", TensorProto.DOUBLE, "N", 52), ("actions", TensorProto.DOUBLE, "N", 12)),
        ],
    )
    def test_other_tensors(self, path: Path, inputs: tuple[Any, ...], outputs: tuple[Any, ...]) -> None:
        write(path, network(inputs, outputs))
        assert_refused(path, FileProblem, "put ", "must have one")

    def test_observation_of_another_size(self, path: Path) -> None:
        write(path, network(("obs", TensorProto.FLOAT, "N", 48), weight=WEIGHT[:48]))
        assert_refused(path, FileProblem, "input", "48", "52")

    def test_two_inputs(self, path: Path) -> None:
        model = network()
        model.graph.input.append(helper.make_tensor_value_info("state", TensorProto.FLOAT, ["N", 3]))
        write(path, model)
        assert_refused(path, FileProblem, "state", "must have one")

    @pytest.mark.parametrize("bad", [math.nan, math.inf])
    def test_weights_that_are_not_finite(self, path: Path, bad: float) -> None:
        weight = WEIGHT.copy()
        weight[3, 4] = bad
        write(path, network(weight=weight))
        assert_refused(path, FileProblem, "not finite", "weights")


class TestMismatch:
    def test_format_version(self, path: Path) -> None:
        for version in (0, 2, "1", 1.0, True, None):
            write(path, metadata=edited(lambda d, v=version: d.update(format_version=v)))
            assert_refused(path, PolicyMismatch, f"format_version {version!r}", "only 1")

    def test_another_robot(self, path: Path) -> None:
        write(path, metadata=edited(lambda d: d.update(robot="a1")))
        assert_refused(path, PolicyMismatch, "'a1'", "'go2'")

    def test_loaded_for_another_robot(self, path: Path) -> None:
        with pytest.raises(PolicyMismatch, match="'go2', not for 'spot'"):
            Policy.load(write(path), replace(GO2, name="spot"))

    def test_permuted_joints(self, path: Path) -> None:
        names = list(GO2.joint_names)
        names[4], names[7] = names[7], names[4]
        write(path, metadata=edited(lambda d: d.update(joint_names=names)))
        assert_refused(path, PolicyMismatch, "joint 4", "'FR_thigh_joint'", "'FL_thigh_joint'")

    @pytest.mark.parametrize("change", ["order", "scale", "shorter", "extended"])
    def test_another_layout_of_known_terms_is_the_files_own(self, path: Path, change: str) -> None:
        def edit(data: dict[str, Any]) -> None:
            terms = data["observation"]
            match change:
                case "order":
                    terms[1], terms[2] = terms[2], terms[1]
                case "scale":
                    terms[2]["scale"] = 1.0
                case "shorter":
                    terms.pop()
                case "extended":
                    data["observation"] = LAYOUTS["extended"].as_list()

        size = {"shorter": 50, "extended": 59}.get(change, 52)
        weight = RNG.normal(size=(size, len(JOINTS))).astype(np.float32)
        graph = network(inputs=("obs", TensorProto.FLOAT, "N", size), weight=weight)
        text = edited(edit)
        policy = Policy.load(write(path, graph, metadata=text))
        assert policy.metadata.observation.as_list() == json.loads(text)["observation"]
        obs = RNG.normal(size=(3, size))
        np.testing.assert_allclose(policy.act(obs), obs.astype(np.float32) @ weight + BIAS, rtol=1e-5, atol=1e-5)

    @pytest.mark.parametrize("change", ["name", "size", "twice"])
    def test_a_layout_that_cannot_be_supplied(self, path: Path, change: str) -> None:
        def edit(data: dict[str, Any]) -> None:
            terms = data["observation"]
            match change:
                case "name":
                    terms[0]["name"] = "projected_gravity"
                case "size":
                    terms[0]["size"], terms[1]["size"] = 2, 13
                case "twice":
                    terms.append(terms[0])

        write(path, metadata=edited(edit))
        assert_refused(path, PolicyMismatch, "observes", "'projected_gravity")

    def test_a_network_of_another_size_than_its_layout(self, path: Path) -> None:
        write(path, metadata=edited(lambda d: d["observation"].pop()))
        assert_refused(path, FileProblem, "input", "50")

    def test_another_gravity(self, path: Path) -> None:
        write(path, metadata=edited(lambda d: d.update(gravity=9.8)))
        assert_refused(path, PolicyMismatch, "gravity", "9.8 ", "9.81")


TOP = sorted(json.loads(METADATA.to_json()))


class TestBadMetadata:
    @pytest.mark.parametrize("text", ["", "{", "not json", "[" * 100_000, "[]", "null", '"text"'])
    def test_no_object(self, path: Path, text: str) -> None:
        write(path, metadata=text)
        assert_refused(path, FileProblem, "metadata")

    @pytest.mark.parametrize("key", TOP)
    def test_missing_key(self, path: Path, key: str) -> None:
        write(path, metadata=edited(lambda d: d.pop(key)))
        assert_refused(path, FileProblem, key)

    @pytest.mark.parametrize("key", [key for key in TOP if key != "format_version"])
    @pytest.mark.parametrize("value", [None, -1.5, [], {}, [[]]])
    def test_wrong_type(self, path: Path, key: str, value: object) -> None:
        write(path, metadata=edited(lambda d: d.update({key: value})))
        with pytest.raises(SymdynError, match=r"policy\.onnx"):
            Policy.load(path)

    @pytest.mark.parametrize("key", ["kp", "kd", "control_dt", "action_scale", "leg_length", "gravity"])
    @pytest.mark.parametrize("value", [0, -1, "30", True, None, 10**400])
    def test_numbers_that_must_be_positive(self, path: Path, key: str, value: object) -> None:
        write(path, metadata=edited(lambda d: d.update({key: value})))
        assert_refused(path, FileProblem, key, "a finite number > 0")

    @pytest.mark.parametrize("text", ["NaN", "Infinity", "-Infinity", "1e999"])
    def test_numbers_that_are_not_finite(self, path: Path, text: str) -> None:
        good = METADATA.to_json()
        for where in ('"kp": 30.0', '"a_T": 0.3333333333333333', '"episode_s": 20.0'):
            assert where in good
            write(path, metadata=good.replace(where, f"{where.split(':')[0]}: {text}"))
            assert_refused(path, FileProblem, "not finite")
        write(path, metadata=good.replace('"default_joint_pos": [0.0', f'"default_joint_pos": [{text}'))
        assert_refused(path, FileProblem, "not finite")

    @pytest.mark.parametrize("key", ["joint_names", "default_joint_pos"])
    def test_wrong_length(self, path: Path, key: str) -> None:
        write(path, metadata=edited(lambda d: d[key].pop()))
        assert_refused(path, FileProblem, key, "a list of 12")

    @pytest.mark.parametrize(
        ("edit", "words"),
        [
            (lambda d: d["gaits"]["trot"].pop("RF"), "gaits.trot.RF"),
            (lambda d: d["gaits"]["trot"].update(RF=1.0), "[0, 1)"),
            (lambda d: d["gaits"].clear(), "at least one gait"),
            (lambda d: d["timing"].pop("c_T"), "c_T"),
            (lambda d: d["timing"].update(a_beta=-3), "a_beta"),
            (lambda d: d["command_range"].pop("yaw_rate"), "command_range.yaw_rate"),
            (lambda d: d["command_range"].update(velocity_x=[1, -1]), "the smaller first"),
            (lambda d: d["command_range"].update(velocity_x=[1]), "a list of 2"),
            (lambda d: d.update(time_reversal=1), "true or false"),
            (lambda d: d["training"].pop("commit"), "training.commit"),
            (lambda d: d["training"].update(samples=-1), "training.samples"),
            (lambda d: d["training"].update(seed=1.5), "a whole number"),
            (lambda d: d["training"].update(config=[]), "training.config"),
            (lambda d: d["observation"][3].pop("scale"), "observation[3].scale"),
            (lambda d: d["observation"].append("duty"), "observation[8]"),
        ],
    )
    def test_inside(self, path: Path, edit: Callable[[dict[str, Any]], object], words: str) -> None:
        write(path, metadata=edited(edit))
        assert_refused(path, FileProblem, words)

    def test_not_finite_numbers_are_not_written(self) -> None:
        with pytest.raises(ValueError, match="JSON"):
            replace(METADATA, kp=math.nan).to_json()
