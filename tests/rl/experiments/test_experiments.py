"""Experiments in small: they measure what they say, and their files hold what was measured."""

from __future__ import annotations

import json
import math
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rl.experiments import (
    ablation,
    catalogue,
    cot,
    gaits,
    learning,
    mixtures,
    report,
    reversal,
    robustness,
    terrain,
    transitions,
    velocity,
)
from rl.experiments.result import Result, Subject
from rl.judging import protocols, summaries
from rl.judging.target import Target
from rl.pretrained import policy_path
from symdyn.errors import FileProblem, InvalidValue, UnknownName
from symdyn.figures.plots import velocity_tracking
from symdyn.gait.library import PAPER_GAITS, get
from symdyn.policy.file import Policy
from tests.symdyn.analysis.synthetic import recording
from tests.symdyn.policy.policy_files import swaying


@pytest.fixture(scope="module")
def subject() -> Subject:
    """The shipped policy, one seed."""
    return Subject(policy=Policy.load(policy_path()), path=policy_path(), seeds=(7,))


@pytest.fixture(scope="module")
def faller(tmp_path_factory) -> Subject:
    """A policy that tips over at once."""
    path = swaying(tmp_path_factory.mktemp("faller") / "policy.onnx", amount=1.0)
    return Subject(policy=Policy.load(path), path=path, seeds=(7,))


@pytest.mark.parametrize(
    ("here", "goal", "at_least", "met"),
    [
        (0.1, 0.1, False, True),
        (0.11, 0.1, False, False),
        (0.95, 0.95, True, True),
        (0.9, 0.95, True, False),
        (math.inf, 1.0, False, False),
        (math.nan, 1.0, False, False),
        (math.nan, 0.0, True, False),
    ],
)
def test_a_goal_is_met_at_its_limit_and_never_by_a_number_that_does_not_exist(here, goal, at_least, met):
    assert Target("x", here, goal, at_least).met is met


def test_all_is_everything_that_needs_no_training_run_in_the_order_of_the_catalogue():
    assert catalogue.chosen(("all",)) == tuple(name for name in catalogue.EXPERIMENTS if name != "learning")
    assert catalogue.chosen(("terrain", "gaits", "terrain")) == ("gaits", "terrain")
    assert catalogue.chosen(("all", "learning")) == tuple(catalogue.EXPERIMENTS)
    with pytest.raises(UnknownName, match="Did you mean 'terrain'"):
        catalogue.chosen(("terain",))


def test_velocity_and_gaits_agree_with_the_evaluation_of_the_same_episodes(subject):
    found = velocity.run(subject)
    episodes = subject.simulate(protocols.velocity_scripts(("trot",), subject.seeds))["trot"]
    alone = summaries.velocity_steps("trot", episodes, time_reversal=True)
    assert found.metrics["by_gait"]["trot"] == alone
    worst = max(s["speed_error"] for g in found.metrics["by_gait"].values() for s in g["by_step"].values())
    assert next(t.here for t in found.targets if "worst gait and step, m/s" in t.what) == worst


def test_gaits_has_a_number_for_every_gait_and_speed_and_its_targets_are_their_extremes(subject):
    found = gaits.run(subject, speeds=(-0.5, 0.5))
    table = found.metrics["constant"]
    identity = [table[g][v]["gait_identity"] for g in PAPER_GAITS for v in ("-0.5", "0.5")]
    by_what = {t.what: t for t in found.targets}
    assert by_what["the same, worst gait and speed"].here == min(identity)
    assert by_what["strides in the commanded gait, mean"].here == pytest.approx(np.mean(identity))
    sequence = found.metrics["sequence"]
    # the whole is made of its parts, each 2 s long
    assert sequence["gc_stance"] == pytest.approx(np.mean([g["gc_stance"] for g in sequence["by_gait"].values()]))


def test_transitions_try_every_ordered_pair_and_the_table_counts_them(subject):
    found = transitions.run(subject, speeds=(0.5,))
    pairs = {(s["from"], s["to"]) for s in found.metrics["switches"]}
    assert pairs == {(a, b) for a in PAPER_GAITS for b in PAPER_GAITS if a != b}
    in_time = [s["strides_to_switch"] <= 1.0 for s in found.metrics["switches"]]
    assert found.targets[0].here == pytest.approx(np.mean(in_time))


def test_the_cost_of_transport_is_a_mean_over_gaits_at_the_papers_speeds(subject):
    found = cot.run(subject, speeds=(0.2, 0.5))
    for target, speed in zip(found.targets[::2], ("0.2", "0.5"), strict=True):
        costs = [found.metrics["constant"][gait][speed]["cot"] for gait in PAPER_GAITS]
        assert target.here == pytest.approx(np.mean(costs))
        assert 0.1 < target.here < 10.0


