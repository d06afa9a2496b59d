"""How often messages of a channel arrive: two robots on one wire give twice as many as one."""

from __future__ import annotations

import statistics
from collections import deque

from hardware.wire.link import Received

_TICKS = 40
"""Over which the rate is taken: 0.2 s of the deployer's ticks."""


class MessageRate:
    """The median over ticks of messages per second.

    Messages that were held up arrive all at once, in one tick; the median leaves such a tick out. A second sender adds
    messages to every tick.
    """

    def __init__(self) -> None:
        self._before: tuple[float, int] | None = None
        self._rates: deque[float] = deque(maxlen=_TICKS)

    def update(self, now: float, newest: Received) -> float | None:
        """The rate, 1/s, or None until there are enough ticks to tell.

        Args:
            now: time of the tick, s.
            newest: the newest message of the channel at that time.
        """
        before, self._before = self._before, (now, newest.number)
        if before is None or not now > before[0] or newest.number < before[1]:
            self._rates.clear()
            return None
        self._rates.append((newest.number - before[1]) / (now - before[0]))
        return statistics.median(self._rates) if len(self._rates) == _TICKS else None
