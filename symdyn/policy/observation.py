"""What the policy sees: the paper's 52 numbers, once, for training, evaluation and robot alike.

:data:`TERMS` is the only place where order, size, scale and noise stand. Everything else (slices, the vector, its
mirror image, the table in the policy file) is derived from it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from array_api_compat import array_namespace
from numpy.typing import NDArray

from symdyn.arrays import Array
from symdyn.errors import SymdynError
from symdyn.gait.symmetry import Spatial
from symdyn.robot.legs import JOINTS, LEGS

Kind = Literal["polar_b", "axial_b", "joint", "planar_velocity_b", "leg", "invariant"]


@dataclass(frozen=True)
class Term:
    """One named part of an observation vector.

    Attributes:
        name: its key in :func:`assemble`.
        labels: what each number is; their count is the size.
        unit: before scaling.
        scale: the vector holds scale * value.
        noise: half-width of the uniform noise in training, in ``unit`` (Table III of the paper).
        kind: how a group element acts: ``polar_b`` by R; ``axial_b`` by det(R) R; ``joint`` by permutation and signs;
            ``planar_velocity_b`` (v_x, v_y by R, the yaw rate by det(R) R); ``leg`` by permutation; ``invariant`` not
            at all.
        meaning: one line.
    """

    name: str
    labels: tuple[str, ...]
    unit: str
    scale: float
    noise: float
    kind: Kind
    meaning: str

    @property
    def size(self) -> int:
        """How many numbers."""
        return len(self.labels)

    def mirror(self, element: Spatial) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """(index, sign), both (size,), such that ``sign * x[..., index]`` is the transformed term."""
        same, ones = np.arange(self.size), np.ones(self.size)
        match self.kind:
            case "polar_b":
                return same, element.reflection_b
            case "axial_b":
                return same, element.axial_reflection_b
            case "planar_velocity_b":
                return same, np.array([*element.reflection_b[:2], element.axial_reflection_b[2]])
            case "joint":
                return np.array(element.joint_index), element.joint_signs
            case "leg":
                return np.array([self.labels.index(element.leg_image(leg)) for leg in self.labels]), ones
            case "invariant":
                return same, ones


TERMS: tuple[Term, ...] = (
    Term("projected_gravity_b", ("x", "y", "z"), "1", 1.0, 0.05, "polar_b", "unit vector of gravity in the body frame"),
    Term("joint_pos_rel", JOINTS, "rad", 1.0, 0.01, "joint", "joint positions minus the default pose"),
    Term("joint_vel", JOINTS, "rad/s", 0.05, 1.5, "joint", "joint velocities"),
    Term("last_action", JOINTS, "1", 1.0, 0.0, "joint", "the action of the step before, as the policy gave it"),
    Term(
        "velocity_command", ("v_x", "v_y", "yaw_rate"), "m/s, m/s, rad/s", 1.0, 0.0, "planar_velocity_b",
        "commanded forward, lateral and yaw velocity",
    ),
    Term("clock_sin", LEGS, "1", 1.0, 0.0, "leg", "sin(2 pi phi_i) of each leg"),
    Term("phase_offset", ("LF", "RF", "LH", "RH"), "stride", 1.0, 0.0, "leg", "offsets theta_i of the commanded gait"),
    Term("duty_ratio", ("beta", "1-beta"), "1", 1.0, 0.0, "invariant", "duty factor and its complement"),
)  # fmt: skip


@dataclass(frozen=True)
class Layout:
    """An ordered list of terms, with what follows from it."""

    terms: tuple[Term, ...]

    @property
    def size(self) -> int:
        """Length of the vector."""
        return sum(term.size for term in self.terms)

    @property
    def slices(self) -> dict[str, slice]:
        """Where each term lies in the vector."""
        found, start = {}, 0
        for term in self.terms:
            found[term.name] = slice(start, start + term.size)
            start += term.size
        return found

    def assemble(self, values: Mapping[str, Array]) -> Array:
        """The scaled vector.

        Args:
            values: for each term an array (..., size), unscaled, in the order of its labels.

        Returns:
            (..., size of the layout), a fresh array.

        Raises:
            SymdynError: if terms are missing, unknown or of another size.
        """
        wrong = [t.name for t in self.terms if t.name not in values or values[t.name].shape[-1] != t.size]
        if wrong or len(values) != len(self.terms):
            unknown = sorted(set(values) - {t.name for t in self.terms})
            raise SymdynError(f"Observation terms missing or of a wrong size: {wrong}; unknown: {unknown}.")
        xp = array_namespace(values[self.terms[0].name])
        scaled = [values[t.name] if t.scale == 1.0 else t.scale * values[t.name] for t in self.terms]
        return xp.concat(scaled, axis=-1)

    def noise_amplitude(self) -> NDArray[np.float64]:
        """Half-width of the uniform noise of each number of the (scaled) vector, (size,)."""
        return np.concatenate([np.full(t.size, t.noise * t.scale) for t in self.terms])

    def mirror(self, element: Spatial) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """(index, sign), both (size,), such that ``sign * obs[..., index]`` is what the transformed robot observes.

        Joint positions relative to a default pose that the element moves (g_t and g_r turn the Go2's thighs and calves
        round) are so only up to a constant.
        """
        slices = self.slices
        parts = [(slices[t.name].start, *t.mirror(element)) for t in self.terms]
        return np.concatenate([start + index for start, index, _ in parts]), np.concatenate([s for _, _, s in parts])

    def as_list(self) -> list[dict[str, Any]]:
        """The table that the policy file carries: name, size, scale of each term, in order."""
        return [{"name": t.name, "size": t.size, "scale": t.scale} for t in self.terms]


OBSERVATION = Layout(TERMS)
"""The policy's input."""

_OFFSET_ORDER = [LEGS.index(leg) for leg in next(t for t in TERMS if t.name == "phase_offset").labels]


def command_terms(offsets: Array, velocity: Array, leg_phases: Array, duty: Array) -> dict[str, Array]:
    """The terms that follow from the command and the clock alone.

    Args:
        offsets: (..., 4) in the order of LEGS.
        velocity: (..., 3) v_x, v_y, yaw rate.
        leg_phases: (..., 4).
        duty: (...,).

    Returns:
        velocity_command, clock_sin, phase_offset, duty_ratio.
    """
    xp = array_namespace(offsets, velocity, leg_phases, duty)
    return {
        "velocity_command": velocity,
        "clock_sin": xp.sin(2.0 * np.pi * leg_phases),
        "phase_offset": offsets[..., _OFFSET_ORDER],
        "duty_ratio": xp.stack([duty, 1.0 - duty], axis=-1),
    }
