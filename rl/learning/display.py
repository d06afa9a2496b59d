"""What a person sees while training runs: a bar with the figures that matter, or a line now and then in a log file."""

from __future__ import annotations

import time
from types import TracebackType
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

_LINE_EVERY_S = 30.0


class TrainingDisplay:
    """A context manager whose :meth:`update` is called after every update of the policy.

    Args:
        console: where to show it.
        done: updates already done.
        total: updates in all.
    """

    def __init__(self, console: Console, done: int, total: int) -> None:
        self._console = console
        self._total = total
        self._last_line = -_LINE_EVERY_S
        self._progress = Progress(
            TextColumn("update"),
            MofNCompleteColumn(),
            BarColumn(),
            TimeElapsedColumn(),
            TextColumn("left"),
            TimeRemainingColumn(),
            TextColumn("{task.fields[figures]}"),
            console=console,
            disable=not console.is_terminal,
        )
        self._task = self._progress.add_task("train", total=total, completed=done, figures="")

    def __enter__(self) -> TrainingDisplay:
        self._progress.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._progress.stop()

    def update(self, record: dict[str, Any]) -> None:
        """Show one update's record, as it was logged."""
        figures = describe(record)
        self._progress.update(self._task, completed=record["iteration"], figures=figures)
        now = time.monotonic()
        if self._progress.disable and (now - self._last_line >= _LINE_EVERY_S or record["iteration"] == self._total):
            self._last_line = now
            self._console.print(f"update {record['iteration']}/{self._total}: {figures}", soft_wrap=True)


def describe(record: dict[str, Any]) -> str:
    """The figures of an update that tell whether it learns, on one line."""
    parts = [
        f"{record['samples'] / 1e6:.2f}M samples",
        f"{record['time/samples_per_second']:.0f}/s",
        f"reward {record['reward/total']:.3f}",
        f"speed error {record['task/x_velocity_error']:.2f} m/s",
        f"noise {record['learn/action_std']:.2f}",
    ]
    if "episode/seconds" in record:
        parts.append(f"episodes last {record['episode/seconds']:.1f} s")
    return ", ".join(parts)
