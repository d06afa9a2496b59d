"""``symdyn study``: the families and timing curves of a grid of models, in parallel, resumable."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from slip.cli.passive_model import PassiveModelArguments
from slip.curves.cells import settings, trace_cell
from slip.curves.parallel import Workers, run_cells
from slip.curves.points import Selection
from slip.curves.study import Grid, cells, summary, write
from symdyn.io.console import log_to, make_console
from symdyn.io.exit_codes import INTERRUPTED
from symdyn.io.options import RobotOption

TABLE = "study.csv"


@dataclass(frozen=True)
class StudyArguments:
    """Trace the families of passive gaits of every model of a grid, and fit the timing curves of each.

    Writes one file a model (cells/NAME.json) as soon as it is done, and the table study.csv. Stopped or killed, the
    same command goes on with what is left; a model that fails is in the table with its reason and stops no other.

    Attributes:
        grid: values to combine, as in --k 2 5 10 --ks 10 20 40 --J 0.2 2; what is not given is the base model's.
        robot: whose model is the base: go2, go1, a1, b1, solo12, anymal_b, anymal_c or hyq; the literature's (k 10,
            ks 20, J 2) if left out.
        select: which orbits the curves are fitted to. A change needs no new tracing, but for another fastest speed.
        trot: look for trot and pace, too.
        carry: carry over, from the reference parameters, families that no junction leads to: about a minute a model.
        workers: who does the work.
        retry_failed: try models again that failed before.
        out: directory of the results.
    """

    grid: Annotated[Grid, tyro.conf.arg(name="")] = field(default_factory=Grid)
    robot: RobotOption = None
    select: Annotated[Selection, tyro.conf.arg(name="")] = field(default_factory=Selection)
    trot: bool = True
    carry: bool = False
    workers: Annotated[Workers, tyro.conf.arg(name="")] = field(default_factory=Workers)
    retry_failed: bool = False
    out: Path = Path("out/study")


def run(arguments: Sequence[str]) -> int:
    """The command. Raises SymdynError for bad input."""
    args = tyro.cli(StudyArguments, args=list(arguments), prog="symdyn study")
    base = PassiveModelArguments(robot=args.robot).load()
    work = cells(args.grid, base.parameters, args.select.speeds[1], args.trot, args.carry)
    console = make_console()
    log_to(console)
    columns = TextColumn("models"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TimeRemainingColumn()
    try:
        with Progress(*columns, console=console, disable=not console.is_terminal) as progress:
            task = progress.add_task("models", total=len(work))
            outcomes = run_cells(
                trace_cell,
                work,
                args.out,
                settings(args.select.speeds[1], args.trot, args.carry),
                args.workers,
                args.retry_failed,
                lambda done, total: progress.update(task, completed=done, total=total),
            )
    except KeyboardInterrupt:
        console.print(f"Stopped. What is done is in {args.out}; the same command goes on with what is left.")
        return INTERRUPTED
    rows = summary(outcomes, args.select)
    write(args.out / TABLE, rows)
    failed = Counter(str(row["reason"]) for row in rows if row.get("reason"))
    console.print(
        f"{len(rows)} models of {base.name}, {sum(failed.values())} without curves. Wrote {args.out / TABLE}."
    )
    for reason, count in failed.most_common(5):
        console.print(f"  {count} times: {reason}", markup=False)
    return 0
