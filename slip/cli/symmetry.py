"""``symdyn symmetry``: the symmetry group of a robot's body, found from its description, and the SLIP that it is."""

from __future__ import annotations

from dataclasses import asdict, astuple
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from slip.cli.arguments.symmetry import SymmetryArguments
from slip.model.parameters import SlipParameters
from slip.robot.body import Gains, RobotBody, measure
from slip.robot.morphology import Element, Morphology, find_morphology, group_name
from slip.robot.quadruped import Quadruped
from slip.robot.tolerances import Tolerances
from slip.robot.units import slip_parameters
from slip.robot.urdf import load_robot, load_urdf
from symdyn.errors import FileProblem, InvalidValue, SymdynError
from symdyn.io.console import make_console, print_written
from symdyn.io.files import write_json
from symdyn.robot.legs import JOINTS, LEGS
from symdyn.robot.robot_file import DEFAULT_ROBOT

FORMAT_VERSION = 1


def run(args: SymmetryArguments) -> int:
    """The command. Raises SymdynError for bad input."""
    gains = _gains(args)
    robot = _load(args)
    morphology = find_morphology(robot, args.tolerances)
    body, problem = _body(robot, gains)
    if args.out is not None:
        write_json(args.out, as_json(robot, morphology, body))
    console = make_console()
    _show(console, robot, morphology)
    if body is None:
        console.print(f"No spring-loaded model: {problem}")
    else:
        _show_body(console, body, slip_parameters(body))
    if args.out is not None:
        print_written(console, f"Wrote {args.out}.")
    return 0


def as_json(robot: Quadruped, morphology: Morphology, body: RobotBody | None) -> dict[str, Any]:
    """What ``--out`` writes."""
    return {
        "format_version": FORMAT_VERSION,
        "urdf": robot.urdf.name,
        "feet": {leg.name: leg.foot for leg in robot.legs},
        **morphology.as_dict(),
        "body": None if body is None else _body_as_json(body),
        "slip_parameters": None if body is None else asdict(slip_parameters(body)),
    }


def verdict(robot: str, morphology: Morphology) -> str:
    """The conclusion in words."""
    mechanism, body = morphology.mechanism_group, morphology.body_group
    if mechanism == body:
        return f"{robot} has {_named(body)}, as a mechanism and as a body."
    text = f"As a mechanism {robot} has {_named(mechanism)}; as a body it has {_named(body)}."
    failures = [_why_not(g, morphology.tolerances) for g in morphology.elements if g.name in set(mechanism) - set(body)]
    return " ".join([text, *failures])


def _gains(args: SymmetryArguments) -> Gains | None:
    if args.kp is None and args.kd is None:
        return None
    if args.kp is None or args.kd is None:
        raise InvalidValue(
            "--kd" if args.kp is None else "--kp", args.kd or args.kp, "given together with the other gain"
        )
    return Gains(args.kp, args.kd)


def _load(args: SymmetryArguments) -> Quadruped:
    if args.urdf is not None:
        if args.robot is not None:
            raise InvalidValue("--robot", args.robot, "left out when --urdf is given")
        return load_urdf(args.urdf, feet=args.feet, srdf=args.srdf)
    for name, value in (("--feet", args.feet), ("--srdf", args.srdf)):
        if value is not None:
            raise InvalidValue(name, value if isinstance(value, tuple) else str(value), "used with --urdf")
    return load_robot(args.robot or DEFAULT_ROBOT)


def _body(robot: Quadruped, gains: Gains | None) -> tuple[RobotBody | None, str]:
    # a robot without a pose of standing still has a symmetry group
    try:
        return measure(robot, gains), ""
    except FileProblem:
        raise
    except SymdynError as error:
        return None, str(error)


def _named(group: tuple[str, ...]) -> str:
    return f"{group_name(group)} = {{{', '.join(group)}}}" if len(group) > 1 else "none but the identity"


def _why_not(g: Element, tolerances: Tolerances) -> str:
    reasons = []
    if g.mass_error > tolerances.mass:
        reasons.append(f"the mass matrix by {g.mass_error:.1e} (allowed {tolerances.mass:g})")
    if g.limits_error > tolerances.limits:
        reasons.append(f"joint limits by {g.limits_error:.2f} rad (allowed {tolerances.limits:g})")
    return f"{g.name} misses {' and '.join(reasons) or 'the product of two others'}."


