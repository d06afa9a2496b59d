"""``symdyn calibrate-feet``: from a log, the raw foot force above which a foot bears load."""

from __future__ import annotations

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from hardware.cli.arguments.calibrate_feet import CalibrateFeetArguments
from hardware.control.controller import State
from hardware.estimation.calibration import FootCalibration, calibrate, read_raw
from hardware.logs.contact_figure import contact_figure
from symdyn.figures.plots import save
from symdyn.io.console import log_to, make_console, print_command, print_written
from symdyn.io.progress import progress
from symdyn.robot.legs import LEGS


def run(args: CalibrateFeetArguments) -> int:
    """The command. Raises SymdynError for bad input."""
    console = make_console()
    log_to(console)
    with progress(console, "reading") as report_progress:
        raw = read_raw(args.log, report_progress, state=State.RUN)
    calibration = calibrate(raw, str(args.log))
    _show(console, calibration)
    calibration.save(args.out)
    print_written(console, f"Wrote {args.out}.")
    if args.figure is not None:
        save(contact_figure(raw, calibration), args.figure)
        print_written(console, f"Wrote {args.figure}.")
    console.print("Use them:")
    print_command(console, "symdyn", "deploy", "POLICY.onnx", "--feet", args.out)
    return 0


def _show(console: Console, calibration: FootCalibration) -> None:
    table = Table("foot", box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for heading in ("threshold", "swing", "spread", "stance", "in stance"):
        table.add_column(heading, justify="right", no_wrap=True)
    for leg, foot in zip(LEGS, calibration.feet, strict=True):
        numbers = (foot.threshold, foot.swing, foot.swing_deviation, foot.stance)
        table.add_row(leg, *(f"{number:.1f}" for number in numbers), f"{foot.stance_share:.0%}")
    console.print(table)
    console.print(
        f"Raw force of each foot, {calibration.samples} samples; in stance: share of samples above threshold."
    )
