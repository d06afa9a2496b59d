"""``python -m benchmarks``: run every benchmark, print a table, write JSON.

Absolute times on a shared machine wander by a factor of two; what is compared is therefore timed in turns within one
run, and the ratio of the medians is what counts.
"""

from __future__ import annotations

from rl.physics.threads import wait_passively

wait_passively()  # before torch

from collections.abc import Callable  # noqa: E402
from dataclasses import asdict, dataclass  # noqa: E402
from pathlib import Path  # noqa: E402
from platform import processor, python_version  # noqa: E402

import tyro  # noqa: E402
from rich.table import Table  # noqa: E402

from benchmarks import environment, robot, slip, startup, training  # noqa: E402
from benchmarks.result import Result  # noqa: E402
from symdyn.io.console import make_console  # noqa: E402
from symdyn.io.files import write_json  # noqa: E402

PARTS: dict[str, Callable[[], list[Result]]] = {
    "environment": environment.measure,
    "training": training.measure,
    "startup": startup.measure,
    "slip": slip.measure,
    "robot": robot.measure,
}


@dataclass(frozen=True)
class Arguments:
    """Measure speed and memory. Takes about four minutes on two cores; run nothing beside it.

    Attributes:
        out: JSON file of the results.
        only: parts to run; all if left out.
    """

    out: Path = Path("out/bench.json")
    only: tuple[str, ...] = ()


def main() -> None:
    """Run the benchmarks."""
    import os

    args = tyro.cli(Arguments, prog="python -m benchmarks")
    console = make_console()
    table = Table("what", "measured", "goal", "met", box=None, padding=(0, 2, 0, 0))
    results = []
    for name in args.only or PARTS:
        console.print(f"{name} ...")
        results += PARTS[name]()
    for result in results:
        table.add_row(result.name, f"{result.value:.3g} {result.unit}", result.goal_text, result.verdict)
    console.print(table)
    machine = {"processors": os.cpu_count(), "processor": processor(), "python": python_version()}
    write_json(args.out, {"machine": machine, "results": [asdict(r) | {"verdict": r.verdict} for r in results]})
    console.print(f"Wrote {args.out}.")


main()
