"""What every command shares about talking to a person: one console, one way to log."""

from __future__ import annotations

import logging

from rich.console import Console
from rich.logging import RichHandler
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn


def make_console() -> Console:
    """A console on standard output."""
    return Console(highlight=False)


def frames_progress(console: Console) -> Progress:
    """A bar for the frames of a moving picture, which goes away when it is done."""
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    return Progress(*columns, console=console, transient=True)


def log_to(console: Console, level: int = logging.INFO) -> None:
    """Send the log of symdyn's packages to a console, and of others only warnings."""
    handler = RichHandler(console=console, show_path=False, show_time=False)
    logging.basicConfig(level=logging.WARNING, handlers=[handler], format="%(message)s", force=True)
    for package in ("symdyn", "slip", "rl", "hardware"):
        logging.getLogger(package).setLevel(level)
