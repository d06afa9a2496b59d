"""Measured against simulated, before the fit and after: each joint by itself, the rest of the robot as measured."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from hardware.control.excitation import CHIRP_S, MOVE_S, STEPS_S, SWEEP_S, TURN_S
from hardware.identification.leg_dynamics import FloatingRobot, Motion
from hardware.identification.signals import PERIOD, Floats, Signals
from symdyn.robot.fit import Fit
from symdyn.robot.legs import JOINTS, LEG_JOINTS, LEGS

_SHOWN_S = 2.0  # of the chirp's end and of the steps


@dataclass(frozen=True, eq=False)
class Course:
    """A joint during its chirp and its steps, N samples.

    Attributes:
        time: (N,) s from the start of the chirp.
        target: (N,) rad.
        measured: (N,) rad.
        before: (N,) simulated with the model's motor, rad.
        after: (N,) simulated with the fitted one, rad.
    """

    time: Floats
    target: Floats
    measured: Floats
    before: Floats
    after: Floats

    @property
    def errors(self) -> tuple[float, float]:
        """Root mean squares of simulated less measured, before and after, rad."""
        before, after = (float(np.sqrt(np.mean((one - self.measured) ** 2))) for one in (self.before, self.after))
        return before, after


def courses(signals: Signals, fit: Fit, model: dict[str, Floats], body: FloatingRobot) -> list[Course]:
    """Of every joint of a robot that hung.

    Args:
        signals: of the log.
        fit: found from it.
        model: what the robot's model has, as hardware.identification.identify.nominal.
        body: the robot.
    """
    motion = Motion.of(signals)
    fitted = {name: fit.values(name) for name in model}
    found = []
    for joint in range(len(JOINTS)):
        begin = round((MOVE_S + TURN_S * joint + SWEEP_S) / PERIOD)
        rows = np.arange(begin, min(begin + round((CHIRP_S + STEPS_S) / PERIOD), len(signals.time)))
        runs = [_simulated(signals, motion, body, joint, rows, its) for its in (model, fitted)]
        found.append(
            Course(
                signals.time[rows] - signals.time[rows[0]],
                signals.commanded(signals.time[rows])[:, joint],
                signals.pos[rows, joint],
                *runs,
            )
        )
    return found


def _simulated(
    signals: Signals, motion: Motion, body: FloatingRobot, joint: int, rows: np.ndarray, its: dict[str, Floats]
) -> Floats:
    kp, kd = its["kp"][joint] * signals.kp[joint], its["kd"][joint] * signals.kd[joint]
    strength, friction, damping = (its[name][joint] for name in ("strength", "friction", "damping"))
    offset, armature = its["offset"][joint], its["armature"][joint]
    targets = signals.commanded(signals.time[rows] - its["delay"][joint])[:, joint]
    pos, vel = motion.pos[rows[0], joint] - offset, motion.vel[rows[0], joint]
    found = np.empty(len(rows))
    for k, row in enumerate(rows):
        found[k] = pos + offset
        all_pos, still, pushed = motion.pos[row].copy(), motion.acc[row].copy(), motion.acc[row].copy()
        all_pos[joint], still[joint], pushed[joint] = pos, 0.0, 1.0
        load = body.torques(motion, row, all_pos, still)[joint]
        inertia = body.torques(motion, row, all_pos, pushed)[joint] - load + armature
        # implicit in what grows with the speed; dry friction brakes to a stop at most
        given = strength * kp * (targets[k] - pos - offset - PERIOD * vel) - load
        vel = (vel + PERIOD / inertia * given) / (1.0 + PERIOD / inertia * (strength * kd + damping))
        vel = np.sign(vel) * max(abs(vel) - PERIOD / inertia * friction, 0.0)
        pos += PERIOD * vel
    return found


def figure(found: list[Course], title: str) -> Figure:
    """The end of each joint's chirp and its steps; the title of a panel has the errors of its whole course."""
    drawing = Figure(figsize=(15.0, 8.5), layout="constrained")
    panels = drawing.subplots(len(LEG_JOINTS), len(LEGS), sharex=True, squeeze=False)
    for i, (joint, course) in enumerate(zip(JOINTS, found, strict=True)):
        axes = panels[i % len(LEG_JOINTS), i // len(LEG_JOINTS)]
        shown = course.time >= CHIRP_S - _SHOWN_S
        for values, colour, width, label in (
            (course.target, "0.75", 1.0, "target"),
            (course.measured, "black", 2.0, "measured"),
            (course.before, "tab:orange", 1.0, "simulated, model"),
            (course.after, "tab:blue", 1.0, "simulated, fit"),
        ):
            axes.plot(course.time[shown], values[shown], color=colour, linewidth=width, label=label)
        before, after = (1e3 * error for error in course.errors)
        axes.set_title(f"{joint}: {before:.1f} before, {after:.1f} mrad after", fontsize=9)
        axes.grid(color="0.9")
        if i % len(LEG_JOINTS) == len(LEG_JOINTS) - 1:
            axes.set_xlabel("time from the start of the chirp [s]")
        if i < len(LEG_JOINTS):
            axes.set_ylabel(f"{LEG_JOINTS[i]} [rad]")
    panels[0, 0].legend(fontsize=7, loc="upper left")
    drawing.suptitle(f"{title}\nroot mean square of simulated less measured position in each title", fontsize=10)
    return drawing
