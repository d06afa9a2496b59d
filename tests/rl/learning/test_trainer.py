"""The same seed gives the same weights, and an interruption leaves no trace in them."""

from __future__ import annotations

import math
import os
import signal
from dataclasses import replace
from pathlib import Path

import pytest
import torch

from rl.cli.train import start
from rl.learning import checkpoint, run_log
from rl.learning.config import TrainConfig
from rl.learning.export import export_policy
from rl.learning.presets import preset
from rl.learning.stages import Stage
from rl.learning.trainer import Diverged, Trainer
from symdyn.errors import FileProblem, InvalidValue
from symdyn.policy.file import Policy


def _config(**changes) -> TrainConfig:
    smoke = preset("smoke")
    # short episodes and frequent changes, so that resets and new commands fall on both sides of an interruption
    commands = replace(
        smoke.env.commands,
        velocity_first_s=(0.1, 0.3),
        velocity_again_s=(0.1, 0.3),
        gait_first_s=(0.1, 0.3),
        gait_again_s=(0.1, 0.3),
    )
    randomization = replace(smoke.env.randomization, push_interval_s=(0.1, 0.4))
    env = replace(smoke.env, episode_s=0.3, commands=commands, randomization=randomization)
    small = replace(smoke, iterations=6, num_envs=8, env=env, checkpoint_every=2)
    return replace(small, **changes)


def _weights(trainer: Trainer) -> dict[str, torch.Tensor]:
    networks = {"actor": trainer.ppo.actor, "critic": trainer.ppo.critic}
    return {f"{n}.{key}": value.clone() for n, net in networks.items() for key, value in net.state_dict().items()}


def _equal(a: dict[str, torch.Tensor], b: dict[str, torch.Tensor]) -> bool:
    return a.keys() == b.keys() and all(torch.equal(a[key], b[key]) for key in a)


def _trained(config: TrainConfig, run: Path) -> Trainer:
    trainer = Trainer(config, run)
    assert trainer.train()
    return trainer


def test_same_seed_same_weights_and_another_seed_others(tmp_path):
    first = _weights(_trained(_config(), tmp_path / "a"))
    again = _weights(_trained(_config(), tmp_path / "b"))
    other = _weights(_trained(_config(seed=1), tmp_path / "c"))
    assert _equal(first, again)
    assert not _equal(first, other)


@pytest.mark.parametrize("stop_at", [1, 3, 5])
def test_resumed_run_equals_an_uninterrupted_one_bit_by_bit(tmp_path, stop_at):
    whole = _trained(_config(), tmp_path / "whole")
    _trained(_config(iterations=stop_at), tmp_path / "cut")
    torch.manual_seed(12345)  # whatever happens between, in this process or another
    resumed = Trainer(_config(), tmp_path / "cut")
    resumed.resume()
    assert resumed.iteration == stop_at
    assert resumed.train()
    assert _equal(_weights(whole), _weights(resumed))
    left = [checkpoint.load_newest(tmp_path / name)["env"] for name in ("whole", "cut")]
    assert torch.equal(left[0]["physics"]["state"], left[1]["physics"]["state"])
    assert torch.equal(left[0]["generator"], left[1]["generator"])


def test_the_log_of_a_resumed_run_has_every_update_once_with_the_same_figures(tmp_path):
    whole, cut = tmp_path / "whole", tmp_path / "cut"
    _trained(_config(), whole)
    _trained(_config(iterations=3), cut)
    # an update that was logged after the last checkpoint and then lost: it will be done again
    with (cut / run_log.FILE).open("a") as stream:
        stream.write('{"iteration": 4, "samples": 0}\n{"iteration": 5, "samp')
    resumed = Trainer(_config(), cut)
    resumed.resume()
    resumed.train()
    assert [record["iteration"] for record in run_log.read(cut)] == [1, 2, 3, 4, 5, 6]
    untimed = [
        [{k: v for k, v in record.items() if not k.startswith("time/")} for record in run_log.read(run)]
        for run in (whole, cut)
    ]
    assert untimed[0] == untimed[1]


def test_a_damaged_newest_checkpoint_costs_only_the_updates_since_the_one_before(tmp_path, caplog):
    _trained(_config(iterations=4), tmp_path)
    newest = checkpoint.list_checkpoints(tmp_path)[-1]
    newest.write_bytes(newest.read_bytes()[:1000])
    trainer = Trainer(_config(), tmp_path)
    trainer.resume()
    assert trainer.iteration == 2
    assert newest.name in caplog.text


def test_a_run_started_from_another_has_its_networks_and_nothing_else(tmp_path):
    before = _trained(_config(iterations=4), tmp_path / "before")
    start(before)
    after = Trainer(_config(seed=5), tmp_path / "after")
    came_from = after.start_from(tmp_path / "before")
    assert _equal(_weights(before), _weights(after))
    assert after.ppo.learning_rate == before.ppo.learning_rate
    assert after.iteration == 0
    assert came_from["samples"] == 4 * before.config.samples_per_iteration
    assert (came_from["run"], came_from["seed"], came_from["iteration"]) == ("before", 0, 4)
    states = [trainer.env.state_dict()["physics"]["state"] for trainer in (before, after)]
    assert not torch.equal(*states), "robots of its own"


