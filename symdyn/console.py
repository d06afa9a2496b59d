"""What every command shares about talking to a person: one console, one way to log."""

from __future__ import annotations

import logging

from rich.console import Console
from rich.logging import RichHandler


def make_console() -> Console:
    """A console on standard output."""
    return Console(highlight=False)


def log_to(console: Console, level: int = logging.INFO) -> None:
    """Send the log of symdyn's packages to a console, and of others only warnings."""
    handler = RichHandler(console=console, show_path=False, show_time=False)
    logging.basicConfig(level=logging.WARNING, handlers=[handler], format="%(message)s", force=True)
    for package in ("symdyn", "slip", "rl"):
        logging.getLogger(package).setLevel(level)
