"""The golden trace: a port that reads only the file agrees with it, and one that is wrong is refused at load."""

from __future__ import annotations

import json
import math
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import pytest

from rl.pretrained import policy_path
from symdyn.errors import FileProblem, PolicyMismatch
from symdyn.gait import phase as clock
from symdyn.policy import golden, observation
from symdyn.policy.file import GOLDEN_KEY, METADATA_KEY, Policy


@pytest.fixture
def path(tmp_path) -> Path:
    """A copy of the policy that comes with symdyn."""
    return Path(shutil.copy(policy_path(), tmp_path / "go2.onnx"))


def properties(path: Path) -> dict[str, str]:
    return {entry.key: entry.value for entry in onnx.load(path).metadata_props}


def rewrite(path: Path, change: dict[str, str]) -> None:
    model = onnx.load(path)
    onnx.helper.set_model_props(model, properties(path) | change)
    onnx.save(model, path)


def ported(meta: dict[str, Any], step: dict[str, Any], phase: float, last_action: list[float]) -> list[float]:
    """An observation by a reader of the file's metadata who has never seen symdyn: by labels and scales alone."""
    velocity, curves, length = step["velocity"], meta["timing"], meta["leg_length"]
    star = abs(velocity[0]) / math.sqrt(meta["gravity"] * length)
    duty = min(max(curves["a_beta"] * math.exp(-curves["c_beta"] * star), 0.1), 0.9)
    own = {leg: (phase + step["offsets"][leg]) % 1.0 for leg in step["offsets"]}
    if velocity[0] < 0.0 and meta["time_reversal"]:
        own = {leg: -value % 1.0 for leg, value in own.items()}
    joints = list(range(len(meta["joint_names"])))
    values = {
        "projected_gravity_b": dict(zip("xyz", step["gravity_b"], strict=True)),
        "joint_pos_rel": [step["joint_pos"][j] - meta["default_joint_pos"][j] for j in joints],
        "joint_vel": step["joint_vel"],
        "last_action": last_action,
        "velocity_command": dict(zip(("v_x", "v_y", "yaw_rate"), velocity, strict=True)),
        "clock_sin": {leg: math.sin(2.0 * math.pi * value) for leg, value in own.items()},
        "phase_offset": step["offsets"],
        "duty_ratio": {"beta": duty, "1-beta": 1.0 - duty},
    }
    found: list[float] = []
    for term in meta["observation"]:
        value = values[term["name"]]
        ordered = [value[label] for label in term["labels"]] if isinstance(value, dict) else value
        found += [term["scale"] * number for number in ordered]
    return found


def test_a_port_made_from_the_files_metadata_alone_observes_the_golden_observations(path):
    meta, trace = (json.loads(properties(path)[key]) for key in (METADATA_KEY, GOLDEN_KEY))
    phase, action = trace["initial_phase"], [0.0] * 12
    for step in trace["steps"]:
        assert ported(meta, step, phase, action) == pytest.approx(step["observation"], abs=1e-6)
        star = abs(step["velocity"][0]) / math.sqrt(meta["gravity"] * meta["leg_length"])
        curves = meta["timing"]
        period = curves["a_T"] * math.exp(-curves["c_T"] * star) * math.sqrt(meta["leg_length"] / meta["gravity"])
        phase, action = (phase + meta["control_dt"] / max(period, 0.1)) % 1.0, step["action"]
        targets = np.array(meta["default_joint_pos"]) + meta["action_scale"] * np.array(step["action"])
        assert targets == pytest.approx(step["targets"], abs=1e-6)


def test_every_number_has_a_label_a_unit_and_a_frame(path):
    for term in json.loads(properties(path)[METADATA_KEY])["observation"]:
        assert len(term["labels"]) == term["size"]
        assert term["unit"]
        assert term["frame"] in ("body", "heading", "none")


@pytest.mark.parametrize(
    ("term", "wrong"),
    [
        ("phase_offset", lambda s: s.offsets),  # in the order of the clock, which lost a third of the accuracy
        ("clock_sin", lambda s: np.cos(2.0 * np.pi * s.leg_phases)),
        ("projected_gravity_b", lambda s: -s.sensed.gravity_b),
        ("joint_pos_rel", lambda s: s.sensed.joint_pos),
        ("last_action", lambda s: 0.0 * s.last_action),
    ],
)
def test_a_wrong_port_is_refused_and_the_number_named(path, monkeypatch, term, wrong):
    Policy.load(path)
    monkeypatch.setattr(observation, "VALUES", {**observation.VALUES, term: wrong})
    with pytest.raises(PolicyMismatch, match=rf"golden trace, observation number \d+ \({term} "):
        Policy.load(path)


def test_a_clock_that_turns_the_other_way_is_refused(path, monkeypatch):
    monkeypatch.setattr(clock, "advance", lambda phase, period, dt: (phase - dt / period) % 1.0)
    with pytest.raises(PolicyMismatch, match="clock_sin"):
        Policy.load(path)


def test_labels_in_another_order_are_refused(path):
    meta = json.loads(properties(path)[METADATA_KEY])
    (term,) = [term for term in meta["observation"] if term["name"] == "phase_offset"]
    term["labels"].reverse()
    rewrite(path, {METADATA_KEY: json.dumps(meta)})
    with pytest.raises(
        PolicyMismatch, match="observes 'phase_offset' in the order RH LH RF LF, but this version of symdyn supplies"
    ):
        Policy.load(path)


@pytest.mark.parametrize(
    "text", ["{", "[]", '{"initial_phase": 0.1, "steps": [{}]}', '{"initial_phase": 0.1, "steps": []}']
)
def test_a_trace_that_is_none_is_a_damaged_file(path, text):
    rewrite(path, {GOLDEN_KEY: text})
    with pytest.raises(FileProblem, match="golden trace"):
        Policy.load(path)


def test_an_older_file_without_a_trace_still_loads(path):
    model = onnx.load(path)
    onnx.helper.set_model_props(model, {METADATA_KEY: properties(path)[METADATA_KEY]})
    onnx.save(model, path)
    Policy.load(path)


def test_the_trace_goes_forwards_and_backwards_in_several_gaits(path):
    trace = json.loads(golden.record(Policy.load(path)))
    velocities = [step["velocity"][0] for step in trace["steps"]]
    assert min(velocities) < 0.0 < max(velocities)
    assert len({json.dumps(step["offsets"]) for step in trace["steps"]}) > 3


def test_the_model_card_has_the_range_of_commands_of_the_file():
    low, high = Policy.load(policy_path()).metadata.command_range["velocity_x"]
    card = policy_path().with_name("README.md").read_text(encoding="utf-8")
    assert re.search(rf"commands from {low:g} to {high:g} m/s", " ".join(card.split()))
