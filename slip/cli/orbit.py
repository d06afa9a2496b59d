"""``symdyn orbit``: one periodic gait: numbers, footfalls, forces, symmetry, figure and animation."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from slip.cli.arguments.orbit import OrbitArguments
from slip.cli.explore_with_progress import explore_with_progress
from slip.families.branch import Diagram
from slip.families.solve import NoOrbit, orbits_at
from slip.figures.animation import animate
from slip.figures.orbit import orbit_figure
from slip.model.naming import FAMILIES
from slip.orbits.orbit import Orbit
from slip.orbits.report import OrbitReport
from slip.orbits.symmetry import Image
from symdyn.errors import InvalidValue, SymdynError, UnknownName
from symdyn.figures.plots import save
from symdyn.io.console import log_to, make_console, print_written
from symdyn.io.files import writable_directory, write_json
from symdyn.io.progress import progress
from symdyn.robot.legs import LEGS

NUMBERS, FIGURE, ANIMATION = "orbit.json", "orbit.png", "orbit"
_BARE: dict[str, object] = {"box": SIMPLE_HEAD, "padding": (0, 1, 0, 0), "pad_edge": False, "show_edge": False}


def run(args: OrbitArguments) -> int:
    """The command. Raises SymdynError for bad input."""
    if not math.isfinite(args.speed):
        raise InvalidValue("--speed", args.speed, "a finite number")
    family = args.family.rstrip("0123456789")
    if family not in FAMILIES:
        raise UnknownName("family", args.family, FAMILIES)
    model = args.model.load()
    console = make_console()
    log_to(console)
    diagram = explore_with_progress(console, model.parameters, cache=args.cache)
    unit, symbol = (model.units.speed, "m/s") if model.units else (1.0, "sqrt(g D)")
    orbits = of_speed(diagram, args.family, args.speed / unit, args.speed, unit, symbol)
    if not 1 <= args.which <= len(orbits):
        raise InvalidValue(
            "--which", args.which, f"from 1 to {len(orbits)}: {args.family} has no more gaits at this speed"
        )
    writable_directory(args.out)
    report = OrbitReport.of(orbits[args.which - 1], args.family, model.units)
    title = f"{args.family}, {FAMILIES[family]}"
    write_json(args.out / NUMBERS, {"model": model.name, **report.as_dict()})
    save(orbit_figure(report.orbit, title, report.check_in_words, model.units), args.out / FIGURE)
    written = [NUMBERS, FIGURE]
    if args.animate != "none":
        written.append(f"{ANIMATION}.{args.animate}")
        _animate(console, report, args.out / written[-1], f"{args.family}: {FAMILIES[family]}", args)
    show(console, report, f"{title}; model: {model.name}")
    if len(orbits) > 1:
        others = ", ".join(f"{i + 1} (T {orbit.period:.5g})" for i, orbit in enumerate(orbits))
        console.print(f"\nThe family has {len(orbits)} gaits at this speed: {others}. Shown: {args.which} (--which).")
    print_written(console, f"\nWrote {', '.join(str(args.out / name) for name in written)}.")
    return 0


def of_speed(
    diagram: Diagram,
    family: str,
    speed: float,
    asked: float | None = None,
    unit: float = 1.0,
    symbol: str = "sqrt(g D)",
) -> list[Orbit]:
    """The gaits of a family at a speed, by falling stride period.

    Args:
        diagram: of the model.
        family: of slip.model.naming.FAMILIES.
        speed: at the apex [sqrt(g torso length)].
        asked: the same as the user gave it, for messages.
        unit: of ``asked``, in the model's.
        symbol: of that unit.

    Raises:
        SymdynError: if the family does not exist for the model; it says how that showed.
        InvalidValue: if it has no gait of this speed; it says which speeds it has.
        NoOrbit: if there should be one, and Newton's method did not find it.
    """
    try:
        branches = diagram.family(family)
    except UnknownName:
        why = diagram.missing.get(family)
        found = ", ".join(diagram.names) or "none"
        raise SymdynError(
            f"This model has no family {family} of passive gaits{f' ({why})' if why else ''}. Found: {found}."
        ) from None
    orbits: list[Orbit] = []
    problem: NoOrbit | None = None
    for branch in branches:
        try:
            orbits += orbits_at(branch, speed)
        except NoOrbit as failure:
            problem = failure if problem is None or problem.reason == "speed" else problem
    if not orbits and problem is not None and problem.reason != "speed":
        raise problem
    if not orbits:
        ranges = [(branch.speeds.min() * unit, branch.speeds.max() * unit) for branch in branches]
        has = " or ".join(f"from {low:.4g} to {high:.4g}" for low, high in sorted(ranges))
        raise InvalidValue(
            "--speed", speed if asked is None else asked, f"{has} {symbol}: the speeds that {family} has"
        )
    return sorted(orbits, key=lambda orbit: -orbit.period)


def show(console: Console, report: OrbitReport, title: str) -> None:
    """Print everything about a gait."""
    console.print(title + "\n")
    si = report.units is not None
    table = Table("quantity", "value", *(["SI"] if si else []), **_BARE)  # type: ignore[arg-type]
    for name, value, in_si in report.numbers():
        table.add_row(name, value, *([in_si] if si else []))
    console.print(table)
    console.print("D: torso, hind hip to front hip.\n")
    legs = Table("leg", **_BARE)  # type: ignore[arg-type]
    for heading in ("touchdown", "lift-off", "duty factor", "offset", "largest force"):
        legs.add_column(heading, justify="right")
    rows = zip(
        LEGS, _strides(report), report.orbit.duty_factors, report.symmetry.gait.offsets, _forces(report), strict=True
    )
    for leg, (down, off), duty, offset, force in rows:
        legs.add_row(leg, f"{down:.4f}", f"{off:.4f}", f"{duty:.4f}", f"{offset:.4f}", f"{force:.4g} M g")
    console.print(legs)
    console.print(
        f"In strides from the apex on. Footfall: {report.symmetry.footfall_class.describe()} "
        f"(K: spatial symmetries, H: those with a phase shift).\n"
    )
    checks = Table("check", "", **_BARE)  # type: ignore[arg-type]
    for what, value in report.checks():
        checks.add_row(what, value)
    console.print(checks)
    console.print(report.stability() + "\n")
    show_symmetry(console, report)


def show_symmetry(console: Console, report: OrbitReport) -> None:
    """The table of elements."""
    table = Table("element", **_BARE)  # type: ignore[arg-type]
    table.add_column("residual of the image", justify="right", no_wrap=True)
    for heading in ("an orbit?", "the same gait?"):
        table.add_column(heading, no_wrap=True)
    for image in report.symmetry.images:
        orbit = "yes" if image.is_orbit else "no" if image.keeps_model else "no: the model is not symmetric"
        table.add_row(image.element.name, f"{image.residual:.1e}", orbit, _same(image, report.orbit))
    console.print(table)
    console.print(
        "h, f: left-right of the hind, front pair; m: front-hind mirror; t: time reversal; e: identity. "
        "hf, m and hfm are the body's g_s, g_t and g_r."
    )
    console.print(report.symmetry_in_words())


def _same(image: Image, orbit: Orbit) -> str:
    if not image.is_orbit:
        return "-"
    if image.is_same:
        return "yes" if image.shift == 0.0 else f"yes, from {image.shift:.4f} of its cycle on"
    if image.element.reverses_direction and orbit.apex_speed != 0.0:
        return "no: it runs the other way"
    return f"no: another lead, off by {image.distance:.1e}"


def _strides(report: OrbitReport) -> list[tuple[float, float]]:
    orbit = report.orbit
    return list(zip(orbit.touchdowns / orbit.period, orbit.liftoffs / orbit.period, strict=True))


def _forces(report: OrbitReport) -> list[float]:
    from slip.orbits.orbit import TO_LEGS
    from slip.orbits.trajectory import sample

    forces = np.linalg.norm(sample(report.orbit, 400).force_w, axis=-1).max(axis=0)
    return [float(force) for force in forces[list(TO_LEGS)]]


def _animate(console: Console, report: OrbitReport, path: Path, name: str, args: OrbitArguments) -> None:
    with progress(console, f"Drawing {path.name}") as report_progress:
        animate(report.orbit, path, name, args.animation, report.units, report_progress)
