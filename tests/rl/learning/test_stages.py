"""Stages: what holds when, what ends them, and that they are resumed exactly."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from rl.learning import checkpoint, config_file, run_log
from rl.learning.config import TrainConfig
from rl.learning.presets import PRESETS, preset
from rl.learning.stages import MEASURED, Criterion, Stage
from rl.learning.trainer import Trainer
from rl.physics.engine import ENGINES
from rl.task.settings import RewardConfig
from symdyn.errors import FileProblem, InvalidValue
from symdyn.io.settings_data import plain

FIRST = Stage("first", samples=100.0)
SECOND = Stage(
    "second",
    samples=400.0,
    ramp=200.0,
    settings={
        "env.rewards.temporal": 0.35,
        "env.rewards.velocity_filter": 1,
        "env.rewards.morphological_term": False,
        "env.randomization.friction": (0.5, 1.5),
        "ppo.entropy": 0.0,
        "ppo.epochs": 3,
    },
)
CONFIG = TrainConfig(stages=(FIRST, SECOND, Stage("third", settings={"env.rewards.temporal": 0.5})))


def test_a_stage_keeps_what_the_one_before_it_set() -> None:
    third = CONFIG.in_stage(2)
    assert third.env.rewards == replace(RewardConfig(), temporal=0.5, velocity_filter=1.0, morphological_term=False)
    assert third.env.randomization.friction == (0.5, 1.5)
    assert (third.ppo.entropy, third.ppo.epochs, third.stages) == (0.0, 3, ())
    assert CONFIG.in_stage(0) == replace(CONFIG, stages=())


def test_half_way_through_a_ramp_rewards_are_half_way_and_the_rest_has_changed() -> None:
    half = CONFIG.in_stage(1, 100.0)
    assert half.env.rewards.temporal == pytest.approx((0.15 + 0.35) / 2.0)
    assert half.env.rewards.velocity_filter == pytest.approx(0.5)
    assert half.ppo.entropy == pytest.approx(0.005)
    assert half.ppo.epochs == 3
    assert half.env.rewards.morphological_term is False
    assert half.env.randomization.friction == (0.5, 1.5)


@settings(max_examples=30)
@given(st.floats(0.0, 1e4))
def test_every_reward_stays_between_its_ends(samples: float) -> None:
    now, ends = CONFIG.in_stage(1, samples).env.rewards, (CONFIG.in_stage(0), CONFIG.in_stage(1))
    for item in fields(RewardConfig):
        low, high = sorted(getattr(end.env.rewards, item.name) for end in ends)
        assert low - 1e-12 <= getattr(now, item.name) <= high + 1e-12


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_survives_its_file(name: str, tmp_path: Path) -> None:
    config = preset(name)
    config_file.save(config, tmp_path / "config.yaml")
    loaded = config_file.load(tmp_path / "config.yaml")
    for stage in range(max(len(config.stages), 1)):
        assert loaded.in_stage(stage, 1e5) == config.in_stage(stage, 1e5)
    assert plain(loaded) == plain(config)


def test_the_default_run_ends_in_the_physics_of_the_evaluation() -> None:
    config = preset("cpu")
    assert config.in_stage(0).engine == ENGINES["fast"]
    assert config.in_stage(len(config.stages) - 1).engine == ENGINES["accurate"]


@pytest.mark.parametrize(
    ("stages", "message"),
    [
        ((Stage("a"), Stage("b")), "only the last stage may last until the run ends"),
        ((FIRST, FIRST), "different from each other"),
        ((Stage("a", settings={"env.rewards.no_such": 1.0}),), r"env\.rewards\.no_such|no_such"),
        ((Stage("a", settings={"env.rewards.temporal.x": 1.0}),), "dotted name"),
        ((Stage("a", settings={"env.rewards.temporal": -1.0}),), r"stage 'a'.*temporal"),
        ((Stage("a", settings={"env.rewards.temporal": "much"}),), r"temporal is 'much'"),
        ((Stage("a", settings={"env.commands.velocity_x": [1.0, -1.0]}),), "velocity_x"),
    ],
)
def test_stages_without_sense_are_refused(stages: tuple[Stage, ...], message: str) -> None:
    with pytest.raises((InvalidValue, FileProblem), match=message):
        TrainConfig(stages=stages)


@pytest.mark.parametrize("name", ["robot", "seed", "num_envs", "ppo.hidden", "env.observation", "stages"])
def test_a_stage_cannot_change_what_a_run_is(name: str) -> None:
    with pytest.raises(InvalidValue, match="setting"):
        Stage("a", settings={name: 1})


@pytest.mark.parametrize("changes", [{"samples": 0.0}, {"samples": 10.0, "ramp": 11.0}, {"name": " "}, {"ramp": -1.0}])
def test_bad_stages(changes: dict) -> None:
    with pytest.raises(InvalidValue):
        Stage(**{"name": "a", **changes})


def test_a_criterion_that_nothing_measures_is_refused() -> None:
    with pytest.raises(InvalidValue, match="task/x_velocity_error"):
        Criterion("task/grace", at_most=1.0)
    with pytest.raises(InvalidValue, match="either at_most or at_least"):
        Criterion(MEASURED[0])


def _small(**changes) -> TrainConfig:
    smoke = preset("smoke")
    return replace(smoke, num_envs=8, iterations=20, checkpoint_every=1, **changes)


CHANGING = (
    Stage("fast", samples=128.0),
    Stage(
        "accurate",
        samples=192.0,
        ramp=100.0,
        settings={
            "engine.solver": "newton",
            "engine.timestep": 0.005,
            "env.episode_s": 0.2,
            "env.randomization.delay_s": [0.0, 0.02],
            "env.rewards.temporal": 0.5,
            "ppo.epochs": 1,
        },
    ),
)


def test_a_run_goes_through_its_stages_and_ends_with_the_last(tmp_path: Path) -> None:
    trainer = Trainer(_small(stages=CHANGING), tmp_path)
    assert trainer.train()
    records = run_log.read(tmp_path)
    assert [record["stage"] for record in records] == [0, 0, 1, 1, 1]
    assert trainer.config.total_iterations == len(records)
    assert trainer.env.physics.substeps == 4  # type: ignore[attr-defined]
    assert trainer.env.max_episode_length == 10


@pytest.mark.parametrize("stop_at", [1, 2, 4])
def test_a_run_resumed_in_any_stage_goes_on_bit_by_bit(tmp_path: Path, stop_at: int) -> None:
    whole = Trainer(_small(stages=CHANGING), tmp_path / "whole")
    assert whole.train()
    cut = Trainer(replace(_small(stages=CHANGING), iterations=stop_at), tmp_path / "cut")
    assert cut.train()
    resumed = Trainer(_small(stages=CHANGING), tmp_path / "cut")
    resumed.resume()
    assert resumed.train()
    a, b = (checkpoint.load_newest(tmp_path / name) for name in ("whole", "cut"))
    assert torch.equal(a["env"]["physics"]["state"], b["env"]["physics"]["state"])
    actors = [content["ppo"]["actor_state_dict"] for content in (a, b)]
    assert all(torch.equal(actors[0][key], actors[1][key]) for key in actors[0])


def test_a_criterion_that_is_met_ends_its_stage_and_one_that_is_not_does_not(tmp_path: Path) -> None:
    ends = {}
    for name, bound in (("met", 1e3), ("missed", 0.0)):
        criterion = Criterion("task/x_velocity_error", at_most=bound, updates=2)
        stages = (Stage("a", samples=320.0, criterion=criterion), Stage("b", samples=64.0))
        assert Trainer(_small(stages=stages), tmp_path / name).train()
        ends[name] = [record["stage"] for record in run_log.read(tmp_path / name)].count(0)
    assert ends == {"met": 2, "missed": 5}
