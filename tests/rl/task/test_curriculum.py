"""The reward goes from the initial one to the final one, in the environment as in the settings."""

from __future__ import annotations

from dataclasses import fields, replace

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from rl.learning.config import preset
from rl.physics.batch import BatchPhysics
from rl.physics.model import build_model
from rl.task.curriculum import RewardCurriculum
from rl.task.env import GaitEnv
from rl.task.rewards import RewardConfig
from symdyn.errors import InvalidValue
from symdyn.gait.timing import TimingCurve
from tests.robots import GO2

INITIAL = RewardConfig()
FINAL = RewardConfig(temporal=0.35, force_rate=0.021, velocity_filter=1.0, exp_share=1.0)
RAMP = RewardCurriculum(active=True, start=100.0, end=300.0, final=FINAL)


@pytest.mark.parametrize(("samples", "wanted"), [(0, INITIAL), (100, INITIAL), (300, FINAL), (1e9, FINAL)])
def test_ends(samples: float, wanted: RewardConfig) -> None:
    assert RAMP.at(INITIAL, samples) == wanted


def test_half_way() -> None:
    half = RAMP.at(INITIAL, 200)
    assert half.temporal == pytest.approx(0.25)
    assert half.force_rate == pytest.approx(0.011)
    assert half.velocity_filter == half.exp_share == pytest.approx(0.5)
    assert half.y_rate == INITIAL.y_rate


@given(st.floats(0.0, 1e3))
def test_every_number_stays_between_its_ends(samples: float) -> None:
    now = RAMP.at(INITIAL, samples)
    for item in fields(RewardConfig):
        ends = sorted((getattr(INITIAL, item.name), getattr(FINAL, item.name)))
        assert ends[0] - 1e-12 <= getattr(now, item.name) <= ends[1] + 1e-12


def test_inactive_it_changes_nothing() -> None:
    assert replace(RAMP, active=False).at(INITIAL, 1e9) is INITIAL


def test_the_switch_of_an_ablation_and_kappa_are_kept() -> None:
    ablated = replace(INITIAL, morphological_term=False, kappa=30.0)
    late = RAMP.at(ablated, 1e9)
    assert (late.morphological_term, late.kappa, late.temporal) == (False, 30.0, FINAL.temporal)


@pytest.mark.parametrize("span", [(5.0, 5.0), (6.0, 5.0), (-1.0, 5.0), (0.0, float("inf")), (0.0, float("nan"))])
def test_bad_spans(span: tuple[float, float]) -> None:
    with pytest.raises(InvalidValue, match="start < end"):
        RewardCurriculum(start=span[0], end=span[1])


def test_the_environment_rewards_by_it() -> None:
    def rewards(config, samples: int) -> torch.Tensor:
        env = GaitEnv(config, BatchPhysics(build_model(GO2), GO2, 4, 1), TimingCurve(), GO2, seed=1)
        env.set_progress(samples)
        return torch.stack([env.step(torch.zeros(4, 12))[1] for _ in range(5)])

    base = replace(preset("cpu").env, rewards=INITIAL, curriculum=RAMP)
    fixed = replace(base, curriculum=replace(RAMP, active=False))
    assert torch.equal(rewards(base, 0), rewards(fixed, 0))
    assert torch.equal(rewards(base, 1000), rewards(replace(fixed, rewards=FINAL), 0))
    assert not torch.allclose(rewards(base, 200), rewards(base, 1000))
