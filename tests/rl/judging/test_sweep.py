"""The timing sweep, on the real simulator: what it commands, what it writes, and that it goes on where it stopped."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rl.judging.sweep
from rl.judging.sweep import CSV_TABLE, JSON_TABLE, sweep
from rl.judging.sweep_config import SweepConfig
from symdyn.analysis import trials
from symdyn.errors import FileProblem, InvalidValue, SymdynError
from symdyn.gait.timing import TimingCurve
from symdyn.policy.file import Policy
from symdyn.policy.observation import LAYOUTS
from tests.symdyn.policy.policy_files import swaying

SMALL = SweepConfig(
    period_factors=(0.8, 1.2),
    duty_factors=(0.9, 1.0),
    speeds=(-0.5, 0.5),
    gaits=("trot", "bound"),
    seeds=(0, 1),
    seconds=2.2,
)


@pytest.fixture(scope="module")
def policy_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return swaying(tmp_path_factory.mktemp("policy") / "swaying.onnx")


@pytest.fixture(scope="module")
def finished(policy_file: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a sweep that ran through."""
    out = tmp_path_factory.mktemp("sweep")
    assert sweep(Policy.load(policy_file), policy_file, SMALL, out) == out / CSV_TABLE
    return out


def test_a_row_a_trial_with_the_timing_that_was_commanded(finished: Path) -> None:
    rows = trials.read(finished / CSV_TABLE)
    assert len(rows) == SMALL.trials == 2 * 2 * 2 * 2 * 2
    assert {(row.gait, row.v, row.seed) for row in rows} == {
        (gait, v, seed) for gait in SMALL.gaits for v in SMALL.speeds for seed in SMALL.seeds
    }
    curve, v = TimingCurve(), np.array([0.5])
    T, beta = float(curve.period(v, 0.4)[0]), float(curve.duty(v, 0.4)[0])
    assert sorted({row.T for row in rows}) == pytest.approx([0.8 * T, 1.2 * T])
    assert sorted({row.beta for row in rows}) == pytest.approx([0.9 * beta, beta])
    assert {row.leg_length for row in rows} == {0.4}
    for row in rows:
        assert not row.fell
        assert row.samples == round(SMALL.seconds / 0.005)
        assert row.tracking_error is not None and row.tracking_error > 0.0
        assert row.weight == (row.gait_identity or 0.0)


def test_the_clock_really_runs_at_the_varied_period(finished: Path) -> None:
    # a robot that sways to its clock spends otherwise when the clock runs otherwise
    costs = {row.T: row.cost_of_transport for row in trials.read(finished / CSV_TABLE)}
    assert len(set(costs.values())) == len(costs) > 1


def test_a_policy_under_other_curves_acts_alike(policy_file: Path) -> None:
    policy, curve = Policy.load(policy_file), TimingCurve(a_T=2.0, source="another")
    other = policy.with_timing(curve)
    assert (other.timing, policy.timing) == (curve, TimingCurve())
    obs = np.random.default_rng(0).normal(size=(3, LAYOUTS["paper"].size))
    np.testing.assert_array_equal(other.act(obs), policy.act(obs))


def test_both_tables_hold_the_same_and_the_json_says_how(finished: Path, policy_file: Path) -> None:
    assert trials.read(finished / CSV_TABLE) == trials.read(finished / JSON_TABLE)
    document = json.loads((finished / JSON_TABLE).read_text())
    assert document["settings"]["policy"] == str(policy_file)
    assert document["settings"]["sweep"]["period_factors"] == [0.8, 1.2]
    assert set(document["rows"][0]) <= set(document["columns"])
    assert sorted(path.name for path in finished.iterdir()) == [CSV_TABLE, JSON_TABLE]


