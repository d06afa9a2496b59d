"""What an experiment is given, and what it gives back."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from matplotlib.figure import Figure

from rl.judging.simulate import Build, Episode, Script, run_grouped
from rl.judging.target import Target
from rl.physics.model import build_model
from rl.physics.terrain import Terrain
from symdyn.policy.file import Policy

K = TypeVar("K")


@dataclass(frozen=True)
class Subject:
    """The policy on trial, and how thoroughly it is tried.

    Attributes:
        policy: to be judged.
        path: its file.
        seeds: of everything random; each is an initial stride phase, and the first decides random sequences and ground.
        watch: called with what is done and what there is to do, of any unit.
        runs: directory of the policies of the ablation, ``VARIANT-SEED/policy.onnx``.
        learning: training runs whose checkpoints show how learning went.
    """

    policy: Policy
    path: Path
    seeds: tuple[int, ...]
    watch: Callable[[int, int], None] = lambda done, total: None
    runs: Path = Path("runs/ablation")
    learning: tuple[Path, ...] = ()

    @property
    def time_reversal(self) -> bool:
        """Whether the policy's leg phases run backwards with the robot."""
        return self.policy.metadata.time_reversal

    def simulate(
        self, groups: Mapping[K, Sequence[Script]], terrain: Terrain | None = None, build: Build = build_model
    ) -> dict[K, list[Episode]]:
        """Run groups of scripts with the policy: :func:`rl.judging.simulate.run_grouped`."""
        return run_grouped(self.policy, groups, self.watch, terrain, build)


@dataclass(frozen=True)
class Result:
    """An experiment's outcome.

    Attributes:
        name: of the experiment.
        title: what it asks.
        protocol: what was run, in sentences.
        metrics: every number, for ``metrics.json``.
        targets: those that matter.
        figures: file name to figure and caption.
        remarks: what a reader must know to understand the numbers, a sentence each.
    """

    name: str
    title: str
    protocol: str
    metrics: dict[str, Any]
    targets: tuple[Target, ...] = ()
    figures: Mapping[str, tuple[Figure, str]] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
