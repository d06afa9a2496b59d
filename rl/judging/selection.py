"""The policy that a finished run hands out: the best of its late checkpoints and their mean, by validation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from rl.judging.validation import Validation, validate
from rl.learning import checkpoint, run_dir
from rl.learning.export import export_policy
from symdyn.errors import FileProblem
from symdyn.io.files import write_json
from symdyn.policy.file import Policy
from symdyn.robot.definition import Robot

_AVERAGED = 3


@dataclass(frozen=True)
class Candidate:
    """One way to make a policy of a run.

    Attributes:
        name: what to call it.
        checkpoints: whose mean it is.
        validation: what it does.
    """

    name: str
    checkpoints: tuple[Path, ...]
    validation: Validation


def select(
    run: Path,
    robot: Robot,
    late: int,
    watch: Callable[[int, int], None] = lambda done, total: None,
    judge: Callable[[Policy], Validation] = validate,
) -> Candidate:
    """Export the best candidate as ``RUN/policy.onnx``, and write every candidate's figures to ``RUN/selection.json``.

    Args:
        run: directory of the run.
        robot: that it was trained on.
        late: how many of the last checkpoints are compared.
        watch: called with the candidates that are judged and those there are.
        judge: what validates a policy.

    Raises:
        FileProblem: if the run has no checkpoint, or something cannot be written.
    """
    paths = checkpoint.list_checkpoints(run)[-late:]
    if not paths:
        raise FileProblem(run, "contains no checkpoint to export.")
    options: dict[str, tuple[Path, ...]] = {f"checkpoint {int(path.stem)}": (path,) for path in paths}
    if len(paths) >= _AVERAGED:
        options[f"the mean of the last {_AVERAGED} checkpoints"] = tuple(paths[-_AVERAGED:])
    found = []
    with TemporaryDirectory(prefix="symdyn-selection-") as folder:
        for number, (name, taken) in enumerate(options.items()):
            watch(number, len(options))
            file = export_policy(run, Path(folder) / f"{number}.onnx", taken)
            found.append(Candidate(name, taken, judge(Policy.load(file, robot))))
    watch(len(options), len(options))
    best = min(found, key=lambda candidate: candidate.validation.cost)
    export_policy(run, run / run_dir.POLICY, best.checkpoints)
    table = {c.name: {**asdict(c.validation), "cost": c.validation.cost} for c in found}
    write_json(run / run_dir.SELECTION, {"chosen": best.name, "candidates": table})
    return best
