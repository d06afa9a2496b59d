"""One measured figure and what it should be."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from statistics import median

import numpy as np


@dataclass(frozen=True)
class Result:
    """A figure.

    Attributes:
        name: what was measured.
        value: the figure.
        unit: of the figure; empty for a ratio.
        at_least: goal, or None.
        at_most: goal, or None.
        details: absolute figures behind a ratio.
    """

    name: str
    value: float
    unit: str = ""
    at_least: float | None = None
    at_most: float | None = None
    details: dict[str, float] = field(default_factory=dict)

    @property
    def goal_text(self) -> str:
        """The goal in words."""
        if self.at_least is not None:
            return f">= {self.at_least:g}"
        return "" if self.at_most is None else f"<= {self.at_most:g}"

    @property
    def verdict(self) -> str:
        """Whether the goal was met: yes, no, or nothing where there is none."""
        if self.at_least is not None:
            return "yes" if self.value >= self.at_least else "no"
        if self.at_most is not None:
            return "yes" if self.value <= self.at_most else "no"
        return ""


def in_turns(jobs: Sequence[Callable[[], object]], rounds: int) -> list[float]:
    """Median time of each job, s, each timed once a round in turn, after a round that does not count."""
    times: list[list[float]] = [[] for _ in jobs]
    for round_ in range(rounds + 1):
        for job, found in zip(jobs, times, strict=True):
            start = time.perf_counter()
            job()
            if round_:
                found.append(time.perf_counter() - start)
    return [median(found) for found in times]


def spread(values: Sequence[float]) -> dict[str, float]:
    """Median, 99th percentile and longest of values, and how many there are."""
    p50, p99 = np.percentile(values, (50, 99)).tolist()
    return {"p50": p50, "p99": p99, "max": float(max(values)), "n": float(len(values))}
