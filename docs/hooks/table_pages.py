"""Tables of observation, metrics, gaits and robot files, from the definitions that training and evaluation use."""

from __future__ import annotations

import math

import numpy as np
from architecture_tables import TABLES as ARCHITECTURE_TABLES
from numpy.typing import NDArray
from robot_file_tables import TABLES as ROBOT_FILE_TABLES

from rl.judging.summaries import EXTRA_KEYS
from symdyn.analysis.metrics import KEYS
from symdyn.gait.library import LIBRARY
from symdyn.gait.symmetry import K4, E, classify
from symdyn.gait.timing import GRAVITY, TimingCurve
from symdyn.io.markdown import table
from symdyn.policy.observation import LAYOUTS, TERMS
from symdyn.robot.legs import JOINTS, LEG_JOINTS, LEGS
from symdyn.robot.robot_file import DEFAULT_ROBOT, get_robot


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
    """Stride period and duty factor of the paper's curves on the robot that commands take where none is given."""
    curve, robot, rows = TimingCurve(), get_robot(DEFAULT_ROBOT), []
    for speed in (0.0, 0.2, 0.5, 1.0, 1.5, 2.0):
        v, length = np.array(speed), robot.leg_length
        star = speed / math.sqrt(GRAVITY * length)
        rows.append([f"{speed:g}", f"{star:.2f}", f"{curve.period(v, length):.3f}", f"{curve.duty(v, length):.3f}"])
    return table(["v, m/s", "v*", "T, s", "β"], rows)


TABLES = {
    "<!-- gait table -->": gait_table,
    "<!-- class table -->": class_table,
    "<!-- timing table -->": timing_table,
    **ROBOT_FILE_TABLES,
    **ARCHITECTURE_TABLES,
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
    sizes = [f"`{name}` ({layout.size} numbers)" for name, layout in LAYOUTS.items()]
    lines = [
        "# Observation",
        "",
        "What a policy sees is an *observation*: a list of terms in a fixed order. Training knows",
        f"{' and '.join(sizes)}. `paper` is section III-C of the paper.",
        "`extended` adds the cosine of the clock (the sine alone has each value twice in a stride) and the gyroscope.",
        "",
        "- Training chooses one by name: [`--env.observation`](settings.md#env).",
        "- The policy file contains its own table: name, size and scale of each term. Evaluation and robot assemble",
        "  the observation that the file describes, at the rate of the robot's `control_dt`.",
        "- Training, evaluation and robot call the same function, [observe][symdyn.policy.observation.observe].",
        "",
        "The vector holds scale times value. Noise is the half-width of the uniform noise in training, before scaling.",
        "A column *index in* is the place of the term in that observation; `-`: the observation lacks the term.",
        "`symdyn gaits --observation` prints the same tables. [Add an observation term](../howto/observation.md)",
        "extends them.",
        "",
    ]
    ranges = {name: layout.slices for name, layout in LAYOUTS.items()}
    rows = []
    for term in TERMS.values():
        held = [slices.get(term.name) for slices in ranges.values()]
        indices = [f"{where.start} to {where.stop - 1}" if where else "-" for where in held]
        order = "joints" if term.labels == JOINTS else ", ".join(term.labels)
        noise = f"± {term.noise:g}" if term.noise else "-"
        rows.append([f"`{term.name}`", *indices, term.unit, f"{term.scale:g}", noise, order, term.meaning])
    lines += table(
        ["term", *(f"index in `{name}`" for name in LAYOUTS), "unit", "scale", "noise", "order", "meaning"], rows
    )
    lines += [
        "",
        f"Joints: {', '.join(JOINTS)}.",
        "",
        "## Under the group",
        "",
        "How an element of the [body's group](../theory/symmetry.md) acts on a term follows from the kind of the term:",
        "a vector, a rotation, joints or legs.",
        "",
    ]
    elements = [g for g in K4 if g != E]
    rows = []
    for term in TERMS.values():
        kind = term.kind.removesuffix("_b").replace("_", " ")
        rows.append([f"`{term.name}`", kind, *(_action(*term.mirror(g)) for g in elements)])
    lines += table(["term", "kind", *(g.name for g in elements)], rows)
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
        "The keys of `metrics.json`, which `symdyn evaluate` and `symdyn experiment` write. Definitions:",
        "[symdyn.analysis.metrics][]; a recording of the robot goes through the same functions.",
        "",
        "| key | unit | meaning |",
        "|---|---|---|",
    ]
    for key, text in KEYS.items():
        unit, _, meaning = text.partition(": ")
        lines.append(f"| `{key}` | {unit} | {meaning} |")
    lines += ["", "In addition:", "", "| key | meaning |", "|---|---|"]
    lines += [f"| `{key}` | {meaning} |" for key, meaning in EXTRA_KEYS.items()]
    return "\n".join(lines) + "\n"
