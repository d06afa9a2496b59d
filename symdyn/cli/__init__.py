"""The command ``symdyn``: finds the subcommand and imports only what it needs.

Every command is a module with ``run(arguments) -> exit code``. This file imports none of them, so that ``symdyn
--help`` answers at once and a robot's computer needs no trainer.
"""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass

from symdyn.errors import SymdynError, UnknownName

BAD_INPUT = 2
INTERRUPTED = 130


@dataclass(frozen=True)
class Command:
    """A subcommand.

    Attributes:
        module: what to import.
        extra: the extra of the distribution that brings its packages, or None.
        summary: one line.
        example: how one would call it.
        names: where its first argument's names are, ``module:attribute``, for the shell to complete; or None.
    """

    module: str
    extra: str | None
    summary: str
    example: str
    names: str | None = None


GROUPS: dict[str, dict[str, Command]] = {
    "Look at gaits and robots": {
        "gaits": Command(
            "symdyn.cli.gaits",
            None,
            "the gait library: offsets, symmetry class, timing, footfalls",
            "symdyn gaits rotary_gallop --speed 1.0",
            names="symdyn.gaits:LIBRARY",
        ),
        "symmetry": Command(
            "slip.cli.symmetry",
            "slip",
            "the symmetry group of a robot, found from its URDF, and the robot as a spring-loaded model",
            "symdyn symmetry --robot solo12",
        ),
    },
    "Find passive gaits": {
        "families": Command(
            "slip.cli.families",
            "slip",
            "every family of passive gaits of a spring-loaded quadruped, with the branch diagram",
            "symdyn families --k 10 --ks 20 --J 2",
        ),
        "orbit": Command(
            "slip.cli.orbit",
            "slip",
            "one passive gait: numbers, footfalls, forces, symmetry, animation",
            "symdyn orbit --family BG --speed 5.0",
        ),
        "fit-curves": Command(
            "slip.cli.fit_curves",
            "slip",
            "stride period and duty factor over speed: fit to passive gaits and, apart, to a policy's trials",
            "symdyn fit-curves --robot go2 --trials out/mine/timing_sweep.json",
        ),
        "study": Command(
            "slip.cli.study",
            "slip",
            "families and timing curves of a grid of models, in parallel, resumable",
            "symdyn study --k 5 10 20 --ks 10 20 40 --jobs 2",
        ),
    },
    "Train a policy": {
        "train": Command(
            "rl.cli.train",
            "rl",
            "train one policy for every gait (PPO)",
            "symdyn train --out runs/mine --iterations 2000",
        ),
        "export": Command(
            "rl.cli.export", "rl", "turn a run into one policy file (ONNX)", "symdyn export runs/mine --out mine.onnx"
        ),
    },
    "Judge a policy": {
        "evaluate": Command(
            "rl.cli.evaluate",
            "rl",
            "the paper's metrics and figures for a policy file",
            "symdyn evaluate mine.onnx --suite quick --out out/mine",
        ),
        "experiment": Command(
            "rl.cli.experiment",
            "rl",
            "the experiments of the paper's Results section, each with figures and a table paper against ours",
            "symdyn experiment velocity gaits --out out/experiments",
            names="rl.experiments.catalogue:EXPERIMENTS",
        ),
        "record": Command(
            "rl.cli.record",
            "rl",
            "a film of a policy that goes through gaits and speeds, with its footfalls (MP4 or GIF)",
            "symdyn record mine.onnx --gaits trot rotary_gallop --speeds 0.8 --out out/mine.mp4",
        ),
        "play": Command(
            "symdyn.cli.play",
            "viewer",
            "a policy live in the browser: gaits, mixtures, pushes, terrain, footfalls of the last strides",
            "symdyn play --port 8080",
        ),
        "demo": Command(
            "rl.cli.demo",
            "rl",
            "a report on the policy that comes with symdyn, in a minute",
            "symdyn demo --out out/demo",
        ),
    },
    "Run a policy on the robot": {
        "deploy": Command(
            "hardware.cli.deploy",
            "hardware",
            "run a policy on a Go2 over LCM, with joystick or keyboard, safety and log",
            "symdyn deploy mine.onnx --log run.lcmlog",
        ),
        "robot-sim": Command(
            "symdyn.cli.robot_sim",
            "robot-sim",
            "a simulated Go2 that speaks the real one's protocol, with faults on demand",
            "symdyn robot-sim --scenario paper",
        ),
        "analyze": Command(
            "hardware.cli.analyze",
            "hardware",
            "a log of the robot as the paper's hardware figures: contacts, velocity, torque, cost of transport",
            "symdyn analyze run.lcmlog --out out/run",
        ),
        "calibrate-feet": Command(
            "hardware.cli.calibrate_feet",
            "hardware",
            "thresholds of the feet's force sensors, from a log of running",
            "symdyn calibrate-feet run.lcmlog --out feet.json",
        ),
        "replay": Command(
            "hardware.cli.replay",
            "hardware",
            "a log once more through the controller, which must do the same",
            "symdyn replay run.lcmlog",
        ),
    },
    "Type less": {
        "completion": Command(
            "symdyn.cli.completion",
            None,
            "a script with which the Tab key completes commands and options, for bash, zsh or fish",
            "symdyn completion bash > ~/.local/share/bash-completion/completions/symdyn",
            names="symdyn.cli.completion:SHELLS",
        ),
    },
}


_WIDTH = max(len(name) for group in GROUPS.values() for name in group)


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point. Returns the exit code: 0 done, 2 bad input, 130 interrupted.

    Args:
        arguments: of the command line, without the program's name; ``sys.argv`` if None.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    if not given or given[0] in ("-h", "--help"):
        sys.stdout.write(overview())
        return 0
    if given[0] == "--version":
        from importlib.metadata import version

        sys.stdout.write(f"symdyn {version('symdyn-gaits')}\n")
        return 0
    commands = {name: command for group in GROUPS.values() for name, command in group.items()}
    try:
        if given[0] not in commands:
            raise UnknownName("command", given[0], commands)
        return _run(given[0], commands[given[0]], given[1:])
    except SymdynError as error:
        return _fail(str(error))
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        # the reader (head, less) has gone; without this the interpreter complains once more while it exits
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def overview() -> str:
    """The text of ``symdyn --help``: commands by what one wants to do, with an example each."""
    lines = [
        "symdyn: one definition of a gait for analysis, training and the robot.",
        "",
        "usage: symdyn COMMAND [options]",
    ]
    for group, commands in GROUPS.items():
        lines += ["", f"{group}:"]
        for name, command in commands.items():
            lines += [f"  {name:<{_WIDTH}} {command.summary}", f"  {'':<{_WIDTH}} $ {command.example}"]
    lines += ["", "'symdyn COMMAND --help' explains every option. 'symdyn --version' prints the version.", ""]
    return "\n".join(lines)


def _run(name: str, command: Command, arguments: list[str]) -> int:
    try:
        module = importlib.import_module(command.module)
    except ModuleNotFoundError as error:
        if command.extra is None or error.name == command.module:
            raise
        return _fail(
            f"{name} needs {error.name!r}, which is not installed: pip install 'symdyn-gaits[{command.extra}]'."
        )
    return module.run(arguments)


def _fail(message: str) -> int:
    sys.stderr.write(f"symdyn: error: {message}\n")
    return BAD_INPUT
