"""``symdyn train --seeds``: several runs that differ in their seed, and the spread of what they reach."""

from __future__ import annotations

import statistics
from pathlib import Path

from rich.console import Console
from rich.table import Table

from rl.cli.arguments.train import TrainArguments
from rl.learning import config_file, run_dir, run_lock, seeds
from rl.learning.seeds_display import SeedsDisplay
from symdyn.errors import InvalidValue
from symdyn.io.console import print_command
from symdyn.io.exit_codes import FAILED, INTERRUPTED
from symdyn.io.files import write_json

_COLUMNS = {
    "gc_stance": ("GC stance", "{:.3f}"),
    "identity": ("identity", "{:.2f}"),
    "speed_error": ("speed error, m/s", "{:.2f}"),
    "yaw_error": ("yaw error, rad/s", "{:.3f}"),
    "lateral_error": ("lateral error, m/s", "{:.2f}"),
    "fell": ("fell", "{:.1%}"),
    "samples_millions": ("million samples", "{:.1f}"),
    "minutes": ("minutes", "{:.0f}"),
}
_TOLD_OF_A_FAILURE = 3


def train_seeds(directory: Path, args: TrainArguments, console: Console) -> int:
    """Train what ``--seeds`` asks for in a directory, or continue it (``--resume``); the exit code."""
    config = args.config
    # a wrong robot or timing file is refused here, once, and not by each run
    run_dir.timing(directory, config.timing, run_dir.robot(directory, config.robot))
    if args.resume is None:
        run_dir.check_fresh(directory)
        assert args.seeds is not None
        runs = seeds.begin(directory, config, args.seeds)
    else:
        if config != config_file.load(directory / run_dir.CONFIG):
            raise InvalidValue("--iterations", config.iterations, "left out when several seeds are continued")
        runs = seeds.runs_of(directory)
    flags: list[str | Path] = []
    if args.start_from is not None:
        flags += ["--start-from", args.start_from.resolve()]
    if args.start_std is not None:
        flags += ["--start-std", str(args.start_std)]
    console.print(
        f"Training {len(runs)} seeds in {directory} (preset {config.preset}, {config.robot}), "
        f"{seeds.side_by_side(len(runs))} side by side. What each says: {directory}/seed-*.txt",
        soft_wrap=True,
    )
    with run_lock.held(directory), SeedsDisplay(console, config, runs) as display:
        failed, stopped = seeds.train(config, runs, flags, display.update)
    if stopped:
        console.print("Stopped. To continue:")
        print_command(console, "symdyn", "train", "--resume", directory)
        return INTERRUPTED
    for run in failed:
        said = run.output.read_text(encoding="utf-8", errors="replace").splitlines()[-_TOLD_OF_A_FAILURE:]
        console.print(f"Seed {run.seed} failed. The end of {run.output}:", soft_wrap=True)
        console.print("\n".join(said), markup=False, highlight=False, soft_wrap=True)
    _report(directory, runs, console)
    return FAILED if failed else 0


def _report(directory: Path, runs: list[seeds.SeedRun], console: Console) -> None:
    found = seeds.table(runs)
    if not found:
        return
    write_json(directory / seeds.FILE, {"seeds": [run.seed for run in runs], "validation": found})
    rows = Table("in validation", *found, "mean", "from", "to", box=None, padding=(0, 1))
    for key, (name, form) in _COLUMNS.items():
        values = [figures[key] for figures in found.values()]
        cells = [*values, statistics.fmean(values), min(values), max(values)]
        rows.add_row(name, *(form.format(value) for value in cells))
    console.print(rows)
    console.print("A policy of each: ", soft_wrap=True, end="")
    console.print(", ".join(str(run.directory / run_dir.POLICY) for run in runs), soft_wrap=True)
