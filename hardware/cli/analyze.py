"""``symdyn analyze``: a log of the robot as the paper's hardware figures, with metrics."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from hardware.cli.arguments.analyze import AnalyzeArguments
from hardware.logs import report as log_report
from hardware.logs.contents import read_contents
from hardware.logs.markdown import segment_rows, struck
from symdyn.errors import InvalidValue
from symdyn.io.console import log_to, make_console, print_written
from symdyn.io.files import writable_directory
from symdyn.io.progress import progress
from symdyn.robot.robot_file import DEFAULT_ROBOT, get_robot

_COLUMNS = {
    "gc_stance": "GC stance",
    "lag_s": "late, s",
    "speed": "speed",
    "settling_time": "settles, s",
    "cot": "CoT",
}
"""Of the table on the terminal, by the keys of hardware.logs.metrics.KEYS."""


def run(args: AnalyzeArguments) -> int:
    """The command. Raises SymdynError for bad input."""
    if not 0.0 <= args.settle < math.inf:
        raise InvalidValue("--settle", args.settle, "a time >= 0, s")
    console = make_console()
    log_to(console)
    # lcm-logger numbers its logs by a suffix, which must stay
    out = args.out or Path("out") / args.log.name.removesuffix(".lcmlog")
    with progress(console, "reading") as report_progress:
        log = read_contents(args.log, report_progress)
    its = DEFAULT_ROBOT if log.session is None else log.session.robot
    robot = get_robot(args.robot or its)
    writable_directory(out)
    analysis = log_report.analyse(log, robot, args.settle, args.contact)
    written = log_report.write(analysis, out)
    _show(console, analysis.metrics)
    print_written(console, f"Wrote {written}, {log_report.METRICS} and {len(analysis.figures)} figures. Look first at:")
    print_written(console, f"  {out / next(iter(analysis.figures))}" if analysis.figures else f"  {written}")
    return 0


def _show(console: Console, metrics: dict[str, Any]) -> None:
    for problem in metrics["problems"]:
        console.print(problem, style="yellow")
    for time, fault in struck(metrics):
        console.print(f"{time:.2f} s: {fault}", style="red")
    view = "truth" if any(segment["truth"] for segment in metrics["segments"]) else "robot"
    rows = segment_rows(metrics, view, tuple(_COLUMNS))
    if not rows:
        return
    known = "as they were" if view == "truth" else "as the robot took them to be"
    table = Table(box=SIMPLE_HEAD, caption=f"Contacts and velocity {known}.", caption_justify="left")
    table.padding, table.pad_edge = (0, 1, 0, 0), False
    table.add_column("gait")
    for heading in ("m/s", "from, s", *_COLUMNS.values()):
        table.add_column(heading, justify="right", no_wrap=True)
    for row in rows:
        table.add_row(*row)
    console.print(table)
