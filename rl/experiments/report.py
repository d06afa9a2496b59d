"""The results of experiments as files: a folder each, and one page with the paper's figures beside ours."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rl.experiments.result import Result, Subject
from symdyn.analysis import metrics
from symdyn.figures.plots import save
from symdyn.io.files import jsonable, write_json, write_text
from symdyn.io.markdown import number, table

METRICS, REPORT = "metrics.json", "report.md"


def write(result: Result, subject: Subject, out: Path) -> Path:
    """Write ``OUT/NAME`` with metrics.json, figures and report.md.

    Args:
        result: of one experiment.
        subject: what was tried.
        out: directory of all experiments.

    Returns:
        The report.

    Raises:
        FileProblem: if something cannot be written.
    """
    folder = out / result.name
    content = {
        "experiment": result.name,
        "policy": subject.path.name,
        "samples": subject.policy.metadata.training.get("samples"),
        "seeds": list(subject.seeds),
        "protocol": result.protocol,
        "targets": [{**vars(target), "met": target.met} for target in result.targets],
        **result.metrics,
        "keys": dict(metrics.KEYS),
    }
    write_json(folder / METRICS, jsonable(content))
    for name, (figure, _) in result.figures.items():
        save(figure, folder / name)
    lines = [f"# {result.title}", "", *_body(result, subject, "")]
    write_text(folder / REPORT, "\n".join(lines) + "\n")
    return folder / REPORT


def write_summary(results: Sequence[Result], subject: Subject, out: Path) -> Path:
    """Write ``OUT/report.md``: what is not reached first, then every experiment. Raises FileProblem."""
    targets = [(result, target) for result in results for target in result.targets if not target.hypothesis]
    missed = [(result, target) for result, target in targets if not target.met]
    lines = [f"# Experiments with {subject.path.name}", "", _policy_line(subject), ""]
    lines += [f"{len(targets) - len(missed)} of {len(targets)} goals are reached.", ""]
    if missed:
        rows = [[r.name, t.what, number(t.here), t.limit, t.paper] for r, t in missed]
        lines += ["Not reached:", "", *table(["experiment", "what", "here", "goal", "paper"], rows), ""]
    for result in results:
        lines += [f"## {result.name}: {result.title}", "", *_body(result, subject, f"{result.name}/"), ""]
    write_text(out / REPORT, "\n".join(lines))
    return out / REPORT


def _body(result: Result, subject: Subject, prefix: str) -> list[str]:
    lines = [result.protocol, "", f"Seeds {_seeds(subject.seeds)}. Nominal model unless said otherwise.", ""]
    if result.targets:
        rows = [[t.what, t.paper, t.limit, number(t.here), "yes" if t.met else "**no**"] for t in result.targets]
        wanted = "hypothesis" if all(t.hypothesis for t in result.targets) else "goal"
        verdict = "confirmed" if wanted == "hypothesis" else "reached"
        lines += [*table(["what", "paper", wanted, "here", verdict], rows), ""]
    for remark in result.remarks:
        lines += [remark, ""]
    for name, (_, caption) in result.figures.items():
        lines += [f"![{caption}]({prefix}{name})", "", f"*{caption}*", ""]
    return lines[:-1]


def _policy_line(subject: Subject) -> str:
    training = subject.policy.metadata.training
    samples = training.get("samples")
    known = "unknown" if samples is None else f"{samples / 1e6:.1f} million samples"
    return f"Policy `{subject.path.name}`, trained with {known} (the paper: 2460 million)."


def _seeds(seeds: Sequence[int]) -> str:
    return ", ".join(str(seed) for seed in seeds)
