"""The observation and the metrics as tables, from the definitions that training and evaluation use."""

from __future__ import annotations

from rl.summaries import EXTRA_KEYS
from symdyn.legs import JOINTS
from symdyn.metrics import KEYS
from symdyn.observation import OBSERVATION
from symdyn.symmetry import K4, E


def pages() -> dict[str, str]:
    """Markdown by path."""
    return {"reference/observation.md": _observation(), "reference/metrics.md": _metrics()}


def _observation() -> str:
    lines = [
        "# Observation",
        "",
        f"The policy sees {OBSERVATION.size} numbers, 50 times a second: those of the paper, section III-C. They are",
        "defined once, in [symdyn.observation][], and training, evaluation and robot assemble them by the",
        "same function. The vector holds scale × value; noise is the half-width of the uniform noise in training, before",
        "scaling. `symdyn gaits --observation` prints this table.",
        "",
        "| index | term | unit | scale | noise | order | meaning |",
        "|---|---|---|---|---|---|---|",
    ]
    for term in OBSERVATION.terms:
        where = OBSERVATION.slices[term.name]
        order = "joints" if term.labels == JOINTS else ", ".join(term.labels)
        noise = f"± {term.noise:g}" if term.noise else "-"
        numbers = f"{where.start} to {where.stop - 1}"
        lines.append(
            f"| {numbers} | `{term.name}` | {term.unit} | {term.scale:g} | {noise} | {order} | {term.meaning} |"
        )
    lines += [
        "",
        f"Joints: {', '.join(JOINTS)}.",
        "",
        "## Under the group",
        "",
        "How an element of the [body's group](../theory/symmetry.md) acts on each term follows from what the term is:",
        "a vector, a rotation, joints or legs.",
        "",
        f"| term | kind | {' | '.join(g.name for g in K4 if g != E)} |",
        "|---|---|" + "---|" * (len(K4) - 1),
    ]
    for term in OBSERVATION.terms:
        actions = [_action(*term.mirror(g)) for g in K4 if g != E]
        lines.append(f"| `{term.name}` | {term.kind.removesuffix('_b').replace('_', ' ')} | {' | '.join(actions)} |")
    return "\n".join(lines) + "\n"


def _action(index, sign) -> str:
    moves = "permuted" if list(index) != list(range(len(index))) else ""
    if len(index) == len(JOINTS):
        flips = "signs " + "".join("+" if s > 0 else "−" for s in sign[:3]) + " in each leg"
    else:
        flips = "signs " + "".join("+" if s > 0 else "−" for s in sign)
    if not (sign < 0).any():
        flips = ""
    return ", ".join(part for part in (moves, flips) if part) or "same"


def _metrics() -> str:
    lines = [
        "# Metrics",
        "",
        "What `metrics.json` of `symdyn evaluate` and `symdyn experiment` holds. Definitions:",
        "[symdyn.metrics][]; a recording of the robot goes through the same functions.",
        "",
        "| key | unit | meaning |",
        "|---|---|---|",
    ]
    for key, text in KEYS.items():
        unit, _, meaning = text.partition(": ")
        lines.append(f"| `{key}` | {unit} | {meaning} |")
    lines += ["", "Beside them:", "", "| key | meaning |", "|---|---|"]
    lines += [f"| `{key}` | {meaning} |" for key, meaning in EXTRA_KEYS.items()]
    return "\n".join(lines) + "\n"
