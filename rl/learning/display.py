"""What a person sees while training runs: two lines and a bar, or one plain line now and then in a file."""

from __future__ import annotations

import math
import time
from types import TracebackType
from typing import Any, Self

from rich.console import Console, Group
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from rl.learning.config import TrainConfig

_LINE_EVERY_S = 30.0
_RATE_OVER = 20
"""Updates that the rate, and with it the time left, is estimated from."""


class LiveDisplay:
    """A context manager that redraws its place on a terminal; elsewhere ``_live`` is None.

    Args:
        console: where to show something.
        per_second: how often it is redrawn.
    """

    def __init__(self, console: Console, per_second: float) -> None:
        self._console = console
        self._live = (
            Live(console=console, refresh_per_second=per_second, transient=False) if console.is_terminal else None
        )

    def __enter__(self) -> Self:
        if self._live is not None:
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._live is not None:
            self._live.stop()


class TrainingDisplay(LiveDisplay):
    """A context manager whose :meth:`update` is called after every update of the policy.

    Args:
        console: where to show it.
        config: of the run.
    """

    def __init__(self, console: Console, config: TrainConfig) -> None:
        super().__init__(console, per_second=4)
        self._config = config
        self._last_line = -math.inf
        self._rates: list[float] = []

    def update(self, record: dict[str, Any]) -> None:
        """Show one update's record, as it was logged."""
        self._rates = [*self._rates, record["time/samples_per_second"]][-_RATE_OVER:]
        total = self._config.total_iterations * self._config.samples_per_iteration
        left = (total - record["samples"]) * sum(1.0 / rate for rate in self._rates) / len(self._rates)
        progress = (
            f"update {record['iteration']}/{self._config.total_iterations}",
            f"{record['samples'] / 1e6:.2f}M samples",
            f"{record['time/samples_per_second']:.0f}/s",
            f"{duration(left)} left",
        )
        if self._live is not None:
            bar = Table.grid(padding=(0, 1), expand=True)
            bar.add_column(ratio=1)
            bar.add_column(no_wrap=True)
            bar.add_row(ProgressBar(total=total, completed=record["samples"]), stage(self._config, record))
            lines = (Text(", ".join(part)) for part in (progress, figures(record)))
            self._live.update(Group(bar, *lines))
            return
        now = time.monotonic()
        last = record["iteration"] == self._config.total_iterations
        if now - self._last_line >= _LINE_EVERY_S or last:
            self._last_line = now
            parts = (*progress, stage(self._config, record), *figures(record))
            self._console.print(", ".join(part for part in parts if part), soft_wrap=True, highlight=False)


def stage(config: TrainConfig, record: dict[str, Any]) -> str:
    """Which stage the update was of, and what ends it."""
    if not config.stages:
        return ""
    number = record["stage"]
    its = config.stages[number]
    until = f", until {its.criterion}" if its.criterion is not None else ""
    return f"stage {number + 1}/{len(config.stages)} {its.name}{until}"


def figures(record: dict[str, Any]) -> tuple[str, ...]:
    """What tells whether it learns."""
    return (
        f"reward {record['reward/total']:.3f}",
        f"speed error {record['task/x_velocity_error']:.2f} m/s",
        f"falls {record['task/fell_per_s'] * 60.0:.2g}/min",
        f"noise {record['learn/action_std']:.2f}",
    )


def duration(seconds: float) -> str:
    """A time as a person says it."""
    minutes = math.ceil(seconds / 60.0)
    if minutes < 60:
        return f"{minutes} min"
    return f"{minutes // 60} h {minutes % 60:02d} min"
