"""``symdyn gaits``: the library as a table, a JSON list or a footfall picture."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from symdyn.errors import InvalidValue
from symdyn.gait.library import LIBRARY, Gait
from symdyn.gait.phase import in_swing, leg_phase
from symdyn.gait.symmetry import classify, gait_by_name
from symdyn.gait.timing import TimingCurve
from symdyn.io.console import make_console, print_written
from symdyn.policy.layout import Layout
from symdyn.policy.observation import LAYOUTS, TERMS
from symdyn.robot.legs import JOINTS, LEGS
from symdyn.robot.robot_file import get_robot
from symdyn_cli.arguments.gaits import GaitsArguments

_COLUMNS_A_STRIDE = 30
_STRIDES_SHOWN = 2


def run(args: GaitsArguments) -> int:
    """The command. Raises SymdynError for bad input."""
    if not math.isfinite(args.speed):
        raise InvalidValue("--speed", args.speed, "a finite number, m/s")
    timing = TimingCurve() if args.timing is None else TimingCurve.load(args.timing, get_robot(args.robot).name)
    gaits = list(LIBRARY.values()) if args.name is None else [gait_by_name(args.name)]
    if args.figure is not None and args.name is None:
        raise InvalidValue("--figure", str(args.figure), "used with the name of one gait")
    console = make_console()
    if args.json:
        console.out(json.dumps([as_json(gait) for gait in gaits], indent=2), highlight=False)
    elif args.observation:
        for name, layout in LAYOUTS.items():
            _print_observation(console, name, layout)
        _print_meanings(console)
    else:
        _show(console, gaits, timing, args)
    return 0


def as_json(gait: Gait) -> dict[str, Any]:
    """A gait and its symmetry class as ``symdyn gaits --json`` prints them."""
    found = classify(gait)
    return {
        "name": gait.name,
        "offsets": gait.by_leg(),
        "K": list(found.K),
        "H": [[element, shift] for element, shift in found.H],
        "time_reversal_partner": found.time_reversal_partner,
        "symmetric_pairs": [list(pair) for pair in found.symmetric_pairs],
    }


def _show(console: Console, gaits: list[Gait], timing: TimingCurve, args: GaitsArguments) -> None:
    robot = get_robot(args.robot)
    period = float(timing.period(np.array(args.speed), robot.leg_length))
    duty = float(timing.duty(np.array(args.speed), robot.leg_length))
    console.print(_library_table(gaits))
    at = f"At {args.speed:g} m/s ({robot.name})"
    console.print(f"{at}: stride period {period:.3f} s, duty factor {duty:.3f}. Curve: {timing.source}.")
    if args.name is None:
        console.print(
            "LH to RH: phase offset theta of each leg, strides. K: spatial symmetries. H: those with a phase shift."
        )
        console.print("Footfalls of one gait: symdyn gaits NAME.")
        return
    pairs = classify(gaits[0]).symmetric_pairs
    console.print(f"Legs in phase: {', '.join(' = '.join(pair) for pair in pairs) or 'none'}.")
    console.print(footfall_text(gaits[0], duty, args.speed))
    if args.figure is not None:
        from symdyn.figures.plots import gait_diagram, save

        save(gait_diagram(gaits[0], duty, _STRIDES_SHOWN), args.figure)
        print_written(console, f"Wrote {args.figure}.")


def _library_table(gaits: list[Gait]) -> Table:
    table = Table("gait", box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False)
    for leg in LEGS:
        table.add_column(leg, justify="right", no_wrap=True)
    for heading in ("K", "H", "reversed in time"):
        table.add_column(heading, no_wrap=True)
    for gait in gaits:
        found = classify(gait)
        k, h = found.describe().removeprefix("K=").split(" H=")
        offsets = [f"{offset:.2f}".removeprefix("0") for offset in gait.offsets]
        table.add_row(gait.name, *offsets, k, h, found.time_reversal_partner or "not in the library")
    table.columns[0].no_wrap = True
    return table


def footfall_text(gait: Gait, duty: float, speed: float) -> str:
    """Two strides as text: a row a leg, a block where the foot should stand."""
    columns = np.arange(_STRIDES_SHOWN * _COLUMNS_A_STRIDE) / _COLUMNS_A_STRIDE
    velocity = np.full(columns.shape, speed)
    phases = leg_phase(np.mod(columns, 1.0), np.tile(gait.theta, (len(columns), 1)), velocity)
    swing = in_swing(phases, np.full(columns.shape, duty))
    rows = [f"{leg} |{''.join('.' if up else '█' for up in swing[:, i])}|" for i, leg in enumerate(LEGS)]
    return "\n".join([*rows, f"    {_STRIDES_SHOWN} strides; █ stance, . swing"])


def _print_observation(console: Console, name: str, layout: Layout) -> None:
    table = Table(box=SIMPLE_HEAD)
    for heading in ("index", "term", "unit", "scale", "noise", "order"):
        table.add_column(heading, no_wrap=heading in ("index", "term"))
    slices = layout.slices
    for term in layout.terms:
        where = slices[term.name]
        noise = f"± {term.noise:g}" if term.noise else "-"
        order = "joints" if term.labels == JOINTS else " ".join(term.labels)
        table.add_row(f"{where.start}..{where.stop - 1}", term.name, term.unit, f"{term.scale:g}", noise, order)
    console.print(f"Observation {name!r}: {layout.size} inputs.")
    console.print(table)


def _print_meanings(console: Console) -> None:
    console.print("noise: half-width of the uniform noise in training, unscaled.")
    for term in TERMS.values():
        console.print(f"{term.name}: {term.meaning}")
    console.print(f"joints: {' '.join(JOINTS)}")
