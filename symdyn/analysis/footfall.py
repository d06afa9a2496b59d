"""From contact sequences to strides: when each leg lands within a stride, and which gait that is.

Strides are counted by the commanded clock, whatever the legs do. The clock is that of a leg with offset zero, counted
from its commanded touchdown, so that it keeps its meaning when the duty factor changes with the command. Every stride
must begin at the same reading of this clock, and the reading is free: it is put where the fewest legs land. A cut in
the middle of the largest gap between the *commanded* touchdowns would do while all goes well, but a common lag, or
another gait than the commanded one (a bound for a rotary gallop), brings touchdowns right onto it, where they fall into
one stride or the next by chance.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from symdyn.analysis.recording import Floats, Recording
from symdyn.errors import UnknownName
from symdyn.gait.library import nearest, wrap
from symdyn.gait.phase import touchdown_phase
from symdyn.robot.legs import LEGS

Bools = NDArray[np.bool_]

SHORTEST_S = 0.015
"""s; contact or flight shorter than this is chatter of foot or sensor, not a step: the shortest stance that
symdyn.gait.timing asks of the Go2 up to 2 m/s is 54 ms (duty factor 0.28 of 0.19 s), the shortest swing 138 ms."""

NO_GAIT = "none"
"""Name of what a stride shows in which a leg does not land exactly once."""

_JUMP = 0.1
"""Strides; the clock moving this much more or less than dt / T in one sample has been set, not run. A clock that is
written down at 200 Hz and ticks at 50 moves by less, and so does it when the command steps by up to 0.5 m/s without
change of direction: the stride about such a step is a little longer or shorter."""

_NEIGHBOURHOOD = 0.03
"""Strides; width over which touchdowns count as near a cut."""


def debounce(contact: Bools, dt: float, shortest_s: float = SHORTEST_S) -> Bools:
    """Remove contacts and flights that are too short to be any, the shortest first.

    What is removed merges with what was before and after it. A state that reaches the first or last sample is left as
    it is: nobody knows how long it lasts. Sampled at intervals of ``shortest_s`` or more, nothing is ever too short.

    Args:
        contact: (S, 4) whether a foot bears load.
        dt: time between samples, s.
        shortest_s: s.

    Returns:
        (S, 4), a copy.
    """
    clean = np.array(contact, dtype=np.bool_)
    for leg in range(clean.shape[1]):
        _debounce_in_place(clean[:, leg], shortest_s / dt)
    return clean


def _debounce_in_place(state: Bools, shortest: float) -> None:
    edges = np.flatnonzero(np.diff(state)) + 1  # where the state changes; entry k of the runs is edges[k]..edges[k + 1]
    lengths = np.diff(edges)
    while len(lengths) and lengths.min() < shortest - 1e-9:
        k = int(np.argmin(lengths))
        state[edges[k] : edges[k + 1]] ^= True
        edges = np.delete(edges, (k, k + 1))
        lengths = np.diff(edges)


def touchdowns(contact: Bools, leg: str) -> NDArray[np.intp]:
    """Samples at which a leg lands: in contact, and not in the sample before.

    Args:
        contact: (S, 4).
        leg: one of LEGS.

    Returns:
        (m,) indices. The first sample is none, as nobody knows what was before.

    Raises:
        UnknownName: if there is no such leg.
    """
    if leg not in LEGS:
        raise UnknownName("leg", leg, LEGS)
    return np.flatnonzero(_landed(contact)[:, LEGS.index(leg)])


def _landed(contact: Bools) -> Bools:
    landed = np.zeros_like(contact, dtype=np.bool_)
    landed[1:] = contact[1:] & ~contact[:-1]
    return landed


@dataclass(frozen=True)
class Strides:
    """n whole strides of the commanded clock. Phases are fractions of a stride, legs in the order of LEGS.

    Attributes:
        start: (n,) first sample.
        stop: (n,) sample after the last.
        delays: (n, 4) stride phase phi at which each leg lands, in [0, 1); nan unless it lands exactly once.
        commanded_delays: (n, 4) stride phase at which each leg should land, in [0, 1).
        duty: (n, 4) share of the stride in contact.
        commanded_offsets: (n, 4) theta at the start of the stride.
        commanded_duty: (n,) beta at the start of the stride.
        gait: n names: the library's gait nearest to what the legs did, or :data:`NO_GAIT`.
    """

    start: NDArray[np.intp]
    stop: NDArray[np.intp]
    delays: Floats
    commanded_delays: Floats
    duty: Floats
    commanded_offsets: Floats
    commanded_duty: Floats
    gait: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.start)

    @property
    def complete(self) -> Bools:
        """(n,) whether every leg lands exactly once."""
        return np.all(np.isfinite(self.delays), axis=1)


def cut_strides(recording: Recording, shortest_s: float = SHORTEST_S, time_reversal: bool = True) -> Strides:
    """The whole strides of a recording.

    A touchdown lies between the sample that shows it and the one before, and is taken to be half-way. Where the offsets
    change or the clock is set (a step of the commanded velocity), counting starts anew.

    Args:
        recording: any.
        shortest_s: for :func:`debounce`, s.
        time_reversal: whether the leg phase runs backwards with the robot (symdyn.gait.phase); False for that ablation.
    """
    contact = debounce(recording.contact, recording.dt, shortest_s)
    landed = _landed(contact)
    step = recording.dt / recording.period
    lands_at = recording.stride_phase - 0.5 * step  # phi of a touchdown that this sample is the first to show
    zero_leg = touchdown_phase(recording.duty, recording.velocity_command[:, 0], time_reversal)
    commanded = np.mod(zero_leg[:, None] - recording.offsets, 1.0)

    spans = []
    for segment in _steady(recording, recording.stride_phase - zero_leg):
        clock = np.unwrap((recording.stride_phase - zero_leg)[segment], period=1.0)
        when = np.repeat((clock - 0.5 * step[segment])[:, None], len(LEGS), axis=1)[landed[segment]]
        begins = np.flatnonzero(np.diff(np.floor(clock - _quietest(when)))) + 1 + segment.start
        spans.extend(pairwise(begins.tolist()))

    start, stop = np.array(spans, dtype=np.intp).reshape(-1, 2).T
    delays = np.array([_single(landed[a:b], lands_at[a:b]) for a, b in spans]).reshape(-1, len(LEGS))
    duty = np.array([contact[a:b].mean(axis=0) for a, b in spans]).reshape(-1, len(LEGS))
    return Strides(
        start=start,
        stop=stop,
        delays=delays,
        commanded_delays=commanded[start],
        duty=duty,
        commanded_offsets=recording.offsets[start],
        commanded_duty=recording.duty[start],
        gait=_names(delays),
    )


def _steady(recording: Recording, clock: Floats) -> Iterator[slice]:
    """Stretches in which the offsets stay and the clock, (S,), runs."""
    jumps = np.abs(wrap(np.diff(clock) - recording.dt / recording.period[:-1])) > _JUMP
    changes = (np.diff(recording.offsets, axis=0) != 0.0).any(axis=1)
    edges = [0, *(np.flatnonzero(jumps | changes) + 1).tolist(), len(clock)]
    return (slice(first, last) for first, last in pairwise(edges) if last > first)


def _quietest(phases: Floats) -> float:
    """The phase with the fewest of ``phases``, (m,), in its neighbourhood; in [0, 1)."""
    candidates = np.arange(256) / 256
    angle = 2.0 * np.pi * (candidates[:, None] - phases)
    concentration = 1.0 / (2.0 * np.pi * _NEIGHBOURHOOD) ** 2
    return float(candidates[np.argmin(np.exp(concentration * (np.cos(angle) - 1.0)).sum(axis=1))])


def _single(landed: Bools, lands_at: Floats) -> Floats:
    """Phase of each leg's only touchdown, (4,), or nan. ``landed``: (s, 4); ``lands_at``: (s,)."""
    phases = np.mod(lands_at[np.argmax(landed, axis=0)], 1.0)
    return np.where(landed.sum(axis=0) == 1, phases, np.nan)


def _names(delays: Floats) -> tuple[str, ...]:
    complete = np.all(np.isfinite(delays), axis=1)
    # the touchdown delay of a leg is minus its offset, whichever way the leg phase runs
    found = iter(nearest(-delays[complete])) if complete.any() else iter(())
    return tuple(next(found) if whole else NO_GAIT for whole in complete)