def test_interrupted_it_goes_on_and_ends_with_the_same_table(
    finished: Path, policy_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    policy, real, cells = Policy.load(policy_file), rl.judging.sweep.run, []

    def run_twice(*arguments: Any) -> Any:
        if len(cells) == 2:
            raise KeyboardInterrupt
        cells.append(arguments)
        return real(*arguments)

    monkeypatch.setattr(rl.judging.sweep, "run", run_twice)
    with pytest.raises(KeyboardInterrupt):
        sweep(policy, policy_file, SMALL, tmp_path)
    assert len(trials.read(tmp_path / CSV_TABLE)) == SMALL.trials // 2
    monkeypatch.setattr(rl.judging.sweep, "run", lambda *arguments: cells.append(arguments) or real(*arguments))
    seen: list[int] = []
    sweep(policy, policy_file, SMALL, tmp_path, lambda done, total: seen.append(done))
    assert len(cells) == len(SMALL.cells), "no cell was run twice"
    assert seen[-1] == SMALL.trials
    for name in (CSV_TABLE, JSON_TABLE):
        assert (tmp_path / name).read_text() == (finished / name).read_text()


def test_a_finished_sweep_is_not_run_again(finished: Path, policy_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*_: Any) -> Any:
        raise AssertionError("nothing is left to run")

    monkeypatch.setattr(rl.judging.sweep, "run", never)
    sweep(Policy.load(policy_file), policy_file, SMALL, finished)


def test_a_table_of_other_settings_or_another_policy_is_not_mixed_in(
    finished: Path, policy_file: Path, tmp_path: Path
) -> None:
    before = (finished / JSON_TABLE).read_bytes()
    policy = Policy.load(policy_file)
    with pytest.raises(FileProblem, match="a different sweep; choose another --out"):
        sweep(policy, policy_file, replace(SMALL, seconds=2.5), finished)
    other = swaying(tmp_path / "other.onnx", seed=1)
    with pytest.raises(FileProblem, match="a different policy_sha256"):
        sweep(Policy.load(other), other, SMALL, finished)
    assert (finished / JSON_TABLE).read_bytes() == before


@pytest.mark.parametrize("content", ["", "{", "[]", "{}", '{"settings": {}, "rows": 3}'])
def test_a_table_that_is_damaged(policy_file: Path, tmp_path: Path, content: str) -> None:
    (tmp_path / JSON_TABLE).write_text(content)
    with pytest.raises(FileProblem, match=JSON_TABLE):
        sweep(Policy.load(policy_file), policy_file, SMALL, tmp_path)


def test_a_fall_has_no_cost_and_no_weight(tmp_path: Path) -> None:
    path = swaying(tmp_path / "falling.onnx", amount=1.0)
    config = replace(SMALL, period_factors=(1.0,), duty_factors=(1.0,), speeds=(0.5,), gaits=("trot",), seconds=4.0)
    for row in trials.read(sweep(Policy.load(path), path, config, tmp_path / "out")):
        assert row.fell
        assert (row.cost_of_transport, row.tracking_error, row.weight) == (None, None, 0.0)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"period_factors": ()}, "period_factors"),
        ({"period_factors": (1.0, 1.0)}, "without duplicates"),
        ({"duty_factors": (0.0,)}, "duty_factors"),
        ({"duty_factors": (math.nan,)}, "duty_factors"),
        ({"speeds": (0.0, 1.0)}, "other than 0"),
        ({"speeds": (math.inf,)}, "speeds"),
        ({"gaits": ("waltz",)}, "Unknown gait 'waltz'"),
        ({"seeds": (-1,)}, "seeds"),
        ({"seconds": 1.0}, "seconds"),
        ({"seconds": math.nan}, "seconds"),
    ],
)
def test_bad_settings(change: dict[str, Any], said: str) -> None:
    with pytest.raises(SymdynError, match=said):
        replace(SMALL, **change)


def test_a_factor_that_makes_the_curve_absurd_is_refused_before_anything_is_written(
    policy_file: Path, tmp_path: Path
) -> None:
    with pytest.raises(InvalidValue, match="a_beta"):
        sweep(Policy.load(policy_file), policy_file, replace(SMALL, duty_factors=(1.0, 3.0)), tmp_path)
    assert list(tmp_path.iterdir()) == []
