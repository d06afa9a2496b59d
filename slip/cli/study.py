"""``symdyn study``: the families and timing curves of a grid of models, in parallel, resumable."""

from __future__ import annotations

from collections import Counter

from slip.cli.arguments.study import StudyArguments
from slip.cli.passive_model import PassiveModelArguments
from slip.curves.cells import settings, trace_cell
from slip.curves.parallel import run_cells
from slip.curves.study import cells, summary, write
from symdyn.io.console import log_to, make_console
from symdyn.io.exit_codes import INTERRUPTED
from symdyn.io.progress import progress

TABLE = "study.csv"


def run(args: StudyArguments) -> int:
    """The command. Raises SymdynError for bad input."""
    base = PassiveModelArguments(robot=args.robot).load()
    work = cells(args.grid, base.parameters, args.select.speeds[1], args.trot, args.carry)
    console = make_console()
    log_to(console)
    try:
        with progress(console, f"{len(work)} models") as report_progress:
            outcomes = run_cells(
                trace_cell,
                work,
                args.out,
                settings(args.select.speeds[1], args.trot, args.carry),
                args.workers,
                args.retry_failed,
                report_progress,
            )
    except KeyboardInterrupt:
        console.print(f"Stopped. What is done is in {args.out}; the same command continues with the rest.")
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
