"""A log as a report: ``report.md``, ``metrics.json`` and figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from hardware.control.controller import State
from hardware.estimation.kinematics import JointLimits, LegKinematics
from hardware.estimation.settings import ContactConfig
from hardware.logs import figures as log_figures
from hardware.logs import metrics as log_metrics
from hardware.logs import observed as log_observed
from hardware.logs.contents import LogContents
from hardware.logs.markdown import markdown
from hardware.logs.metrics import Segment
from hardware.logs.observed import Observed
from hardware.logs.recording import LONGEST_HOLD_S, Run, runs
from hardware.logs.torque_figure import torques
from hardware.wire.channels import TICK
from symdyn.errors import FileProblem
from symdyn.figures.plots import metric_bars, save
from symdyn.io.files import jsonable, write_json, write_text
from symdyn.robot.definition import Robot

METRICS, REPORT = "metrics.json", "report.md"

_SLOWEST = 0.1
"""m/s; slower, the cost of transport says nothing: there is hardly a distance to divide by."""


@dataclass(frozen=True, eq=False)
class Analysis:
    """What a log shows.

    Attributes:
        metrics: what metrics.json holds.
        figures: by file name, each with its caption; the most telling first.
    """

    metrics: dict[str, Any]
    figures: Mapping[str, tuple[Figure, str]]


def analyse(log: LogContents, robot: Robot, settle_s: float, contact: ContactConfig) -> Analysis:
    """Judge a log.

    Args:
        log: of a session.
        robot: that it is of.
        settle_s: what is left out at the beginning of every segment, s.
        contact: when a foot bears load; only for a log without ticks, which tell.

    Raises:
        FileProblem, ResourceProblem: if the log is of another robot, or the robot's URDF is missing.
    """
    if log.session is not None and log.session.robot != robot.name:
        raise FileProblem(log.path, f"is a log of the robot {log.session.robot!r}, not of {robot.name!r}.")
    kinematics = LegKinematics(robot)
    found = runs(log, kinematics.mass)
    observed = log_observed.observe(log, kinematics, contact) if log.ticks is None else None
    segments = [segment for run in found for segment in log_metrics.segments(run)]
    judged = [log_metrics.judge(segment, settle_s) for segment in segments]
    ticks, session = log.ticks, log.session
    metrics = {
        "log": log.path.name,
        "start": datetime.fromtimestamp(log.start, UTC).isoformat(timespec="seconds"),
        "seconds": log.duration,
        "policy": None if session is None else Path(session.policy).name,
        "policy_sha256": None if session is None else session.policy_sha256,
        "dry": None if session is None else session.dry,
        "problems": [*log.problems, *_missing(log, found)],
        "settle_s": settle_s,
        "runs": [{"begin": run.begin, "end": run.end, "filled": run.filled} for run in found],
        "segments": judged,
        "by_gait": log_metrics.by_gait(judged),
        "observed": None if observed is None else log_observed.summarise(observed, kinematics.mass),
        "timing": None if ticks is None else log_metrics.timing(ticks),
        "arrivals": log_metrics.arrivals(log),
        "timeline": [] if ticks is None else log_metrics.timeline(ticks),
        "keys": {**log_metrics.KEYS, **({} if observed is None else log_observed.KEYS)},
    }
    figures = _figures(log, found, segments, metrics) if observed is None else _observed_figures(log, observed)
    return Analysis(
        metrics, figures | _other_figures(log, robot, metrics, true=any(run.truth is not None for run in found))
    )


def write(analysis: Analysis, out: Path) -> Path:
    """Write metrics.json, the figures and report.md; the report's path. Raises FileProblem."""
    write_json(out / METRICS, jsonable(analysis.metrics))
    for name, (figure, _) in analysis.figures.items():
        save(figure, out / name)
    captions = {name: caption for name, (_, caption) in analysis.figures.items()}
    write_text(out / REPORT, "\n".join(markdown(analysis.metrics, captions)) + "\n")
    return out / REPORT


