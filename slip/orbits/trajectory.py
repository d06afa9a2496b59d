"""A stride of an orbit, sampled in time: states, forces on the ground, hips and feet in the world."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slip.model.unknowns import DX, FRONT, PHI, SLIP_LEGS, Y
from slip.orbits import kernel
from slip.orbits.orbit import Orbit
from symdyn.errors import InvalidValue

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class Trajectory:
    """One stride from apex to apex. Legs are in the order of slip.model.unknowns.SLIP_LEGS.

    Attributes:
        time: (n,) [sqrt(torso length / g)].
        x: horizontal position of the torso, zero at the start, (n,) [torso length].
        state: (n, 13), named by slip.model.unknowns.STATE_NAMES.
        contact: (n, 4) bool.
        force_w: ground reaction force on each foot, horizontal and vertical, (n, 4, 2) [M g].
        hip_w: horizontal and vertical position, (n, 4, 2) [torso length].
        foot_w: the same for the feet; a swinging leg has its rest length, so its foot may pass below the ground (in the
            model it is massless and does not touch), (n, 4, 2).
        energy: (n,) [M g torso length].
    """

    time: Vector
    x: Vector
    state: Matrix
    contact: NDArray[np.bool_]
    force_w: NDArray[np.float64]
    hip_w: NDArray[np.float64]
    foot_w: NDArray[np.float64]
    energy: Vector


def sample(orbit: Orbit, samples: int = 200) -> Trajectory:
    """The stride at ``samples`` even times from 0 to T, both included.

    At an event the sample shows the leg as it is after it.

    Raises:
        InvalidValue: for fewer than two samples.
    """
    if samples < 2:
        raise InvalidValue("samples", samples, "at least 2")
    vector, stride = orbit.parameters.vector(), orbit.stride
    durations = np.diff(stride.bounds)
    starts = np.concatenate([segment.starts for segment in stride.segments])
    contacts = np.repeat(stride.contacts, [len(segment.fractions) for segment in stride.segments], axis=0)
    lengths = np.concatenate([s.fractions * d for s, d in zip(stride.segments, durations, strict=True)])
    at = np.concatenate(([0.0], np.cumsum(lengths)[:-1]))
    distance = np.concatenate(([0.0], np.cumsum(orbit.step_distances)[:-1]))

    time = np.linspace(0.0, orbit.period, samples)
    step = np.searchsorted(at, time, side="right") - 1
    state = np.zeros((samples, kernel.STATES))
    x, energy, tension = np.zeros(samples), np.zeros(samples), np.zeros((samples, len(SLIP_LEGS)))
    theta = np.zeros_like(tension)
    for i, j in enumerate(step):
        elapsed = time[i] - at[j]
        state[i] = kernel.step()(starts[j], contacts[j], vector, elapsed)[0][:, 0]
        rate_before = kernel.rate()(starts[j], contacts[j], vector)[0][DX, 0]
        rate_after = kernel.rate()(state[i], contacts[j], vector)[0][DX, 0]
        x[i] = distance[j] + 0.5 * elapsed * (starts[j, DX] + state[i, DX])
        x[i] += elapsed**2 / 12.0 * (rate_before - rate_after)
        total, forces, angles = kernel.energy_and_forces()(state[i], contacts[j], vector)
        energy[i], tension[i], theta[i] = total[0, 0], forces[:, 0], angles[:, 0]

    contact = contacts[step] > 0.0
    hip_offset = np.array(
        [(1.0 if i in FRONT else 0.0) - orbit.parameters.hind_distance for i in range(len(SLIP_LEGS))]
    )
    phi = state[:, PHI, None]
    hip_w = np.stack((x[:, None] + hip_offset * np.cos(phi), state[:, Y, None] + hip_offset * np.sin(phi)), axis=-1)
    along = np.stack((np.sin(theta), -np.cos(theta)), axis=-1)
    length = np.where(contact, hip_w[..., 1] / np.cos(theta), orbit.parameters.rest_length)
    foot_w = hip_w + length[..., None] * along
    return Trajectory(time, x, state, contact, -tension[..., None] * along, hip_w, foot_w, energy)
