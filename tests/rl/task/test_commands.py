"""What the robots are told: distributions by statistics with known answers, times by the paper's schedule."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations, pairwise, product
from typing import Any, Literal

import numpy as np
import pytest
import torch
from scipy.stats import binomtest, chisquare, kstest

from rl.task.commands import Commands, GaitSampler
from rl.task.settings import CommandConfig
from symdyn.errors import InvalidValue, UnknownName
from symdyn.gait.library import PAPER_GAITS, Gait, get, wrap
from symdyn.gait.phase import leg_phase
from symdyn.gait.symmetry import classify

UNLIKELY = 1e-4
"""Level of the statistical tests; their seeds are fixed."""

CLASSES = {
    "trot": 0,
    "bound": 1,
    "half_bound_left": 2,
    "half_bound_right": 2,
    "rotary_gallop": 3,
    "transverse_gallop": 4,
}
"""The gaits of the paper that share a symmetry class: the two leads of the half-bound (slip.md)."""


def draw(config: CommandConfig, n: int, seed: int = 0) -> tuple[torch.Tensor, torch.Tensor]:
    return GaitSampler(config).draw(n, torch.Generator().manual_seed(seed))


def commands(n: int = 512, seed: int = 0, **settings: Any) -> Commands:
    made = Commands(CommandConfig(**settings), n, torch.Generator().manual_seed(seed))
    made.reset(torch.arange(n))
    return made


def circular(difference: torch.Tensor) -> torch.Tensor:
    return (difference - difference.round()).abs()


def test_each_symmetry_class_is_equally_likely() -> None:
    index, _ = draw(CommandConfig(choose="class"), 20_000)
    counts = torch.bincount(torch.tensor([CLASSES[name] for name in PAPER_GAITS])[index], minlength=5)
    assert chisquare(counts.numpy()).pvalue > UNLIKELY
    # and within a class, its gaits are
    left, right = (int((index == PAPER_GAITS.index(f"half_bound_{lead}")).sum()) for lead in ("left", "right"))
    assert binomtest(left, left + right).pvalue > UNLIKELY


def test_each_gait_is_equally_likely_as_in_the_paper() -> None:
    index, _ = draw(CommandConfig(choose="gait"), 20_000)
    assert chisquare(torch.bincount(index, minlength=6).numpy()).pvalue > UNLIKELY


def test_the_two_ways_to_choose_differ() -> None:
    # the chi-square test can tell: by gait, the half-bounds come twice as often as another class
    index, _ = draw(CommandConfig(choose="gait"), 20_000)
    counts = torch.bincount(torch.tensor([CLASSES[name] for name in PAPER_GAITS])[index], minlength=5)
    assert chisquare(counts.numpy()).pvalue < UNLIKELY


@pytest.mark.parametrize("name", [*PAPER_GAITS, "pronk", "pace"])
def test_noise_that_keeps_the_class_keeps_k_and_the_symmetric_pairs(name: str) -> None:
    _, offsets = draw(CommandConfig(gaits=(name,), noise_keeps_class=True), 150)
    nominal = classify(get(name))
    for row in offsets:
        found = classify(Gait.wrapped("noisy", row.double().numpy()))
        assert found.K == nominal.K
        assert found.symmetric_pairs == nominal.symmetric_pairs
    assert circular(offsets - torch.tensor(get(name).offsets)).max() > 0.019  # there is noise


def test_noise_of_each_leg_keeps_a_pair_in_seven_of_sixteen_draws() -> None:
    # the difference of two uniforms on +-0.02 is triangular on +-0.04: P(|d| <= 0.01) = 1 - (1 - 1/4)^2
    n = 20_000
    _, offsets = draw(CommandConfig(gaits=("trot",), noise_keeps_class=False), n)
    for i, j in ((0, 2), (1, 3)):
        kept = int((circular(offsets[:, i] - offsets[:, j]) <= 0.01).sum())
        assert binomtest(kept, n, 0.4375).pvalue > UNLIKELY
    # and so says classify
    for row in offsets[:300]:
        pairs = classify(Gait.wrapped("noisy", row.double().numpy())).symmetric_pairs
        distance = float(circular(row[0] - row[2]))
        assert (("LH", "RF") in pairs) == (distance <= 0.01) or abs(distance - 0.01) < 1e-6


@pytest.mark.parametrize("keeps", [True, False])
def test_noise_is_uniform_within_the_papers_bounds(keeps: bool) -> None:
    for name in PAPER_GAITS:
        _, offsets = draw(CommandConfig(gaits=(name,), noise_keeps_class=keeps), 4000)
        noise = offsets - torch.tensor(get(name).offsets)
        noise = noise - noise.round()
        for leg in range(4):
            assert kstest(noise[:, leg].numpy(), "uniform", (-0.02, 0.04)).pvalue > UNLIKELY


def test_without_noise_the_offsets_are_the_librarys() -> None:
    index, offsets = draw(CommandConfig(offset_noise=0.0), 200)
    expected = torch.tensor([get(name).offsets for name in PAPER_GAITS])[index]
    assert torch.equal(offsets, expected)


def test_every_mixture_lies_between_two_gaits_of_the_list() -> None:
    _, offsets = draw(CommandConfig(offset_noise=0.0, mixture_share=1.0), 300)
    parts = []
    for row in offsets.double().numpy():
        found = None
        for a, b in product(PAPER_GAITS, repeat=2):
            way, gone = wrap(get(b).theta - get(a).theta), wrap(row - get(a).theta)
            part = float(way @ gone / (way @ way)) if way.any() else 0.0
            if -1e-6 < part < 1.0 + 1e-6 and np.abs(wrap(gone - part * way)).max() < 1e-5:
                found = part
        assert found is not None, row
        parts.append(found)
    assert np.mean((np.array(parts) > 0.1) & (np.array(parts) < 0.9)) > 0.05


def test_the_share_of_mixtures_is_that_of_the_settings() -> None:
    gaits = CommandConfig(gaits=("trot", "bound"), offset_noise=0.0, mixture_share=0.4)
    _, offsets = draw(gaits, 20_000)
    pure = torch.tensor([get(name).offsets for name in gaits.gaits])
    mixed = ~torch.isclose(offsets[:, None], pure).all(dim=2).any(dim=1)
    # a mixture of a gait with itself is that gait
    assert float(mixed.float().mean()) == pytest.approx(0.2, abs=0.02)


def test_drawn_offsets_stay_below_one() -> None:
    sampler, generator = GaitSampler(CommandConfig(gaits=("pronk",))), torch.Generator().manual_seed(0)
    assert all(bool((sampler.draw(200_000, generator)[1] < 1.0).all()) for _ in range(10))


def test_velocities_are_uniform_in_their_ranges() -> None:
    made = commands(n=4000, velocity_y=(-0.5, 0.2), yaw_rate=(0.1, 0.4))
    for column, (low, high) in enumerate(((-2.0, 2.0), (-0.5, 0.2), (0.1, 0.4))):
        assert kstest(made.velocity[:, column].numpy(), "uniform", (low, high - low)).pvalue > UNLIKELY


def test_period_and_duty_have_deltas_of_their_own() -> None:
    # the paper writes one delta in both rows of its equation 1; the issue draws one for each
    made = commands(n=4000)
    for delta in (made.period_delta, made.duty_delta):
        assert kstest(delta.numpy(), "uniform", (-1.0, 2.0)).pvalue > UNLIKELY
    correlation = torch.corrcoef(torch.stack([made.period_delta, made.duty_delta]))[0, 1]
    assert abs(float(correlation)) < 4.0 / math.sqrt(4000)


def changes(made: Commands, seconds: float = 30.0, dt: float = 0.02) -> tuple[list[set[float]], list[set[float]]]:
    """For each robot the times at which its velocity and its gait changed, as the environment asks at every step."""
    n = len(made.velocity)
    velocity_at, gait_at = [set() for _ in range(n)], [set() for _ in range(n)]
    for step in range(1, round(seconds / dt) + 1):
        velocity, offsets, deltas = made.velocity.clone(), made.offsets.clone(), made.period_delta.clone()
        made.update(torch.full((n,), step) * dt)
        for i in torch.nonzero((velocity != made.velocity).any(dim=1)).flatten().tolist():
            velocity_at[i].add(round(step * dt, 6))
        assert torch.equal((velocity != made.velocity).any(dim=1), deltas != made.period_delta)
        for i in torch.nonzero((offsets != made.offsets).any(dim=1)).flatten().tolist():
            gait_at[i].add(round(step * dt, 6))
    return velocity_at, gait_at


def test_the_papers_schedule() -> None:
    velocity_at, gait_at = changes(commands(n=8))
    assert velocity_at == [{10.0}] * 8
    assert gait_at == [{20.0}] * 8


def test_a_schedule_with_repeats_keeps_to_its_intervals() -> None:
    made = commands(
        n=40, velocity_first_s=(1.0, 2.0), velocity_again_s=(0.5, 0.7), gait_first_s=(3.0, 4.0), gait_again_s=(1.0, 1.5)
    )
    velocity_at, gait_at = changes(made, seconds=8.0)
    for times, first, again in ((velocity_at, (1.0, 2.0), (0.5, 0.7)), (gait_at, (3.0, 4.0), (1.0, 1.5))):
        for found in map(sorted, times):
            assert first[0] - 1e-6 <= found[0] <= first[1] + 0.02
            for gap in (b - a for a, b in pairwise(found)):
                assert again[0] - 1e-6 <= gap <= again[1] + 0.02 + 1e-6
            assert found[-1] > 8.0 - again[1] - 0.02  # it goes on
    assert len({tuple(sorted(found)) for found in velocity_at}) > 30  # each robot by itself


def test_reset_touches_only_the_robots_whose_episode_begins() -> None:
    made = commands(n=6)
    made.update(torch.full((6,), 25.0))
    assert torch.isinf(made.velocity_due).all()
    before, ids = made.state_dict(), torch.tensor([1, 4])
    made.reset(ids)
    after, others = made.state_dict(), torch.tensor([0, 2, 3, 5])
    for name, value in before.items():
        assert torch.equal(after[name][others], value[others])
    assert not torch.equal(after["velocity"][ids], before["velocity"][ids])
    assert after["velocity_due"][ids].tolist() == [10.0, 10.0]
    assert after["gait_due"][ids].tolist() == [20.0, 20.0]


def test_state_dict_is_all_there_is() -> None:
    a = commands(n=5, seed=1, velocity_again_s=(1.0, 2.0), gait_again_s=(1.0, 2.0))
    a.update(torch.full((5,), 12.0))
    saved, generator = a.state_dict(), a._generator.get_state()
    b = commands(n=5, seed=2, velocity_again_s=(1.0, 2.0), gait_again_s=(1.0, 2.0))
    b.load_state_dict(saved)
    b._generator.set_state(generator)
    for step in range(200):
        time = torch.full((5,), 12.0 + 0.1 * step)
        a.update(time)
        b.update(time)
    assert all(torch.equal(value, b.state_dict()[name]) for name, value in a.state_dict().items())
    assert not torch.equal(a.velocity, saved["velocity"])  # the saved tensors are copies


def test_backward_commands_run_the_clock_backwards() -> None:
    made = commands(n=200)
    backward = made.velocity[:, 0] < 0
    assert 50 < int(backward.sum()) < 150
    now, later = (leg_phase(torch.full((200,), phi), made.offsets, made.velocity[:, 0]) for phi in (0.3, 0.31))
    step = later - now
    step -= step.round()
    expected = torch.where(backward, -0.01, 0.01)[:, None].expand(200, 4)
    assert torch.allclose(step, expected, atol=1e-6)


@pytest.mark.parametrize(
    ("setting", "value"),
    [
        ("gaits", ()),
        ("offset_noise", -0.01),
        ("offset_noise", 0.5),
        ("velocity_x", (1.0, -1.0)),
        ("velocity_x", (0.0, math.nan)),
        ("yaw_rate", (-math.inf, 0.0)),
        ("velocity_first_s", (0.0, 1.0)),
        ("gait_again_s", (2.0, 1.0)),
    ],
)
def test_bad_settings_are_refused_by_name(setting: str, value: Any) -> None:
    with pytest.raises(InvalidValue, match="gaits" if setting == "gaits" else setting):
        CommandConfig(**{setting: value})


def test_an_unknown_gait_is_refused() -> None:
    with pytest.raises(UnknownName, match="'trott'"):
        replace(CommandConfig(), gaits=("trot", "trott"))


def test_the_gaits_of_the_paper_have_the_pairs_that_it_says() -> None:
    # (legs that share an offset) for the classes above, straight from the paper's Table I
    for name in PAPER_GAITS:
        theta = get(name).offsets
        pairs = {(i, j) for i, j in combinations(range(4), 2) if theta[i] == theta[j]}
        assert len(pairs) == {0: 2, 1: 2, 2: 1, 3: 0, 4: 0}[CLASSES[name]]


@pytest.mark.parametrize("share", [0.0, 0.65, 1.0])
def test_share_of_forward_commands(share: float) -> None:
    made = commands(n=4000, velocity_x=(-1.0, 2.0), forward_share=share)
    made.reset(torch.arange(4000))
    v = made.velocity[:, 0]
    assert float((v > 0).float().mean()) == pytest.approx(share, abs=0.03)
    for part, low, high in ((v[v > 0], 0.0, 2.0), (v[v < 0], -1.0, 0.0)):
        if len(part):
            # uniform on either side
            assert kstest(part.numpy(), "uniform", args=(low, high - low)).pvalue > 1e-3


@pytest.mark.parametrize("bad", [{"forward_share": 1.1}, {"forward_share": 0.5, "velocity_x": (0.5, 1.0)}])
def test_bad_shares_of_forward_commands_are_refused(bad: dict[str, Any]) -> None:
    with pytest.raises(InvalidValue):
        CommandConfig(**bad)


@pytest.mark.parametrize("choose", ["gait", "class"])
def test_weights_multiply_how_often_a_gait_is_drawn(choose: Literal["gait", "class"]) -> None:
    gaits = ("trot", "half_bound_left", "half_bound_right", "rotary_gallop")
    plain = GaitSampler(CommandConfig(gaits=gaits, choose=choose)).probability
    weighted = GaitSampler(CommandConfig(gaits=gaits, choose=choose, weights=(1.0, 1.0, 1.0, 3.0))).probability
    assert plain.tolist() == pytest.approx([0.25] * 4 if choose == "gait" else [1 / 3, 1 / 6, 1 / 6, 1 / 3])
    ratio = weighted / plain
    assert (ratio / ratio[0]).tolist() == pytest.approx([1.0, 1.0, 1.0, 3.0])
    assert float(weighted.sum()) == pytest.approx(1.0)


@pytest.mark.parametrize("bad", [(1.0,), (1.0, 0.0), (1.0, math.inf), (1.0, math.nan), (math.nan, 1.0)])
def test_bad_weights_are_refused(bad: tuple[float, ...]) -> None:
    with pytest.raises(InvalidValue, match="weights"):
        CommandConfig(gaits=("trot", "bound"), weights=bad)