def _missing(log: LogContents, found: Sequence[Run]) -> list[str]:
    """What the log lacks, a sentence each."""
    if log.ticks is None:
        return [
            f"The log has no messages on {TICK}, which symdyn deploy writes. Commands and gaits are "
            "unknown, so contacts and velocity are shown without them."
        ]
    told = []
    running = sum(1 for state in log.ticks.state if state == State.RUN)
    shown = sum(len(run.gaits) - run.filled for run in found)
    if not running:
        told.append("The policy never ran: there is no gait to judge. Press R1 twice to get from Passive to Run.")
    if (silent := log.duration - float(log.ticks.time[-1])) > 5 * LONGEST_HOLD_S:
        told.append(f"The deployer's last tick is {silent:.1f} s before the end of the log.")
    if filled := sum(run.filled for run in found):
        told.append(f"{filled} ticks were lost; the samples before them are repeated.")
    if shown < running:
        told.append(f"{running - shown} ticks of Run refer to messages that are not in the log and are left out.")
    if len(found) > 1:
        told.append(f"The policy ran {len(found)} times; each time is judged separately.")
    return told


def _figures(
    log: LogContents, found: Sequence[Run], segments: Sequence[Segment], metrics: Mapping[str, Any]
) -> dict[str, tuple[Figure, str]]:
    title = _title(metrics)
    true = any(run.truth is not None for run in found)
    drawn: dict[str, tuple[Figure | None, str]] = {
        "contacts.png": (
            log_figures.contacts(segments, f"Contacts: {title}"),
            f"Commanded stance (hollow), contact sensed by the robot (solid){', truth (black)' if true else ''}. The "
            f"last {log_figures.SHOWN_S:g} s of the fastest steady segment of each gait.",
        ),
        "velocity.png": (
            log_figures.velocity(found, f"Velocity: {title}"),
            "Commanded and estimated velocity"
            + (", and the true one of the simulated robot." if true else "; there is no ground truth."),
        ),
    }
    return {name: (figure, caption) for name, (figure, caption) in drawn.items() if figure is not None}


def _observed_figures(log: LogContents, observed: Observed) -> dict[str, tuple[Figure, str]]:
    true = "" if log.truth is None else ", and the truth"
    return {
        "contacts.png": (
            log_figures.observed_contacts(observed, log.truth, f"Contacts: {log.path.name}"),
            f"Contact by the threshold of the force sensors{true}, in the last {log_figures.SHOWN_S:g} s in which the "
            "robot moved.",
        ),
        "velocity.png": (
            log_figures.observed_velocity(observed, log.truth, f"Velocity: {log.path.name}"),
            f"Velocity estimated by symdyn from the robot's messages{true}.",
        ),
    }


def _other_figures(
    log: LogContents, robot: Robot, metrics: Mapping[str, Any], true: bool
) -> dict[str, tuple[Figure, str]]:
    title = _title(metrics)
    drawn: dict[str, tuple[Figure, str]] = {}
    time, joints = log.sampled_joints()
    if joints:
        drawn["torques.png"] = (
            torques(time, joints, log.ticks, JointLimits.of(robot), f"Torque: {title}"),
            "Torque of every joint, estimated by the motors, over the phase of its leg while the policy "
            "ran (if it never ran: over time).",
        )
    moving = {
        gait: {speed: values for speed, values in of.items() if abs(float(speed)) >= _SLOWEST}
        for gait, of in metrics["by_gait"].items()
    }
    if moving := {gait: of for gait, of in moving.items() if of}:
        distance = "true" if true else "estimated"
        drawn["cot.png"] = (
            metric_bars(moving, "cot", f"Cost of transport: {title}"),
            f"Positive mechanical work per weight and {distance} distance; torque as the motors estimate it.",
        )
    if log.ticks is not None:
        drawn["timing.png"] = (
            log_figures.timing(log.ticks, metrics["timing"], f"Timing: {title}"),
            "One dot per tick; the numbers cover Stand and Run.",
        )
    return drawn


def _title(metrics: Mapping[str, Any]) -> str:
    return metrics["log"] if metrics["policy"] is None else f"{metrics['log']} (policy {metrics['policy']})"
