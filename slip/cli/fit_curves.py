"""``symdyn fit-curves``: stride period and duty factor over speed, from passive orbits and, apart, from trials."""

from __future__ import annotations

import logging
from dataclasses import asdict, replace
from pathlib import Path

from rich.markdown import Markdown

from slip.cli.arguments.fit_curves import FitArguments
from slip.cli.explore_with_progress import explore_with_progress
from slip.cli.passive_model import PassiveModel, model_flags
from slip.curves.cells import branch_table, reaching
from slip.curves.file import FittedCurve, document, write
from slip.curves.fit import FEWEST_GROUPS, CurveFit, TimingPoints, fit_curves
from slip.curves.identify import identify
from slip.curves.points import PassiveOrbits
from slip.curves.report import markdown
from slip.curves.settings import ChoiceConfig
from slip.curves.trial_choice import Choice, choose
from slip.families.branch import Diagram
from slip.figures.curves import curve_figure
from symdyn.analysis import trials
from symdyn.errors import InvalidValue
from symdyn.figures.plots import save
from symdyn.io.console import log_to, make_console, print_command, print_written
from symdyn.io.files import writable_directory, write_text
from symdyn.robot.robot_file import DEFAULT_ROBOT, get_robot

_log = logging.getLogger(__name__)

CURVES, FIGURE, REPORT = "curves.json", "curves.png", "curves.md"


def run(args: FitArguments) -> int:
    """The command. Raises SymdynError for bad input."""
    if args.bootstrap < 0:
        raise InvalidValue("--bootstrap", args.bootstrap, "a whole number >= 0")
    if args.identify and (args.model.k is not None or args.model.ks is not None):
        raise InvalidValue("--identify", True, "left out when --k or --ks is given, because it chooses both")
    if args.active == "calibrated" and args.trials is None:
        raise InvalidValue("--active", args.active, "passive or paper when no --trials are given")
    model = _model(args)
    choice = None if args.trials is None else _chosen(args.trials, model, args.choice)
    calibrated = None if choice is None or args.trials is None else _calibrated(choice, args.trials, args)
    if args.identify:
        model = replace(model, parameters=identify(model.parameters, args.target))
    console = make_console()
    log_to(console)
    writable_directory(args.out)
    config = reaching(model.parameters, args.select.speeds[1], args.trot, args.carry)
    diagram = explore_with_progress(console, model.parameters, config, args.cache)
    points = PassiveOrbits.of(diagram.branches).select(args.select)
    passive = _passive(points, diagram, model, args)
    content = document(passive, calibrated, args.active, model.robot)
    text = markdown(content, model.name, FIGURE)
    figure = curve_figure(
        passive.fit,
        points,
        None if calibrated is None else calibrated.fit,
        None if choice is None else choice.points,
        _leg_length(model),
        f"Timing curves: {model.name}",
    )
    save(figure, args.out / FIGURE)
    write_text(args.out / REPORT, text)
    write(args.out / CURVES, content)
    console.print(Markdown(text.partition("\n## ")[0]))
    print_written(console, f"\nWrote {args.out / CURVES}, with {FIGURE} and {REPORT} beside it.")
    if content["active"] == "paper":
        console.print(
            "The active curve is the paper's, which symdyn train uses by default. To train with the fitted one:"
        )
        print_command(console, *_again_with_passive(args))
    else:
        comment = f"active curve: {content['active']}"
        print_command(console, "symdyn", "train", "--timing", args.out / CURVES, comment=comment)
    return 0


def _again_with_passive(args: FitArguments) -> list[object]:
    """The command again, with the passive curve active."""
    words: list[object] = ["symdyn", "fit-curves"]
    for flag, value in model_flags(args.model):
        words += [flag, *(value if isinstance(value, tuple) else [value])]
    words += [flag for flag, given in (("--reference", args.reference), ("--identify", args.identify)) if given]
    return [*words, "--active", "passive", "--out", args.out]


def _model(args: FitArguments) -> PassiveModel:
    robot, urdf = args.model.robot, args.model.urdf
    if args.reference and (robot is not None or urdf is not None):
        raise InvalidValue("--reference", True, "left out when a robot is named")
    named = args.reference or robot is not None or urdf is not None
    return (args.model if named else replace(args.model, robot=DEFAULT_ROBOT)).load()


def _leg_length(model: PassiveModel) -> float | None:
    """m; None for the literature's model."""
    return None if model.units is None else model.units.length * model.parameters.rest_length


def _passive(points: TimingPoints, diagram: Diagram, model: PassiveModel, args: FitArguments) -> FittedCurve:
    fit = _fitted(points, args.bootstrap, "families")
    families = ", ".join(fit.groups)
    data = {
        "robot": model.name,
        "leg_length": _leg_length(model),
        "slip_parameters": asdict(model.parameters),
        "identified": asdict(args.target) if args.identify else None,
        "families": list(fit.groups),
        "orbits": fit.points,
        "speed": "mean over a stride",
        "selection": asdict(args.select),
        "branches": {
            branch["name"]: f"{branch['orbits']} orbits, {branch['stable']} stable, "
            f"dx {branch['dx_min']:.3g} to {branch['dx_max']:.3g}"
            for branch in branch_table(diagram)
        },
        "not_found": dict(diagram.missing),
    }
    caveat = ""
    if args.identify:
        whose = "" if model.parameters.front_hind_symmetric else " of the symmetric twin"
        caveat = (
            f"k and ks were chosen so that the pronk{whose} at rest has T* {args.target.period_star:g} and duty factor "
            f"{args.target.duty:g}: the intercepts come from these targets, only the decay is the model's"
        )
    return FittedCurve(fit, data, f"{fit.points} orbits of {families}; model of {model.name}", caveat)


def _chosen(table: Path, model: PassiveModel, config: ChoiceConfig) -> Choice:
    own = _leg_length(model)
    length = own or get_robot(DEFAULT_ROBOT).leg_length
    its = trials.provenance(table).get("robot")
    if None not in (its, model.robot) and its != model.robot:
        raise InvalidValue(f"{table}: robot", its, f"{model.robot}, for which the curves are made")
    choice = choose(trials.read(table), length, config)
    if own is not None and abs(choice.leg_length - own) > 1e-6:
        allowed = f"that of {model.name}, {length:g} m, for which the curves are made"
        raise InvalidValue(f"{table}: leg_length", choice.leg_length, allowed)
    return choice


def _calibrated(choice: Choice, table: Path, args: FitArguments) -> FittedCurve:
    fit = _fitted(choice.points, args.bootstrap, "gaits")
    for name, count in (("T", choice.period_at_edge), ("beta", choice.duty_at_edge)):
        if count:
            _log.warning(
                "In %d of %d cases the cheapest %s is the smallest or largest that was tried: the range of the sweep "
                "decided there, not the cost. Widen the sweep.", count, fit.points, name,
            )  # fmt: skip
    data = {**trials.provenance(table), **asdict(args.choice), **choice.as_dict()}
    summary = f"{fit.points} cases of gait and speed out of {choice.trials} trials in {table.name}"
    caveat = "The policy had been trained with a curve, too, and is at its best near that one"
    return FittedCurve(fit, data, summary, caveat)


def _fitted(points: TimingPoints, bootstrap: int, what: str) -> CurveFit:
    groups = len(set(points.group))
    if bootstrap and groups < FEWEST_GROUPS:
        _log.warning("%d %s are too few for a bootstrap: the intervals come from the covariance.", groups, what)
        bootstrap = 0
    return fit_curves(points, bootstrap)
