"""What a person sees while several seeds train: a row for each, or one plain line each now and then in a file."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence

from rich.console import Console
from rich.table import Table

from rl.learning import display
from rl.learning.config import TrainConfig
from rl.learning.seeds import SeedRun

_LINE_EVERY_S = 60.0


class SeedsDisplay(display.LiveDisplay):
    """A context manager whose :meth:`update` is called now and then.

    Args:
        console: where to show it.
        config: of the runs.
        runs: all of them.
    """

    def __init__(self, console: Console, config: TrainConfig, runs: Sequence[SeedRun]) -> None:
        super().__init__(console, per_second=1)
        self._config = config
        self._runs = runs
        self._last_lines = -math.inf

    def update(self, working: Sequence[SeedRun]) -> None:
        """Show how far the runs are; ``working`` are those at work."""
        rows = [self._row(run, run in working) for run in self._runs]
        if self._live is not None:
            table = Table("seed", "state", "updates", "left", "stage", "reward", "m/s off", box=None, padding=(0, 1))
            for row in rows:
                table.add_row(*row)
            self._live.update(table)
        elif time.monotonic() - self._last_lines >= _LINE_EVERY_S:
            self._last_lines = time.monotonic()
            for run, row in zip(self._runs, rows, strict=True):
                if run in working and row[2]:
                    seed, _, updates, left, stage, reward, error = row
                    line = (
                        f"seed {seed}: update {updates}, {left} left, {stage}, reward {reward}, speed error {error} m/s"
                    )
                    self._console.print(line, soft_wrap=True, highlight=False)

    def _row(self, run: SeedRun, works: bool) -> tuple[str, ...]:
        record = run.last_record()
        state = "trains" if works else "done" if run.finished(self._config) else "waits"
        if record is None:
            return str(run.seed), state, "", "", "", "", ""
        total = self._config.total_iterations
        left = (total - record["iteration"]) * self._config.samples_per_iteration / record["time/samples_per_second"]
        if works and record["iteration"] >= total:
            state = "validates"
        stages = self._config.stages
        return (
            str(run.seed),
            state,
            f"{record['iteration']}/{total}",
            display.duration(left),
            stages[record["stage"]].name if stages else "",
            f"{record['reward/total']:.3f}",
            f"{record['task/x_velocity_error']:.2f}",
        )
