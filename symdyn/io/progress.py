"""How long work shows how far it is: a bar on a terminal of any width, a line at each quarter elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Column

Report = Callable[[int, int], None]
"""Called with what is done and what there is to do, of any unit."""

_WORDS, _BAR = 28, 16
_PARTS = 4


@contextmanager
def progress(console: Console, what: str) -> Iterator[Report]:
    """Show the progress of the block.

    Args:
        console: on which to show it.
        what: is being done, in a few words; cut where a narrow terminal has no room.

    Yields:
        A function to call as the work goes on.
    """
    if not console.is_terminal:
        yield _lines(console, what)
        return
    words = Column(no_wrap=True, overflow="ellipsis", max_width=_WORDS)
    columns = (
        TextColumn("{task.description}", table_column=words),
        BarColumn(bar_width=_BAR),
        TextColumn("{task.percentage:>3.0f}%", table_column=Column(no_wrap=True)),
        TimeRemainingColumn(compact=True, table_column=Column(no_wrap=True)),
    )
    with Progress(*columns, console=console, transient=True) as shown:
        task = shown.add_task(what, total=None)
        yield lambda done, total: shown.update(task, completed=done, total=total)


def _lines(console: Console, what: str) -> Report:
    """A line as the work begins, and one at each quarter: enough to see in a file or a log that it goes on."""
    told = -1

    def report(done: int, total: int) -> None:
        nonlocal told
        part = _PARTS * done // total if total else 0
        if part > told:
            told = part
            console.print(f"{what}: {100 * part // _PARTS}%", soft_wrap=True, markup=False)

    return report
