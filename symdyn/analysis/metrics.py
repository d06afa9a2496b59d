"""How well a robot did what it was told: the metrics of the paper (section III-G) and some that it lacks.

GC_stance compares contacts with the clock sample by sample, so that a gait executed perfectly but late, and another
gait altogether, may score alike. The measures on strides (symdyn.analysis.footfall) tell the two apart: a common lag is
not an error of the pattern, and the pattern has a name and a symmetry.

Everything here is a function of plain arrays; :func:`summarise` applies all of it to a recording. Where there is
nothing to judge (no whole stride, or none in which every leg lands once) a measure on strides is nan.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from symdyn.analysis.footfall import Strides, cut_strides
from symdyn.analysis.recording import Floats, Recording
from symdyn.errors import InvalidValue
from symdyn.gait import library as gaits
from symdyn.gait.library import Gait, wrap
from symdyn.gait.symmetry import K4, PAIRS, E, classify, pair_joint_signs, pairs_in_phase
from symdyn.robot.legs import LEG_JOINTS, LEGS

RMSNE_EPSILON = 0.1
"""m/s for v_x and v_y, rad/s for the yaw rate: the paper's epsilon, whose value it does not state.

It decides the metric: the lateral and yaw commands are mostly zero, and an error of 0.1 m/s then counts as 100%. At a
tenth the error of the paper's slowest command, 0.2 m/s, is judged against 0.3 m/s; values with another epsilon do not
compare."""

SETTLING_SHARE = 0.1
"""Of the commanded speed: the band within which a speed counts as settled, but at least SETTLING_FLOOR."""

SETTLING_FLOOR = 0.1
"""m/s."""

KEYS: Mapping[str, str] = MappingProxyType(
    {
        "gc_stance": "1: share of time that feet are in the wrong contact state; 0 is perfect (paper)",
        "gc_morph": "rad: difference in joint angles between legs in phase, summed over pairs, mean over time (paper)",
        "gc": "1: gait consistency, gc_stance + gc_morph (paper)",
        "rmsne": f"1: root mean square normalised velocity error, epsilon {RMSNE_EPSILON:g} (paper)",
        "cot": "1: cost of transport, positive mechanical work divided by weight and distance (paper)",
        "speed": "m/s: mean forward velocity over whole strides",
        "speed_error": "m/s: error of the mean forward velocity over whole strides",
        "y_error": "m/s: error of the mean lateral velocity over whole strides",
        "yaw_error": "rad/s: error of the mean yaw rate over whole strides",
        "settling_time": "s: until the stride-averaged forward velocity stays near the command; inf if it never does",
        "phase_error": "strides: mean error of a touchdown phase, without the lag that is common to all legs",
        "phase_lag": "strides: mean delay of the touchdowns (negative: early)",
        "duty_error": "1: mean error of the duty factor of a leg",
        "gait_identity": "1: share of strides in the commanded gait: it is the nearest gait of the library",
        "symmetry_residual": "strides: mean deviation of the touchdowns from the symmetry H of the commanded gait",
    }
)
"""What :func:`summarise` returns, as ``unit: meaning``; 1 is the unit of a bare number."""


def rmsne(command: Floats, actual: Floats, epsilon: float = RMSNE_EPSILON) -> float:
    """Root mean square normalised error of the velocity (paper, section III-G.1).

    sqrt( 1/T sum_t sum_d ((command_d - actual_d) / (|command_d| + epsilon))^2 ), d over v_x, v_y and yaw rate.

    Args:
        command: (S, 3) m/s, m/s, rad/s.
        actual: (S, 3) alike.
        epsilon: m/s or rad/s, see :data:`RMSNE_EPSILON`.
    """
    normalised = (command - actual) / (np.abs(command) + epsilon)
    return float(np.sqrt(np.mean(np.sum(normalised**2, axis=1))))


def gc_stance(contact: NDArray[np.bool_], desired: NDArray[np.bool_]) -> float:
    """Share of legs and samples in the wrong state of stance and swing (paper, section III-G.2). (S, 4), (S, 4)."""
    return float(np.mean(contact != desired))


def gc_morph(joint_pos: Floats, offsets: Floats) -> float:
    """Time mean of sum over pairs in phase of |q_a - q_b|, rad (paper, section III-G.2).

    The pairs are those of the reward, that share an offset at that time; legs of opposite sides are compared as mirror
    images (:func:`symdyn.gait.symmetry.pair_joint_signs`). A pronk has six such pairs, a bound two, a rotary gallop
    none: only values of one gait compare.

    Args:
        joint_pos: (S, 12) rad.
        offsets: (S, 4) theta.
    """
    legs = joint_pos.reshape(-1, len(LEGS), len(LEG_JOINTS))
    first, second = (list(side) for side in zip(*PAIRS, strict=True))
    distance = np.linalg.norm(legs[:, first] - pair_joint_signs() * legs[:, second], axis=2)
    return float(np.mean(np.sum(distance * pairs_in_phase(offsets), axis=1)))


def gc(contact: NDArray[np.bool_], desired: NDArray[np.bool_], joint_pos: Floats, offsets: Floats) -> float:
    """GC_stance + GC_morph (paper, section III-G.2)."""
    return gc_stance(contact, desired) + gc_morph(joint_pos, offsets)


def cost_of_transport(
    torque: Floats, joint_vel: Floats, dt: float, mass: float, gravity: float, displacement: float
) -> float:
    """Positive mechanical work per weight and net distance (paper, section III-G.3); inf on the spot.

    Args:
        torque: (S, 12) N m.
        joint_vel: (S, 12) rad/s.
        dt: s.
        mass: kg.
        gravity: m/s^2.
        displacement: net forward displacement, m; its sign does not count.
    """
    work = float(np.sum(np.maximum(torque * joint_vel, 0.0))) * dt
    return work / (mass * gravity * abs(displacement)) if displacement else float("inf")


def stride_average(values: Floats, period: Floats, dt: float) -> Floats:
    """Trailing mean over the last commanded stride, or over what there is of it at the start.

    Samples hold for ``dt``; a window that begins within one takes its share, so that what repeats with the stride
    averages out although a stride is no whole number of samples.

    Args:
        values: (S,).
        period: (S,) commanded stride period, s.
        dt: s.

    Returns:
        (S,).
    """
    edges = dt * np.arange(len(values) + 1)
    integral = np.concatenate([[0.0], np.cumsum(values) * dt])
    begins = np.maximum(edges[1:] - period, 0.0)
    return (integral[1:] - np.interp(begins, edges, integral)) / (edges[1:] - begins)


def settling_time(time: Floats, speed: Floats, command: float, period: Floats, tolerance: float | None = None) -> float:
    """Time until the stride-averaged speed is near the command for good, s; inf if it is not at the end.

    Args:
        time: (S,) s, evenly spaced.
        speed: (S,) m/s, as measured.
        command: m/s.
        period: (S,) commanded stride period, s.
        tolerance: m/s; SETTLING_SHARE of the command, at least SETTLING_FLOOR, if None.
    """
    if tolerance is None:
        tolerance = max(SETTLING_SHARE * abs(command), SETTLING_FLOOR)
    dt = float(time[-1] - time[0]) / max(len(time) - 1, 1)
    outside = np.flatnonzero(
        ~(np.abs(stride_average(speed, period, dt) - command) <= tolerance)
    )  # so that nan is outside
    if not len(outside):
        return 0.0
    last = int(outside[-1])
    return float(time[last + 1] - time[0]) if last + 1 < len(time) else float("inf")


def phase_error(strides: Strides) -> float:
    """Mean distance of the touchdowns from the commanded pattern, each stride's common lag removed, in strides.

    Over legs and complete strides. 0 is the commanded pattern, legs that land at random give 0.16, the worst is 0.25.
    """
    late = _lateness(strides)
    return _mean(np.abs(wrap(late - _circular_mean(late)[:, None])))


def phase_lag(strides: Strides) -> float:
    """How much later than commanded the legs land, the circular mean over legs and complete strides, in [-0.5, 0.5)."""
    lags = _circular_mean(_lateness(strides))
    return float(_circular_mean(lags[None, :])[0]) if len(lags) else float("nan")


def duty_error(strides: Strides) -> float:
    """Mean distance of the duty factors from the commanded one, over legs and all strides: a leg that drags counts."""
    return _mean(np.abs(strides.duty - strides.commanded_duty[:, None]))


def gait_identity(strides: Strides, commanded_name: str) -> float:
    """Share of strides that show the commanded gait; one in which a leg does not land once shows none.

    Raises:
        UnknownName: if the library has no such gait.
    """
    gaits.get(commanded_name)
    return _mean(np.array([name == commanded_name for name in strides.gait], dtype=np.float64))


def symmetry_residual(strides: Strides) -> float:
    """How far the touchdowns are from having the symmetry of the commanded gait, in strides.

    Every element h of H of the commanded gait (symdyn.gait.symmetry.classify) but the identity says that the pattern,
    its legs permuted by h, is the pattern shifted by a known phase. The residual is the mean circular difference of the
    two
    over elements, legs and complete strides: another gait with the same H, or a late one, has none. 0 where H is
    trivial.
    """
    whole = strides.complete
    realised, commanded = -strides.delays[whole], strides.commanded_offsets[whole]
    residual = np.zeros(len(realised))
    for offsets in np.unique(commanded, axis=0):
        shown = (commanded == offsets).all(axis=1)
        residual[shown] = _residual(realised[shown], Gait.wrapped("commanded", offsets))
    return _mean(residual)


def _residual(realised: Floats, gait: Gait) -> Floats:
    """Mean over H and legs of the difference between image and shifted pattern, (n,). ``realised``: (n, 4) offsets."""
    elements = {element.name: element for element in K4 if element != E}
    differences = [
        np.abs(wrap(realised[:, list(elements[name].leg_index)] - realised - shift))
        for name, shift in classify(gait).H
        if name in elements
    ]
    return np.mean(differences, axis=(0, 2)) if differences else np.zeros(len(realised))


def summarise(
    recording: Recording, gait_name: str, settle_s: float = 1.0, time_reversal: bool = True
) -> dict[str, float]:
    """Every metric of :data:`KEYS` for a recording of one commanded gait and velocity.

    Args:
        recording: from the moment of the command on.
        gait_name: the commanded gait, of the library.
        settle_s: what comes before counts for ``settling_time`` only, s.
        time_reversal: whether the leg phase ran backwards with the robot; False for that ablation.

    Raises:
        UnknownName: if the library has no such gait.
        InvalidValue: if nothing is left after ``settle_s``.
    """
    settled = recording.between(settle_s, float(recording.dt * len(recording.contact)))
    if not len(settled.contact):
        seconds = float(recording.dt * len(recording.contact))
        raise InvalidValue("The length of a recording", seconds, f"more than the {settle_s:g} s that are left out")
    strides = cut_strides(settled, time_reversal=time_reversal)
    whole = np.zeros(len(settled.contact), dtype=np.bool_)
    for start, stop in zip(strides.start, strides.stop, strict=True):
        whole[start:stop] = True
    if not whole.any():
        whole[:] = True
    error_x, error_y, error_yaw = np.abs((settled.velocity_h - settled.velocity_command)[whole].mean(axis=0))
    stance = gc_stance(settled.contact, settled.desired_stance)
    morph = gc_morph(settled.joint_pos, settled.offsets)
    distance = float(settled.velocity_h[:, 0].sum()) * settled.dt
    return {
        "gc_stance": stance,
        "gc_morph": morph,
        "gc": stance + morph,
        "rmsne": rmsne(settled.velocity_command, settled.velocity_h),
        "cot": cost_of_transport(
            settled.joint_torque, settled.joint_vel, settled.dt, settled.mass, settled.gravity, distance
        ),
        "speed": float(settled.velocity_h[whole, 0].mean()),
        "speed_error": float(error_x),
        "y_error": float(error_y),
        "yaw_error": float(error_yaw),
        "settling_time": settling_time(
            recording.time, recording.velocity_h[:, 0], float(recording.velocity_command[-1, 0]), recording.period
        ),
        "phase_error": phase_error(strides),
        "phase_lag": phase_lag(strides),
        "duty_error": duty_error(strides),
        "gait_identity": gait_identity(strides, gait_name),
        "symmetry_residual": symmetry_residual(strides),
    }


def _lateness(strides: Strides) -> Floats:
    """Realised minus commanded touchdown of the complete strides, (m, 4)."""
    return wrap(strides.delays - strides.commanded_delays)[strides.complete]


def _circular_mean(phases: Floats) -> Floats:
    """Mean direction of the last axis, in [-0.5, 0.5). (n, m) -> (n,)."""
    return wrap(np.angle(np.mean(np.exp(2j * np.pi * phases), axis=-1)) / (2.0 * np.pi))


def _mean(values: Floats) -> float:
    return float(np.mean(values)) if values.size else float("nan")
