"""Whether a solution of the equations is a gait: legs push, swing forward and touch down from above."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slip.model.unknowns import DALPHA, DPHI, DX, DY, EVENT_NAMES, Y
from slip.orbits import kernel
from slip.orbits.stride import Stride

Vector = NDArray[np.float64]

PULL = -1e-9
"""A leg on the ground may not carry less than this [M g]."""

FLATTEST = 1.35
"""Largest angle of a leg to the vertical at touchdown or lift-off [rad]; 77 degrees: beyond, nothing runs."""

DIP = -1e-7
"""Height above which the foot of a leg that swings back must stay [torso length]."""


def objection(stride: Stride, parameters: Vector) -> str | None:
    """Why a stride that solves the equations is no gait, or None.

    A leg touches down while it swings back (retracts), the first time that its foot meets the ground then; on its way
    forward the foot may dip below (the leg is massless, and an animal bends it). These are the families of the
    literature; the equations have other solutions, in which a foot is stopped on its way forward or passes the ground.

    Args:
        stride: an orbit.
        parameters: (7,).
    """
    if stride.segments[0].rates[0, 0, DY] >= 0.0:
        return "the torso is no longer at the top of its path at the apex"
    speed = stride.segments[0].starts[0][DX]
    direction = np.sign(speed) if abs(speed) > 1e-6 else 0.0
    for i, event in enumerate(stride.events):
        before = stride.segments[i].end
        leg = int(event) // 2
        _, _, theta = kernel.energy_and_forces()(before, stride.contacts[i], parameters)
        if abs(float(theta[leg, 0])) > FLATTEST:
            return "a leg lies nearly flat"
        if EVENT_NAMES[event].startswith("touchdown") and direction * (before[DALPHA[leg]] + before[DPHI]) > 1e-6:
            return "a leg would touch down while it swings forward"
    for i, (segment, contact) in enumerate(zip(stride.segments, stride.contacts, strict=True)):
        if stride.bounds[i + 1] == stride.bounds[i]:
            continue
        on_ground = contact > 0.0
        for state in (*segment.starts, segment.end):
            _, forces, _ = kernel.energy_and_forces()(state, contact, parameters)
            if on_ground.any() and forces[on_ground, 0].min() < PULL:
                return "a leg would have to pull"
            if state[Y] <= 0.0:
                return "the torso is on the ground"
            heights, *_ = kernel.event()(state, parameters)
            swings_back = direction * (state[list(DALPHA)] + state[DPHI]) < 0.0
            if np.any(~on_ground & swings_back & (heights[:, 0] < DIP)):
                return "a foot would meet the ground too early, while it swings back"
    return None