def _show(console: Console, robot: Quadruped, morphology: Morphology) -> None:
    feet = ", ".join(f"{leg.name} {leg.foot}" for leg in robot.legs)
    console.print(f"{robot.name} ({robot.urdf.name}): {len(robot.joints)} joints; feet {feet}.")
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False)
    for heading in ("element", " ".join(LEGS), "signs"):
        table.add_column(heading, no_wrap=True)
    for heading in ("feet", "mass matrix", "limits"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("symmetry of", no_wrap=True)
    for g in morphology.elements:
        images = " ".join(LEGS[i] for i in g.leg_index)
        errors = f"{g.kinematics_error:.0e}", f"{g.mass_error:.1e}", f"{g.limits_error:.2f}"
        table.add_row(g.name, images, _signs(robot, g), *errors, _holds_for(g, morphology.tolerances))
    console.print(table)
    console.print(
        "signs: of a leg's joints from the trunk outwards, as it takes its image's place. Errors: feet relative to the "
        "legs' reach, mass matrix to its norm, limits in rad."
    )
    console.print(verdict(robot.name, morphology))
    others = [g.name for g in morphology.elements if not g.is_symdyns()]
    if len(robot.joints) != len(JOINTS):
        console.print(
            f"symdyn.gait.symmetry describes robots with {len(JOINTS)} joints; this one has {len(robot.joints)}."
        )
    elif others:
        console.print(
            f"The joint signs of {', '.join(others)} are not those of symdyn.gait.symmetry: other joint axes."
        )
    else:
        console.print("Permutations and signs are those of symdyn.gait.symmetry, which reward and networks use.")


def _signs(robot: Quadruped, g: Element) -> str:
    by_leg = ["".join("+" if sign > 0 else "-" for sign in g.joint_signs[robot.joints_of(leg)]) for leg in robot.legs]
    return by_leg[0] if len(set(by_leg)) == 1 else " ".join(by_leg)


def _holds_for(g: Element, tolerances: Tolerances) -> str:
    if g.of_body(tolerances):
        return "body"
    return "mechanism only" if g.of_mechanism(tolerances) else "nothing"


def _show_body(console: Console, body: RobotBody, parameters: SlipParameters) -> None:
    k, ks, inertia, length, _, hind_distance, ratio = astuple(parameters)
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False)
    for heading in ("as a spring-loaded model", "SI", "dimensionless"):
        table.add_column(heading, no_wrap=True)
    table.add_row("mass", f"{body.mass:.3f} kg", "1")
    table.add_row("torso, hip to hip", f"{body.torso_length:.4f} m", "1")
    table.add_row("pitch inertia", f"{body.pitch_inertia:.4f} kg m^2", f"J {inertia:.4f}")
    table.add_row(
        "centre of mass from the hind hips", f"{hind_distance * body.torso_length:.4f} m", f"lb {hind_distance:.4f}"
    )
    table.add_row("leg length", f"{body.leg_length:.4f} m", f"l {length:.4f}")
    table.add_row("leg stiffness", f"{body.mean_stiffness:.0f} N/m", f"k {k:.3f}")
    table.add_row("hind over front leg stiffness", "", f"kr {ratio:.3f}")
    table.add_row("leg swings on its gain with", f"{body.swing_frequency:.2f} rad/s", f"ks {ks:.2f}")
    pendulum = slip_parameters(body, swing="pendulum").swing_stiffness
    table.add_row("leg hangs by gravity with", f"{body.pendulum_frequency:.2f} rad/s", f"(ks {pendulum:.2f})")
    console.print()
    console.print(table)
    gains = body.gains
    console.print(f"Gains: kp {gains.kp:.4g} N m/rad, kd {gains.kd:.3g} N m s/rad ({gains.source}).")


def _body_as_json(body: RobotBody) -> dict[str, Any]:
    arrays = {
        name: getattr(body, name).tolist()
        for name in (
            "centre_of_mass",
            "hips",
            "feet",
            "leg_stiffness",
            "leg_stiffness_sliding",
            "leg_inertia",
            "leg_angles",
        )
    }
    numbers = {
        name: getattr(body, name)
        for name in (
            "mass", "pitch_inertia", "torso_length", "hind_distance", "leg_length", "stiffness_ratio",
            "swing_frequency", "swing_damping_ratio", "pendulum_frequency",
        )
    }  # fmt: skip
    return numbers | arrays | {"gains": asdict(body.gains)}
