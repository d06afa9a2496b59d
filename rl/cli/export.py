"""``symdyn export``: one policy file from a run."""

from __future__ import annotations

from rl.physics.threads import wait_passively

wait_passively()  # before torch

from collections.abc import Sequence  # noqa: E402
from dataclasses import dataclass  # noqa: E402
from pathlib import Path  # noqa: E402
from typing import Annotated  # noqa: E402

import tyro  # noqa: E402

from rl.learning import config_file, run_dir  # noqa: E402
from rl.learning.export import export_policy  # noqa: E402
from symdyn.io.console import log_to, make_console  # noqa: E402


@dataclass(frozen=True)
class ExportArguments:
    """Turn the newest checkpoint of a run into one ONNX file that holds everything that deploys it: weights, joint
    names, gains, observation layout, gaits, timing, and what it was trained with.

    Attributes:
        run: directory of the run.
        out: the file; RUN/policy.onnx if left out.
        checkpoint: a checkpoint of the run other than the newest; the mean of the weights of several, which often runs
            better than each of them (stochastic weight averaging).
    """

    run: Annotated[Path, tyro.conf.Positional]
    out: Path | None = None
    checkpoint: tuple[Path, ...] = ()


def run(arguments: Sequence[str]) -> int:
    """The command. Raises SymdynError for bad input."""
    args = tyro.cli(ExportArguments, args=list(arguments), prog="symdyn export")
    console = make_console()
    log_to(console)
    path = export_policy(run_dir.existing(args.run), args.out, args.checkpoint)
    robot = run_dir.robot_flag(config_file.load(args.run / run_dir.CONFIG).robot)
    console.print(f"Wrote {path} ({path.stat().st_size / 1024:.0f} KiB). Next:")
    console.print(f"  symdyn evaluate {path} --suite quick{robot}", soft_wrap=True)
    return 0
