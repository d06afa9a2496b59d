"""The commands of ``symdyn``: what each is for, and where it lives. Nothing heavy is imported here."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Command:
    """A subcommand.

    Attributes:
        module: what does the work: ``run(parsed) -> exit code``.
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

    @property
    def arguments(self) -> str:
        """The module that parses the command line: ``parse(arguments)``. It imports no heavy library."""
        package, _, name = self.module.rpartition(".")
        return f"{package}.arguments.{name}"


GROUPS: dict[str, dict[str, Command]] = {
    "Look at gaits and robots": {
        "gaits": Command(
            "symdyn_cli.gaits",
            None,
            "the gait library: offsets, symmetry class, timing, footfalls",
            "symdyn gaits rotary_gallop --speed 1.0",
            names="symdyn.gait.library:LIBRARY",
        ),
        "robots": Command(
            "symdyn_cli.robots",
            None,
            "the robots known by name, and their robot files",
            "symdyn robots go2",
            names="symdyn.robot.robot_file:ROBOTS",
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
            "stride period and duty factor over speed, fitted to passive gaits or to a policy's trials",
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
            "the experiments of the paper's Results section, each with figures and a table paper, goal, here",
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
            "symdyn_cli.play",
            "viewer",
            "a policy live in the browser: gaits, mixtures, pushes, terrain, footfalls of the last strides",
            "symdyn play --port 8080",
        ),
        "demo": Command(
            "rl.cli.demo",
            "rl",
            "a report on the policy that comes with symdyn",
            "symdyn demo --out out/demo",
        ),
    },
    "Run a policy on the robot": {
        "deploy": Command(
            "hardware.cli.deploy",
            "hardware",
            "run a policy on a robot over LCM, with joystick or keyboard, safety and log",
            "symdyn deploy mine.onnx --log run.lcmlog",
        ),
        "bridge": Command(
            "hardware.cli.bridge",
            "bridge",
            "connect a Go2's own wire (DDS) to the deployer; a guard damps if it fails",
            "symdyn bridge --interface eth0",
        ),
        "robot-sim": Command(
            "symdyn_cli.robot_sim",
            "robot-sim",
            "a simulated robot that speaks the real one's protocol, with faults on demand",
            "symdyn robot-sim --scenario paper",
        ),
        "analyze": Command(
            "hardware.cli.analyze",
            "hardware",
            "figures and metrics of a robot log: contacts, velocity, torque, cost of transport",
            "symdyn analyze run.lcmlog --out out/run",
        ),
        "identify": Command(
            "hardware.cli.identify",
            "hardware",
            "what one machine's joints and motors are (delay, strength, gains, friction), from a log of two minutes",
            "symdyn identify run.lcmlog --out robot_fit.toml",
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
            "run the controller on a log again: it must do the same, bit for bit",
            "symdyn replay run.lcmlog",
        ),
    },
    "Type less": {
        "completion": Command(
            "symdyn_cli.completion",
            None,
            "a script for bash, zsh or fish that completes commands and options with the Tab key",
            "symdyn completion bash > ~/.local/share/bash-completion/completions/symdyn",
            names="symdyn_cli.arguments.completion:SHELLS",
        ),
    },
}
