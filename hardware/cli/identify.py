"""``symdyn identify``: what one machine's joints and motors are, from a log of symdyn deploy --identify."""

from __future__ import annotations

from collections.abc import Callable

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from hardware.cli.arguments.identify import IdentifyArguments
from hardware.identification.comparison import courses, figure
from hardware.identification.identify import identify, nominal
from hardware.identification.leg_dynamics import FloatingRobot
from hardware.identification.signals import read_signals
from symdyn.errors import InvalidValue
from symdyn.io.console import log_to, make_console, print_command, print_written
from symdyn.io.files import writable_directory, write_with
from symdyn.io.progress import progress
from symdyn.robot.fit import QUANTITIES, UNITS, Fit, Measured, save_fit
from symdyn.robot.robot_file import get_robot

_DIGITS = {"delay": 1, "armature": 4, "damping": 3, "offset": 3}


def run(args: IdentifyArguments) -> int:
    """The command. Raises SymdynError for bad input."""
    if args.out.suffix != ".toml":
        raise InvalidValue("--out", str(args.out), "a file that ends in .toml")
    console = make_console()
    log_to(console)
    writable_directory(args.out.parent)
    with progress(console, "reading") as report_progress:
        signals = read_signals(args.log, report_progress)
    robot = get_robot(args.robot or signals.session.robot)
    with progress(console, "fitting") as report_progress:
        fit = identify(signals, robot, args.log, report_progress)
    _show(console, fit)
    save_fit(fit, args.out)
    written = [args.out]
    if fit.place == "hung":
        found = courses(signals, fit, nominal(robot), FloatingRobot(robot))
        drawing = args.out.with_suffix(".png")
        title = f"{args.log.name}, {robot.name}, {fit.place}: the end of each joint's chirp, and its steps"
        write_with(drawing, lambda path: figure(found, title).savefig(path, dpi=120))
        written.append(drawing)
    print_written(console, f"Wrote {' and '.join(map(str, written))}. Next:")
    print_command(console, "symdyn", "train", "--robot", args.robot or robot.name, "--fit", args.out)
    return 0


def _show(console: Console, fit: Fit) -> None:
    console.print(f"Values. ?: not determined by the log. {fit.source}, {fit.place}.", highlight=False)
    console.print(_table(fit, lambda measured: measured.value))
    console.print("Half of the 95% interval.", highlight=False)
    console.print(_table(fit, lambda measured: 0.5 * (measured.high - measured.low)))
    doubtful = [name for name in QUANTITIES if not any(getattr(joint, name).determined for joint in fit.joints)]
    if doubtful:
        console.print(f"The log determines of no joint: {', '.join(doubtful)}. The model's numbers stand for them.")


def _table(fit: Fit, number_of: Callable[[Measured], float]) -> Table:
    """One number for each joint and quantity; no wider than 80 columns."""
    table = Table(box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column("joint", no_wrap=True)
    for name in QUANTITIES:
        unit = "ms" if name == "delay" else UNITS[name]
        table.add_column(f"{name}\n{unit}", justify="right", no_wrap=True)
    for joint in fit.joints:
        cells = []
        for name in QUANTITIES:
            measured = getattr(joint, name)
            scale = 1e3 if name == "delay" else 1.0
            digits = _DIGITS.get(name, 2)
            cells.append(f"{scale * number_of(measured):.{digits}f}" if measured.determined else "?")
        table.add_row(joint.joint, *cells)
    return table
