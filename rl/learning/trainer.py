"""The training loop: collect, learn, write down, checkpoint; stoppable and resumable at every update."""

from __future__ import annotations

import logging
import math
import shlex
import time
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, Protocol

import torch

from rl.learning import checkpoint, config_file, run_dir
from rl.learning.config import TrainConfig
from rl.learning.learner import make_ppo
from rl.learning.run_log import RunLog
from rl.learning.signals import on_stop
from rl.learning.stages import MEASURED, Criterion, Stage
from rl.physics.batch import BatchPhysics
from rl.physics.model import build_model
from rl.task.env import GaitEnv
from symdyn.errors import FileProblem, SymdynError

_log = logging.getLogger(__name__)
_EPISODES_AVERAGED = 200


def _longest_criterion(stages: tuple[Stage, ...]) -> int:
    return max((stage.criterion.updates for stage in stages if stage.criterion is not None), default=1)


class Watcher(Protocol):
    """Something that shows progress."""

    def __call__(self, record: dict[str, Any]) -> None:
        """Called after every update with what was logged of it."""
        ...


class Diverged(SymdynError):
    """Losses or weights are no longer finite."""


class Trainer:
    """One run in one directory.

    Args:
        config: settings.
        run: directory of the run; its checkpoints, if any, are not looked at before :meth:`resume`.

    Raises:
        SymdynError: for bad settings, a bad robot or timing file, or a machine without room.
    """

    def __init__(self, config: TrainConfig, run: Path) -> None:
        self.config = config
        self.run = run
        torch.manual_seed(config.seed)
        self.robot = run_dir.robot(run, config.robot)
        timing = run_dir.timing(run, config.timing, self.robot)
        self.stage = 0
        self._stage_began = 0
        self._recent: deque[dict[str, float]] = deque(maxlen=_longest_criterion(config.stages))
        self._now = config.in_stage(0, 0.0)
        env = self._now.env
        self.env = GaitEnv(env, self._physics(), timing, self.robot, config.seed, run / "diverged")
        self.ppo = make_ppo(self._now.ppo, self.env)
        self.iteration = 0
        self.seconds = 0.0
        self.interrupted = False
        self._returns = torch.zeros(config.num_envs)
        self._lengths = torch.zeros(config.num_envs)
        self._episodes: deque[tuple[float, float]] = deque(maxlen=_EPISODES_AVERAGED)

    @property
    def samples(self) -> int:
        """Environment steps so far."""
        return self.iteration * self.config.samples_per_iteration

    @property
    def done(self) -> bool:
        """Whether the run has come to its end."""
        stages = self.config.stages
        return self.iteration >= self.config.iterations or (bool(stages) and self.stage >= len(stages))

    def start_from(self, run: Path, std: float | None = None) -> dict[str, Any]:
        """Begin with what another run has learned: networks, action noise, and the optimiser with its learning rate.

        Everything else is new: the robots, the random numbers, and the count of samples that the curriculum and the
        entropy weight go by.

        Args:
            run: directory of the other run, whose newest checkpoint is taken.
            std: standard deviation to set the action noise of every joint to; that of the other run if None.

        Returns:
            Where this run comes from, for ``origin.json``: that run's name and seed, and the updates, samples and
            seconds of training behind it, those of its own ancestors included; and ``std``.

        Raises:
            FileProblem: if it is no run, has no checkpoint that can be read, or has other networks or another robot.
        """
        its = config_file.load(run_dir.existing(run) / run_dir.CONFIG)
        state = checkpoint.load_newest(run)
        self._load_learner(state, run)
        if std is not None:
            with torch.no_grad():
                self.ppo.get_policy().get_parameter("distribution.log_std_param").fill_(math.log(std))
        before = run_dir.ancestor(run)
        return {
            "run": run.resolve().name,
            "seed": its.seed,
            "iteration": state["iteration"],
            "samples": before["samples"] + state["iteration"] * its.num_envs * its.ppo.steps,
            "seconds": before["seconds"] + state["seconds"],
            "std": std,
        }

    def resume(self) -> None:
        """Go on from the newest checkpoint of the run, bit by bit as if there had been no interruption.

        Raises:
            FileProblem: if there is none that can be read, or it is of another configuration.
        """
        state = checkpoint.load_newest(self.run)
        self._load_learner(state, self.run)
        try:
            self.stage, self._stage_began = state["stage"], state["stage_began"]
            self._recent.extend(state["recent"])
            if self.config.stages:
                samples = state["iteration"] * self.config.samples_per_iteration
                self._enter_stage(self.stage, samples - self._stage_began)
            self.env.load_state_dict(state["env"])
        except (KeyError, RuntimeError, ValueError) as error:
            raise FileProblem(self.run, f"holds a checkpoint of another configuration ({error}).") from error
        torch.set_rng_state(state["torch_rng"])
        self.iteration = state["iteration"]
        self.seconds = state["seconds"]
        self._returns = state["returns"].clone()
        self._lengths = state["lengths"].clone()
        self._episodes.extend(tuple(pair) for pair in state["episodes"])

    def train(self, watch: Watcher | None = None, time_limit_s: float = math.inf) -> bool:
        """Train until ``config.iterations`` updates are done, the time is up, or SIGINT, SIGTERM or SIGHUP comes.

        Args:
            watch: called after every update.
            time_limit_s: no update is begun after so many seconds.

        Returns:
            Whether the run is done. A checkpoint is written in every case; ``interrupted`` tells of a signal.

        Raises:
            Diverged: if losses or weights are no longer finite after an update, which is neither logged nor kept.
        """
        end = time.monotonic() + time_limit_s
        log = RunLog(self.run, self.iteration)
        self.ppo.train_mode()
        saved_at = self.iteration
        try:
            with stop_on_signal() as stop:
                while not self.done and not stop and time.monotonic() < end:
                    record = self.update()
                    log.add(record)
                    if watch is not None:
                        watch(record)
                    if self.iteration % self.config.checkpoint_every == 0:
                        log.sync()
                        self._save()
                        saved_at = self.iteration
                if saved_at != self.iteration:
                    log.sync()
                    self._save()
                self.interrupted = bool(stop)
        finally:
            log.close()
        return self.done

    def update(self) -> dict[str, Any]:
        """Collect, learn, and return what is logged of it. Raises Diverged."""
        start = time.perf_counter()
        sums: dict[str, torch.Tensor] = {}
        reward_sum = torch.zeros(())
        steps = self.config.ppo.steps
        self._ramp()
        obs = self.env.get_observations()
        with torch.inference_mode():
            for _ in range(steps):
                actions = self.ppo.act(obs)
                obs, rewards, dones, extras = self.env.step(actions)
                self.ppo.process_env_step(obs, rewards, dones, extras)
                self._count_episodes(rewards, dones)
                reward_sum += rewards.mean()
                for key, value in extras["log"].items():
                    sums[key] = sums.get(key, torch.zeros(())) + value
            collected = time.perf_counter()
            self.ppo.compute_returns(obs)
        try:
            losses = self.ppo.update()
        except (RuntimeError, ValueError):  # torch refuses to sample from what is no distribution any more
            self._check_finite({})
            raise
        self._check_finite(losses)
        end = time.perf_counter()
        self.iteration += 1
        self.seconds += end - start
        record = {
            "iteration": self.iteration,
            "samples": self.samples,
            "stage": self.stage,
            "time/seconds": self.seconds,
            "time/samples_per_second": self.config.samples_per_iteration / (end - start),
            "time/collect": collected - start,
            "time/learn": end - collected,
            "reward/total": float(reward_sum) / steps,
            **{key: float(value) / steps for key, value in sums.items()},
            "learn/action_std": self.ppo.get_policy().output_std.mean().item(),
            "learn/learning_rate": self.ppo.learning_rate,
            "learn/entropy_weight": self.ppo.entropy_coef,
            **{f"learn/{key}": value for key, value in losses.items() if key != "symmetry"},
        }
        if self._episodes:
            returns, lengths = zip(*self._episodes, strict=True)
            record["episode/return"] = sum(returns) / len(returns)
            record["episode/seconds"] = sum(lengths) / len(lengths)
        self._end_stage(record)
        return record

    def _physics(self) -> BatchPhysics:
        knee = self.config.torque_knee
        robot = self.robot if knee is None else replace(self.robot, torque_knee=knee)
        model = build_model(robot, engine=self._now.engine)
        return BatchPhysics(model, robot, self.config.num_envs, self.config.threads)

    def _ramp(self) -> None:
        """Take the settings that the stage has by now: rewards and the learner's numbers."""
        if not self.config.stages:
            return
        self._now = self.config.in_stage(self.stage, self.samples - self._stage_began)
        self.env.set_rewards(self._now.env)
        ppo = self._now.ppo
        self.ppo.entropy_coef = ppo.entropy
        self.ppo.num_learning_epochs = ppo.epochs
        self.ppo.num_mini_batches = ppo.mini_batches
        self.ppo.desired_kl = ppo.desired_kl
        self.ppo.clip_param = ppo.clip
        self.ppo.gamma, self.ppo.lam = ppo.discount, ppo.gae_lambda
        self.ppo.value_loss_coef = ppo.value_weight
        self.ppo.max_grad_norm = ppo.max_grad_norm

    def _end_stage(self, record: dict[str, Any]) -> None:
        """Go on to the next stage if this one is over."""
        if not self.config.stages:
            return
        stage = self.config.stages[self.stage]
        passed = self.samples - self._stage_began
        over = stage.samples is not None and passed >= stage.samples
        if stage.criterion is not None:
            self._recent.append({name: record[name] for name in MEASURED if name in record})
            over = over or (passed >= stage.ramp and self._meets(stage.criterion))
        if over:
            _log.info("Stage %r ended after %.3g million samples.", stage.name, self.samples / 1e6)
            self._recent.clear()
            self.stage += 1
            self._stage_began = self.samples
            if self.stage < len(self.config.stages):
                self._enter_stage(self.stage, 0.0)

    def _meets(self, criterion: Criterion) -> bool:
        values = [record[criterion.metric] for record in self._recent if criterion.metric in record]
        return len(values) >= criterion.updates and criterion.met(sum(values[-criterion.updates :]) / criterion.updates)

    def _enter_stage(self, stage: int, samples: float) -> None:
        before = self._now
        self._now = self.config.in_stage(min(stage, len(self.config.stages) - 1), samples)
        physics = None if self._now.engine == before.engine else self._physics()
        if physics is not None or replace(self._now.env, rewards=before.env.rewards) != before.env:
            with torch.inference_mode():  # as its steps are made
                self.env.begin_stage(self._now.env, physics)
                self._returns.zero_()
                self._lengths.zero_()

    def _check_finite(self, losses: dict[str, float]) -> None:
        wrong = [f"the {name} loss is {value}" for name, value in losses.items() if not math.isfinite(value)]
        for what, network in (("actor", self.ppo.actor), ("critic", self.ppo.critic)):
            if not all(bool(torch.isfinite(weights).all()) for weights in network.parameters()):
                wrong.append(f"weights of the {what} are not finite")
        if not wrong:
            return
        if good := checkpoint.list_checkpoints(self.run):
            advice = (
                f"Its last checkpoint is from update {int(good[-1].stem)}. Continue from it in a new run with other "
                f"settings, such as a lower learning rate: symdyn train --start-from {shlex.quote(str(self.run))}"
            )
        else:
            advice = "It has no checkpoint yet. Start again with other settings, such as a lower learning rate."
        raise Diverged(f"{self.run}: training diverged in update {self.iteration + 1} ({', '.join(wrong)}). {advice}")

    def _load_learner(self, state: dict[str, Any], run: Path) -> None:
        checkpoint.check_robot(state, self.robot.name, run)
        try:
            self.ppo.load(state["ppo"], None, strict=True)
        except (KeyError, RuntimeError, ValueError) as error:
            raise FileProblem(run, f"holds a checkpoint of another configuration ({error}).") from error

    def _count_episodes(self, rewards: torch.Tensor, dones: torch.Tensor) -> None:
        self._returns = self._returns + rewards
        self._lengths = self._lengths + self.env.robot.control_dt
        ended = torch.nonzero(dones).flatten()
        if len(ended):
            self._episodes.extend(zip(self._returns[ended].tolist(), self._lengths[ended].tolist(), strict=True))
            self._returns[ended] = 0.0
            self._lengths[ended] = 0.0

    def _save(self) -> None:
        content = {
            "iteration": self.iteration,
            "stage": self.stage,
            "stage_began": self._stage_began,
            "recent": list(self._recent),
            "robot": self.robot.name,
            "seconds": self.seconds,
            "ppo": self.ppo.save(),
            "env": self.env.state_dict(),
            "torch_rng": torch.get_rng_state(),
            "returns": self._returns,
            "lengths": self._lengths,
            "episodes": [list(pair) for pair in self._episodes],
        }
        checkpoint.save(self.run, self.iteration, content, self.config.keep_every)


@contextmanager
def stop_on_signal() -> Iterator[list[int]]:
    """A list that SIGINT, SIGTERM and SIGHUP fill; a second signal interrupts at once."""
    told = False

    def note(number: int) -> None:
        nonlocal told
        if told:
            raise KeyboardInterrupt
        told = True
        _log.warning("Stopping after this update. Press Ctrl-C again to stop at once.")

    with on_stop(note) as received:
        yield received
