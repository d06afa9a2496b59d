"""Which of a policy's trials calibrate the curves: the cheapest timing of those that tracked the command.

A case is a gait at a speed (forward and backward apart, speeds in bins). Trials that repeat each
other (the same timing in the same case, other seeds) are averaged, and count as fallen if one of them fell. Of a case's
timings those are admitted that did not fall, have a cost, track within the limit and have enough weight (from
``symdyn evaluate --sweep-timing``: enough strides in the commanded gait, so that the cost is that gait's); the one
with the lowest cost of transport is the case's point, with its weight. Nothing is interpolated: a point is a timing
that was really run, and where a better one lies beyond those that were tried, the choice lies at their edge. How many
do is reported, for then the sweep and not the cost has chosen.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from slip.curves.fit import TimingPoints
from slip.curves.settings import ChoiceConfig
from symdyn.analysis.trials import Trial
from symdyn.errors import InvalidValue
from symdyn.gait.timing import GRAVITY

NO_GAIT = "unnamed"
"""What trials without a gait are called."""


@dataclass(frozen=True)
class Choice:
    """The points of a calibration and what became of the rest.

    Attributes:
        points: one a case that had an admissible timing; the group is the gait.
        leg_length: that made them non-dimensional, m.
        trials: rows of the table.
        fell: rows that fell.
        cases: gaits times speeds.
        dropped: cases without an admissible timing, as ``GAIT at V m/s``.
        period_at_edge: cases whose choice has the shortest or longest T of those tried, where several were.
        duty_at_edge: the same of beta.
    """

    points: TimingPoints
    leg_length: float
    trials: int
    fell: int
    cases: int
    dropped: tuple[str, ...]
    period_at_edge: int
    duty_at_edge: int

    def as_dict(self) -> dict[str, Any]:
        """Without the points, for JSON."""
        return {name: value for name, value in asdict(self).items() if name != "points"}


@dataclass(frozen=True)
class _Timing:
    """Trials that repeat each other."""

    v: float
    T: float
    beta: float
    cost: float | None
    error: float | None
    weight: float
    fell: bool


def choose(trials: Sequence[Trial], leg_length: float, config: ChoiceConfig | None = None) -> Choice:
    """The cheapest admissible timing of every case.

    Args:
        trials: of one policy.
        leg_length: m, where the table does not say.
        config: what is admissible.

    Raises:
        InvalidValue: if the trials are of several leg lengths, or in no case a timing was admissible.
    """
    config = config or ChoiceConfig()
    length = _leg_length(trials, leg_length)
    cases: dict[tuple[str, int], list[Trial]] = defaultdict(list)
    for trial in trials:
        cases[trial.gait or NO_GAIT, round(trial.v / config.speed_bin)].append(trial)
    chosen: list[tuple[str, _Timing]] = []
    dropped, period_at_edge, duty_at_edge = [], 0, 0
    for (gait, _), rows in sorted(cases.items()):
        timings = _timings(rows)
        admissible = [timing for timing in timings if _admissible(timing, config)]
        if not admissible:
            dropped.append(f"{gait} at {np.mean([row.v for row in rows]):g} m/s")
            continue
        best = min(admissible, key=lambda timing: (timing.cost, timing.T, timing.beta))
        chosen.append((gait, best))
        period_at_edge += _at_edge(best.T, [timing.T for timing in timings])
        duty_at_edge += _at_edge(best.beta, [timing.beta for timing in timings])
    if not chosen:
        allowed = (
            f"at least one that did not fall, tracked within {config.tracking_limit:g} m/s and has a weight of at "
            f"least {config.min_weight:g}; use a better policy or weaker limits"
        )
        raise InvalidValue("The number of admissible trials", f"0 of {len(trials)}", allowed)
    table = np.array([[t.v, t.T, t.beta, t.weight] for _, t in chosen])
    points = TimingPoints(
        group=tuple(gait for gait, _ in chosen),
        v_star=np.abs(table[:, 0]) / math.sqrt(GRAVITY * length),
        period_star=table[:, 1] / math.sqrt(length / GRAVITY),
        duty=table[:, 2],
        weight=table[:, 3],
    )
    fell = sum(trial.fell for trial in trials)
    return Choice(points, length, len(trials), fell, len(cases), tuple(dropped), period_at_edge, duty_at_edge)


def _leg_length(trials: Sequence[Trial], otherwise: float) -> float:
    lengths = {trial.leg_length for trial in trials} - {None}
    if len(lengths) > 1:
        raise InvalidValue("The column leg_length of the trials", sorted(filter(None, lengths)), "the same in all rows")
    return lengths.pop() or otherwise if lengths else otherwise


def _timings(rows: Sequence[Trial]) -> list[_Timing]:
    repeats: dict[tuple[float, float, float], list[Trial]] = defaultdict(list)
    for row in rows:
        repeats[row.v, row.T, row.beta].append(row)
    return [
        _Timing(
            *key,
            cost=_mean([row.cost_of_transport for row in same]),
            error=_mean([row.tracking_error for row in same]),
            weight=float(np.mean([row.weight for row in same])),
            fell=any(row.fell for row in same),
        )
        for key, same in repeats.items()
    ]


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if len(known) == len(values) else None


def _admissible(timing: _Timing, config: ChoiceConfig) -> bool:
    tracked = timing.error is not None and timing.error <= config.tracking_limit
    counts = timing.weight > 0.0 and timing.weight >= config.min_weight
    return tracked and counts and timing.cost is not None and not timing.fell


def _at_edge(value: float, tried: Sequence[float]) -> bool:
    return min(tried) < max(tried) and value in (min(tried), max(tried))
