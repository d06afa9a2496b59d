"""The experiments by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from rl.experiments import (
    ablation,
    cot,
    gaits,
    learning,
    mixtures,
    reversal,
    robustness,
    second_model,
    steering,
    terrain,
    transitions,
    velocity,
)
from rl.experiments.result import Result, Subject
from symdyn.errors import UnknownName

EXPERIMENTS: Mapping[str, Callable[[Subject], Result]] = MappingProxyType(
    {
        "velocity": velocity.run,
        "gaits": gaits.run,
        "transitions": transitions.run,
        "cot": cot.run,
        "ablation": ablation.run,
        "robustness": robustness.run,
        "steering": steering.run,
        "second-model": second_model.run,
        "terrain": terrain.run,
        "reversal": reversal.run,
        "mixtures": mixtures.run,
        "learning": learning.run,
    }
)

ALL = "all"
_NOT_IN_ALL = ("learning",)
"""Needs training runs, which nobody has who has not trained."""


def chosen(names: tuple[str, ...]) -> tuple[str, ...]:
    """The experiments that were asked for, each once, in the order of the catalogue.

    Raises:
        UnknownName: for a name that is none, nor ``all``.
    """
    for name in names:
        if name != ALL and name not in EXPERIMENTS:
            raise UnknownName("experiment", name, (*EXPERIMENTS, ALL))
    return tuple(name for name in EXPERIMENTS if name in names or (ALL in names and name not in _NOT_IN_ALL))