def test_samples_and_seconds_add_up_over_a_chain_of_runs_and_into_the_policy_file(tmp_path):
    chain = [tmp_path / name for name in ("a", "b", "c")]
    total = 0.0
    for before, run in zip([None, *chain], chain, strict=False):
        trainer = Trainer(_config(iterations=2), run)
        start(trainer, None if before is None else trainer.start_from(before))
        assert trainer.train()
        total += trainer.seconds
    last = Trainer(_config(), tmp_path / "d")
    found = last.start_from(chain[-1])
    assert found["samples"] == 6 * last.config.samples_per_iteration
    assert found["seconds"] == pytest.approx(total)
    policy = Policy.load(export_policy(chain[-1]))
    assert policy.metadata.training["samples"] == 6 * last.config.samples_per_iteration


def test_the_noise_to_start_with_is_that_of_every_joint(tmp_path):
    start(_trained(_config(iterations=2), tmp_path / "before"))
    after = Trainer(_config(), tmp_path / "after")
    after.start_from(tmp_path / "before", std=0.2)
    after.ppo.act(after.env.get_observations())
    assert torch.allclose(after.ppo.get_policy().output_std, torch.tensor(0.2))


def test_a_run_with_other_networks_is_no_start(tmp_path):
    start(_trained(_config(iterations=2), tmp_path / "before"))
    other = _config()
    with pytest.raises(FileProblem, match="another configuration"):
        Trainer(replace(other, ppo=replace(other.ppo, hidden=(16,))), tmp_path / "after").start_from(
            tmp_path / "before"
        )


def test_old_checkpoints_go_but_every_kept_one_stays(tmp_path):
    _trained(_config(iterations=6, checkpoint_every=1, keep_every=3), tmp_path)
    assert [int(path.stem) for path in checkpoint.list_checkpoints(tmp_path)] == [3, 5, 6]


def test_a_checkpoint_of_other_networks_is_refused_in_one_sentence(tmp_path):
    _trained(_config(iterations=2), tmp_path)
    other = _config()
    trainer = Trainer(replace(other, ppo=replace(other.ppo, hidden=(16,))), tmp_path)
    with pytest.raises(FileProblem, match="another configuration"):
        trainer.resume()


def test_a_pickle_that_runs_code_is_refused(tmp_path):
    marker = tmp_path / "ran"

    class Evil:
        def __reduce__(self):
            return os.system, (f"touch {marker}",)

    folder = tmp_path / "checkpoints"
    folder.mkdir()
    torch.save({"iteration": 1, "evil": Evil()}, folder / "0000001.pt")
    with pytest.raises(FileProblem):
        checkpoint.load(folder / "0000001.pt")
    assert not marker.exists()


def test_a_signal_ends_after_the_update_with_a_checkpoint(tmp_path):
    trainer = Trainer(_config(iterations=100), tmp_path)

    def interrupt(record) -> None:
        if record["iteration"] == 3:
            os.kill(os.getpid(), signal.SIGINT)

    assert not trainer.train(interrupt)
    assert trainer.interrupted
    assert checkpoint.load_newest(tmp_path)["iteration"] == 3


def test_the_time_limit_ends_a_run(tmp_path):
    trainer = Trainer(_config(iterations=10_000), tmp_path)
    assert not trainer.train(time_limit_s=0.5)
    assert not trainer.interrupted
    assert checkpoint.load_newest(tmp_path)["iteration"] == trainer.iteration > 0


def test_the_entropy_weight_follows_its_ramp(tmp_path):
    base = _config()
    # 8 robots x 8 steps = 64 samples an update; the weight is the one at the update's beginning
    stages = (Stage("a", samples=64.0), Stage("b", ramp=128.0, settings={"ppo.entropy": 0.0}))
    _trained(replace(base, ppo=replace(base.ppo, entropy=0.02), stages=stages), tmp_path)
    weights = [record["learn/entropy_weight"] for record in run_log.read(tmp_path)]
    assert weights == pytest.approx([0.02, 0.02, 0.01, 0.0, 0.0, 0.0])


def test_training_that_diverges_stops_at_the_last_good_checkpoint_and_says_how_to_go_on(tmp_path):
    trainer = _trained(_config(iterations=2), tmp_path)
    logged = run_log.read(tmp_path)
    further = Trainer(_config(iterations=4), tmp_path)
    further.resume()
    with torch.no_grad():
        next(further.ppo.critic.parameters()).fill_(math.nan)
    message = r"diverged in update 3 \(.*weights of the critic are not finite.*Its last checkpoint is from update 2"
    with pytest.raises(Diverged, match=message) as said:
        further.train()
    assert f"symdyn train --start-from {tmp_path}" in str(said.value)
    assert run_log.read(tmp_path) == logged
    assert checkpoint.load_newest(tmp_path)["iteration"] == trainer.iteration == 2


def test_a_batch_whose_advantages_cannot_be_normalised_is_refused():
    config = _config()
    with pytest.raises(InvalidValue, match="mini_batches is 4, but must be at most num_envs"):
        replace(config, num_envs=1, ppo=replace(config.ppo, steps=4, mini_batches=4))
    with pytest.raises(InvalidValue, match="/ 2 = 0"):
        replace(config, num_envs=1, ppo=replace(config.ppo, steps=1, mini_batches=1))
