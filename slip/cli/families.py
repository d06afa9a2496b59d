"""``symdyn families``: all families of passive gaits of a model, as a table, data and the branch diagram."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from slip.cli.arguments.families import FamiliesArguments
from slip.cli.explore_with_progress import explore_with_progress
from slip.cli.passive_model import PassiveModel, PassiveModelArguments, model_flags
from slip.families.branch import Branch, Diagram
from slip.families.continuation import StepConfig
from slip.families.explore import ExploreConfig
from slip.families.store import save as save_diagram
from slip.figures.diagram import branch_diagram, described
from slip.model.naming import FAMILIES
from symdyn.errors import InvalidValue
from symdyn.figures.plots import save
from symdyn.io.console import log_to, make_console, print_command
from symdyn.io.files import writable_directory

FIGURE = "families.png"
_NOTHING = 5e-10
_BARE: dict[str, object] = {"box": SIMPLE_HEAD, "padding": (0, 1, 0, 0), "pad_edge": False, "show_edge": False}


def run(args: FamiliesArguments) -> int:
    """The command. Raises SymdynError for bad input."""
    if args.max_speed is not None and not (math.isfinite(args.max_speed) and args.max_speed > 0.0):
        raise InvalidValue("--max-speed", args.max_speed, "a finite number > 0")
    model = args.model.load()
    console = make_console()
    log_to(console)
    writable_directory(args.out)
    diagram = explore_with_progress(console, model.parameters, _config(args, model), args.cache)
    save_diagram(diagram, args.out)
    title = f"Gait families of the quadrupedal SLIP: {model.name} ({described(model.parameters)})"
    save(branch_diagram(diagram, title, model.units), args.out / FIGURE)
    show(console, diagram, model)
    console.print(f"\nWrote families.npz, families.json and {FIGURE} into {args.out}. One gait, of the same model:")
    print_command(console, "symdyn", "orbit", *_example(diagram, model, args.model))
    return 0


def _example(diagram: Diagram, model: PassiveModel, given: PassiveModelArguments) -> list[str]:
    """Arguments that show a gait of the diagram, of the same model."""
    longest = max(diagram.branches, key=len)
    middle = float(np.median(longest.speeds)) * (model.units.speed if model.units else 1.0)
    words = ["--family", longest.family, "--speed", f"{middle:.3g}"]
    for flag, value in model_flags(given):
        words += [flag, *(value if isinstance(value, tuple) else [str(value)])]
    return words


def _config(args: FamiliesArguments, model: PassiveModel) -> ExploreConfig:
    config = ExploreConfig(trot=args.trot)
    if not args.carry:
        config = replace(config, seeds=0)
    if args.max_speed is None:
        return config
    scale = model.units.speed if model.units else 1.0
    return replace(config, steps=StepConfig(max_speed=args.max_speed / scale))


def show(console: Console, diagram: Diagram, model: PassiveModel) -> None:
    """Print branches, junctions and what was not found."""
    scale, symbol = (model.units.speed, "m/s") if model.units else (1.0, "sqrt(g D)")
    console.print(f"Model: {model.name}, {described(model.parameters)}. Speeds at the apex, {symbol}.\n")
    table = Table("branch", **_BARE)  # type: ignore[arg-type]
    for heading in ("speeds", "orbits", "stable", "checked to"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("ends")
    for branch in diagram.branches:
        low, high = branch.speeds.min() * scale, branch.speeds.max() * scale
        table.add_row(
            branch.name,
            f"{low:.3f} .. {high:.3f}",
            str(len(branch)),
            f"{branch.stable.mean():.0%}",
            _checked(branch),
            "; ".join(dict.fromkeys(branch.ends)),
        )
    console.print(table)
    console.print("; ".join(f"{name} {FAMILIES[name]}" for name in diagram.names) + ".")
    console.print(
        "checked to: largest difference over a stride to an independent integrator that detects its events.\n"
    )
    if diagram.junctions:
        console.print(_junction_table(diagram, scale, symbol))
        console.print("parts: the pair of legs that move together before and apart after. D: torso length.")
    else:
        console.print("There are no junctions.")
    for why in dict.fromkeys(diagram.missing.values()):
        names = ", ".join(family for family, other in diagram.missing.items() if other == why)
        console.print(f"Not found: {names}: {why}.")


def _junction_table(diagram: Diagram, scale: float, symbol: str) -> Table:
    table = Table("from", "to", "parts", **_BARE)  # type: ignore[arg-type]
    for heading in (f"speed, {symbol}", "T, sqrt(D/g)", "dphi, sqrt(g/D)"):
        table.add_column(heading, justify="right", no_wrap=True)
    for junction in diagram.junctions:
        numbers = (junction.dx * scale, junction.T, junction.dphi)
        text = (f"{0.0 if abs(x) < _NOTHING else x:.6f}" for x in numbers)
        table.add_row(junction.on, junction.to, junction.pair, *text)
    return table


def _checked(branch: Branch) -> str:
    known = branch.confirmed[np.isfinite(branch.confirmed)]
    text = f"{known.max():.0e}" if len(known) else "-"
    others = len(branch) - len(known)
    return f"{text} ({others} not)" if others else text
