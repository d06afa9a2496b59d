"""The experiment in the second model, in small."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from rl.experiments import second_model
from rl.experiments.result import Subject
from rl.pretrained import policy_path
from symdyn.policy.file import Policy
from tests.symdyn.policy.policy_files import swaying


def test_its_targets_are_the_extremes_of_its_table() -> None:
    subject = Subject(policy=Policy.load(policy_path()), path=policy_path(), seeds=(7,))
    found = second_model.run(subject, speeds=(0.5,), straight_s=6.0, sequences=2)
    identity = [gait["0.5"]["gait_identity"] for gait in found.metrics["constant"].values()]
    by_what = {target.what: target.here for target in found.targets}
    assert by_what["strides in the commanded gait, worst gait and speed"] == min(identity)
    assert by_what["heading after 6 s straight, worst gait, degrees"] == max(found.metrics["heading_deg"].values())
    assert len(identity) == len(subject.policy.gaits)


def test_a_robot_that_falls_is_counted_and_has_no_heading(tmp_path: Path) -> None:
    path = swaying(tmp_path / "policy.onnx", amount=1.0)
    subject = Subject(policy=Policy.load(path), path=path, seeds=(7,))
    found = second_model.run(subject, speeds=(0.5,), straight_s=6.0, sequences=2)
    gaits = len(subject.policy.gaits)
    assert found.metrics["fell"] == {"constant": gaits, "straight": gaits, "random": 2}
    by_what = {target.what: target.here for target in found.targets}
    assert by_what["falls in all runs"] == 2 * gaits + 2
    assert by_what["heading after 6 s straight, worst gait, degrees"] == pytest.approx(math.inf)