def test_reversal_compares_the_same_speeds_both_ways(subject):
    found = reversal.run(subject, speeds=(0.5,))
    table, summary = found.metrics["constant"], found.metrics["summary"]
    for gait in PAPER_GAITS:
        assert summary["forward"]["gc"][gait] == table[gait]["0.5"]["gc"]
        assert summary["backward"]["gc"][gait] == table[gait]["-0.5"]["gc"]
    means = {way: np.mean(list(summary[way]["gc_stance"].values())) for way in summary}
    assert found.targets[0].here == pytest.approx(means["backward"] - means["forward"])


def test_the_path_of_mixtures_passes_through_the_named_gaits(subject):
    found = mixtures.run(subject, steps=1)
    rows = found.metrics["path"]
    assert [row["place"] for row in rows] == [0.0, 1.0, 2.0]
    scripts = protocols.constant_scripts(mixtures.PATH, (mixtures.SPEED,), subject.seeds, mixtures.SECONDS)
    for row, episodes in zip(rows, subject.simulate(scripts).values(), strict=True):
        named = summaries.constant(episodes[0].script.segments[0].gait.name, episodes, time_reversal=True)
        assert row["gc_stance"] == pytest.approx(named["gc_stance"])


def test_terrain_and_robustness_see_a_policy_that_falls_and_one_that_does_not(subject, faller):
    assert terrain.run(faller, runs=2, seconds=2.0).metrics["by_gait"]["trot"]["success"] == 0.0
    assert terrain.run(subject, runs=1, seconds=2.0).metrics["by_gait"]["trot"]["fell"] == 0.0
    falls = robustness.run(faller, sequences=2, robots=4, seconds=2.0)
    assert falls.metrics["sequences"]["fell"] == 2
    assert all(share == 0.0 for share in falls.metrics["did_not_fall"].values())
    for fall in falls.metrics["sequences"]["falls"]:
        assert all(command["start_s"] <= fall["fell_at_s"] for command in fall["commands"])
    stands = robustness.run(subject, sequences=1, robots=4, seconds=2.0)
    assert stands.metrics["did_not_fall"]["nominal"] == 1.0


@pytest.fixture
def ablation_folder(tmp_path) -> Path:
    for variant, amount in (("full", 0.0), ("no-morphology", 0.03), ("no-time-reversal", 0.0)):
        for seed in (0, 1):
            (tmp_path / f"{variant}-{seed}").mkdir()
            swaying(tmp_path / f"{variant}-{seed}" / "policy.onnx", amount, seed)
    return tmp_path


def test_the_ablation_takes_every_policy_and_policies_that_are_alike_come_out_alike(subject, ablation_folder):
    found = ablation.run(replace(subject, runs=ablation_folder), speeds=(-0.5, 0.5), seconds=3.0)
    curves = found.metrics["curves"]["gc"]
    assert np.array(curves["full"]["by_seed"]).shape == (2, 2)
    assert curves["full"]["by_seed"] == curves["no-time-reversal"]["by_seed"]
    assert curves["full"]["by_seed"] != curves["no-morphology"]["by_seed"]
    ratios = {t.what: t.here for t in found.targets if "ratio" in t.what}
    assert all(value == 1.0 for what, value in ratios.items() if "time-reversal" in what and "cost" not in what)


def test_an_ablation_with_a_missing_or_unpaired_policy_is_refused(ablation_folder, tmp_path_factory):
    with pytest.raises(FileProblem, match="full: none"):
        ablation.policies(tmp_path_factory.mktemp("empty"))
    shutil.rmtree(ablation_folder / "no-morphology-1")
    with pytest.raises(FileProblem, match=r"no-morphology: \[0\]"):
        ablation.policies(ablation_folder)


def test_learning_needs_runs(subject):
    with pytest.raises(InvalidValue, match="--learning"):
        learning.run(subject)


def test_reports_hold_every_target_and_figure_and_json_without_nan(subject, tmp_path):
    figure = velocity_tracking({"trot": recording(get("trot"), 0.5, seconds=1.0)}, "any figure will do")
    result = Result(
        name="one",
        title="One?",
        protocol="What was run.",
        metrics={"values": {"a": math.nan, "b": math.inf, "c": 1.0}},
        targets=(Target("good", 1.0, 2.0, paper="3"), Target("bad", math.inf, 2.0)),
        figures={"one.png": (figure, "Caption.")},
        remarks=("Beware.",),
    )
    written = report.write(result, subject, tmp_path)
    assert written == tmp_path / "one" / "report.md"
    content = json.loads((tmp_path / "one" / "metrics.json").read_text())
    assert content["values"] == {"a": None, "b": None, "c": 1.0}
    assert [t["met"] for t in content["targets"]] == [True, False]
    text = written.read_text()
    assert "![Caption.](one.png)" in text
    assert "Beware." in text
    assert "| bad | - | at most 2 | inf | **no** |" in text
    summary = report.write_summary([result], subject, tmp_path).read_text()
    assert "1 of 2 goals are reached." in summary
    assert summary.index("Not reached:") < summary.index("| one | bad |") < summary.index("## one")
    assert "![Caption.](one/one.png)" in summary
