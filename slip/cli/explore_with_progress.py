"""Exploring with a display of what is going on."""

from __future__ import annotations

from rich.console import Console

from slip.families.branch import Diagram
from slip.families.cache import explored, progress_line
from slip.families.explore import ExploreConfig
from slip.model.parameters import SlipParameters


def explore_with_progress(
    console: Console, parameters: SlipParameters, config: ExploreConfig | None = None, cache: bool = True
) -> Diagram:
    """:func:`slip.families.cache.explored`, with a line on the console that says what is being traced."""
    with console.status("Looking for the families of passive gaits") as status:
        return explored(
            parameters,
            config,
            cache,
            lambda what, count: status.update(progress_line(what, count)),
        )
