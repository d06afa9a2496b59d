"""Tables of the observation, the metrics and the gaits, from the definitions that training and evaluation use."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rl.judging.summaries import EXTRA_KEYS
from symdyn.analysis.metrics import KEYS
from symdyn.gait.library import LIBRARY
from symdyn.gait.symmetry import K4, E, classify
from symdyn.gait.timing import GRAVITY, TimingCurve
from symdyn.io.markdown import table
from symdyn.policy.observation import OBSERVATION
from symdyn.robot.definition import GO2
from symdyn.robot.legs import JOINTS, LEG_JOINTS, LEGS


def gait_table() -> list[str]:
    """The library: offsets of each gait."""
    rows = [[f"`{gait.name}`", *(f"{offset:.2f}" for offset in gait.offsets)] for gait in LIBRARY.values()]
    return table(["gait", *(f"θ {leg}" for leg in LEGS)], rows)


def class_table() -> list[str]:
    """The library: K, H with its shifts, legs in phase, time-reversal partner of each gait."""
    rows = []
    for gait in LIBRARY.values():
        found = classify(gait)
        shifts = ", ".join(name if shift == 0.0 else f"{name} after {shift:g}" for name, shift in found.H)
        pairs = ", ".join(" = ".join(pair) for pair in found.symmetric_pairs) or "none"
        partner = found.time_reversal_partner or "not in the library"
        rows.append([f"`{gait.name}`", ", ".join(found.K), shifts, pairs, partner.replace("_", " ")])
    return table(["gait", "K", "H, and after what part of a stride", "legs in phase", "reversed in time"], rows)


def timing_table() -> list[str]:
    """Stride period and duty factor of the paper's curves on the Go2."""
    curve, rows = TimingCurve(), []
    for speed in (0.0, 0.2, 0.5, 1.0, 1.5, 2.0):
        v, length = np.array(speed), GO2.leg_length
        star = speed / math.sqrt(GRAVITY * length)
        rows.append([f"{speed:g}", f"{star:.2f}", f"{curve.period(v, length):.3f}", f"{curve.duty(v, length):.3f}"])
    return table(["v, m/s", "v*", "T, s", "β"], rows)


TABLES = {
    "<!-- gait table -->": gait_table,
    "<!-- class table -->": class_table,
    "<!-- timing table -->": timing_table,
}
"""Comments in pages in whose place a table is put."""


def on_page_markdown(markdown: str, **_: object) -> str:
    """Put the tables into a page."""
    for comment, make in TABLES.items():
        if comment in markdown:
            markdown = markdown.replace(comment, "\n".join(make()))
    return markdown


def pages() -> dict[str, str]:
    """Markdown by path."""
    return {"reference/observation.md": _observation(), "reference/metrics.md": _metrics()}


def _observation() -> str:
    lines = [
        "# Observation",
        "",
        f"The policy sees {OBSERVATION.size} numbers, 50 times a second: those of the paper, section III-C. They are",
        "defined once, in [symdyn.policy.observation][], and training, evaluation and robot assemble them by the same",
        "function. The vector holds scale times value; noise is the half-width of the uniform noise in training,",
        "before scaling. `symdyn gaits --observation` prints this table.",
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


def _action(index: NDArray[np.int64], sign: NDArray[np.float64]) -> str:
    moves = "permuted" if list(index) != list(range(len(index))) else ""
    if len(index) == len(JOINTS):
        flips = f"signs `{_signs(sign[: len(LEG_JOINTS)])}` in each leg"
    else:
        flips = f"signs `{_signs(sign)}`"
    if not (sign < 0).any():
        flips = ""
    return ", ".join(part for part in (moves, flips) if part) or "same"


def _signs(signs: NDArray[np.float64]) -> str:
    return "".join("+" if sign > 0 else "-" for sign in signs)


def _metrics() -> str:
    lines = [
        "# Metrics",
        "",
        "What `metrics.json` of `symdyn evaluate` and `symdyn experiment` holds. Definitions:",
        "[symdyn.analysis.metrics][]; a recording of the robot goes through the same functions.",
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
