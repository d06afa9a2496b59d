"""From a training run to the one file that is deployed: the actor as ONNX with all its metadata inside."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import torch
from rsl_rl.modules import MLP
from torch import nn

from rl.learning import checkpoint, config_file, run_dir
from rl.learning.config import TrainConfig
from rl.learning.equivariant import EquivariantMLP, mirror_of_actions, mirror_of_groups
from symdyn.errors import FileProblem
from symdyn.gait.library import get
from symdyn.gait.timing import GRAVITY
from symdyn.io.files import read_json, write_with
from symdyn.io.origin import commit
from symdyn.io.settings_data import plain
from symdyn.policy import golden
from symdyn.policy.file import GOLDEN_KEY, INPUT, METADATA_KEY, OUTPUT, Policy
from symdyn.policy.metadata import PolicyMetadata
from symdyn.policy.observation import get_layout
from symdyn.robot.definition import Robot
from symdyn.robot.legs import JOINTS

OPSET = 18
TOLERANCE = 1e-4
"""Largest difference between the file's actions and the network's, relative to the larger of 1 and the action.

Float32 sums of a layer's products differ by up to 2e-5 with their order; a wrong network differs by far more.
"""

_TESTED = 256
_ACTION_NOISE = ("distribution.log_std_param", "distribution.std_param")


def export_policy(run: Path, out: Path | None = None, checkpoints: Sequence[Path] = ()) -> Path:
    """Write the policy file of a run. No simulator is built.

    Args:
        run: directory of the run.
        out: the file; ``RUN/policy.onnx`` if None.
        checkpoints: to take; the run's newest if empty. Of several the mean of the weights is taken (Izmailov et al.
            2018), and the samples of the one that saw most.

    Returns:
        Path of the file, which is whole and was compared with the network.

    Raises:
        FileProblem: if the directory holds no run, the checkpoint is damaged or of another configuration, or the file
            cannot be written. Nothing is left half-written, and an earlier file stays.
    """
    config = config_file.load(run_dir.existing(run) / run_dir.CONFIG)
    contents = {path: checkpoint.load(path) for path in checkpoints} or {run: checkpoint.load_newest(run)}
    robot = run_dir.robot(run, config.robot)
    for path, content in contents.items():
        checkpoint.check_robot(content, robot.name, path)
    origin = run if len(contents) > 1 else next(iter(contents))
    actor = _mean([build_actor(content, config, path) for path, content in contents.items()])
    latest = max(contents.values(), key=lambda content: content["iteration"])
    metadata = describe(run, config, latest["iteration"], robot, latest.get("stage", 0))
    out = out or run / run_dir.POLICY

    def write(temporary: Path) -> None:
        model = _to_onnx(actor, metadata)
        onnx.save(model, temporary)
        policy = Policy.load(temporary, robot)
        _compare(policy, actor, origin)
        model.metadata_props.add(key=GOLDEN_KEY, value=golden.record(policy))
        onnx.save(model, temporary)
        Policy.load(temporary, robot)

    write_with(out, write)
    return out


def build_actor(content: dict[str, Any], config: TrainConfig, origin: object) -> nn.Module:
    """The actor's network, observations (N, size) to mean actions (N, 12), from a checkpoint alone.

    Args:
        content: of the checkpoint.
        config: of the run; what the network's layers must agree with.
        origin: what to call the checkpoint in an error.

    Raises:
        FileProblem: if there is no actor in it, its layers are others, or its weights are not finite.
    """
    try:
        state: dict[str, torch.Tensor] = dict(content["ppo"]["actor_state_dict"])
    except (KeyError, TypeError) as error:
        raise FileProblem(origin, "holds a checkpoint without an actor.") from error
    for name in _ACTION_NOISE:
        state.pop(name, None)
    state = {name.removeprefix("mlp."): value for name, value in state.items()}
    layout = get_layout(config.env.observation)
    if config.ppo.equivariant:
        mirror_in = mirror_of_groups(["policy"], layout)
        actor = EquivariantMLP(mirror_in, mirror_of_actions(), config.ppo.hidden, len(JOINTS))
    else:
        actor = MLP(layout.size, len(JOINTS), config.ppo.hidden, "elu")
    found, wanted = _shapes(state), _shapes(actor.state_dict())
    if found != wanted:
        raise FileProblem(
            origin, f"holds an actor with {_only_in(found, wanted)}; its settings ask for {_only_in(wanted, found)}."
        )
    if not all(bool(torch.isfinite(value).all()) for value in state.values()):
        raise FileProblem(origin, "holds an actor whose weights are not finite.")
    actor.load_state_dict(state, strict=True)
    if isinstance(actor, EquivariantMLP):
        actor = actor.plain()
    return actor.eval()


def _mean(actors: list[nn.Module]) -> nn.Module:
    """A network whose weights are the mean of those of networks of one shape: the first of them, changed."""
    states = [actor.state_dict() for actor in actors]
    actors[0].load_state_dict({name: torch.stack([s[name] for s in states]).mean(dim=0) for name in states[0]})
    return actors[0]


def _shapes(state: Mapping[str, torch.Tensor]) -> dict[str, str]:
    return {name: "x".join(str(size) for size in value.shape) for name, value in state.items()}


def _only_in(shapes: dict[str, str], others: dict[str, str]) -> str:
    own = [f"{name} {shape}" for name, shape in shapes.items() if others.get(name) != shape]
    return ", ".join(own) or "nothing more"


def describe(run: Path, config: TrainConfig, iteration: int, robot: Robot, stage: int = 0) -> PolicyMetadata:
    """The metadata of a policy.

    Args:
        run: directory of the run.
        config: of the run.
        iteration: number of updates behind it.
        robot: that it was trained on.
        stage: that the run had reached, from 0.

    Raises:
        FileProblem: if the run's timing file is missing or malformed.
    """
    commands = config.in_stage(min(stage, max(len(config.stages) - 1, 0))).env.commands
    noted = run / run_dir.ORIGIN
    origin_commit = read_json(noted)["commit"] if noted.is_file() else commit()
    return PolicyMetadata(
        robot=robot.name,
        joint_names=robot.joint_names,
        default_joint_pos=tuple(robot.default_joint_pos.tolist()),
        action_scale=robot.action_scale,
        kp=robot.kp,
        kd=robot.kd,
        control_dt=robot.control_dt,
        leg_length=robot.leg_length,
        gravity=GRAVITY,
        observation=get_layout(config.env.observation),
        gaits={name: get(name) for name in commands.gaits},
        timing=run_dir.timing(run, config.timing, robot),
        command_range={
            "velocity_x": commands.velocity_x,
            "velocity_y": commands.velocity_y,
            "yaw_rate": commands.yaw_rate,
        },
        time_reversal=commands.time_reversal,
        steering=commands.steering if commands.steered else None,
        training={
            "commit": origin_commit,
            "config": plain(config),
            "samples": run_dir.ancestor(run)["samples"] + iteration * config.num_envs * config.ppo.steps,
            "seed": config.seed,
        },
    )


def _to_onnx(actor: nn.Module, metadata: PolicyMetadata) -> onnx.ModelProto:
    """The network as ONNX, with the metadata and without what the exporter notes about this machine."""
    with _quiet():
        program = torch.onnx.export(
            actor,
            (torch.zeros(2, metadata.observation.size),),  # two rows: one would be taken for a constant
            dynamo=True,
            opset_version=OPSET,
            external_data=False,
            input_names=[INPUT],
            output_names=[OUTPUT],
            dynamic_shapes=({0: torch.export.Dim("N")},),
            verbose=False,
        )
    assert program is not None
    model = program.model_proto
    graph = model.graph
    for noted in (graph, *graph.node, *graph.input, *graph.output, *graph.value_info, *graph.initializer):
        del noted.metadata_props[:]
    onnx.helper.set_model_props(model, {METADATA_KEY: metadata.to_json()})
    onnx.checker.check_model(model, full_check=True)
    return model


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep the exporter's warnings, which concern packages and calls that are not ours, from the user."""
    before = logging.root.manager.disable
    logging.disable(logging.WARNING)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        logging.disable(before)


def _compare(policy: Policy, actor: nn.Module, origin: object) -> None:
    obs = torch.randn(_TESTED, policy.metadata.observation.size, generator=torch.Generator().manual_seed(0))
    with torch.inference_mode():
        wanted = actor(obs).numpy()
    found = policy.act(obs.numpy())
    error = float(np.max(np.abs(found - wanted) / np.maximum(1.0, np.abs(wanted))))
    if not error <= TOLERANCE:
        raise FileProblem(origin, f"gives other actions as ONNX than in training (by {error:.2g}); nothing written.")
