"""An observation vector as data: named terms in an order, and what follows from them."""

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

Kind = Literal["polar_b", "axial_b", "joint", "planar_velocity_b", "leg", "invariant"]

FRAMES: Mapping[str, str] = {"polar_b": "body", "axial_b": "body", "planar_velocity_b": "heading"}
"""Frame of a term by its kind: body is x forward, y left, z up of the trunk; heading is the world turned by its yaw."""


@dataclass(frozen=True)
class Term:
    """One named part of an observation vector.

    Attributes:
        name: its key in :meth:`Layout.assemble`.
        labels: what each number is; their count is the size.
        unit: before scaling.
        scale: the vector holds scale * value.
        noise: half-width of the uniform noise in training, in ``unit``.
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


@dataclass(frozen=True)
class Layout:
    """An ordered list of terms, with what follows from it."""

    terms: tuple[Term, ...]

    @property
    def size(self) -> int:
        """Length of the vector."""
        return sum(term.size for term in self.terms)

    @property
    def names(self) -> tuple[str, ...]:
        """Of the terms, in order."""
        return tuple(term.name for term in self.terms)

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
        """The table that the policy file carries, in order: name, size and scale of each term; what each number is, its
        unit before scaling, and the frame."""
        return [
            {
                "name": t.name,
                "size": t.size,
                "scale": t.scale,
                "labels": list(t.labels),
                "unit": t.unit,
                "frame": FRAMES.get(t.kind, "none"),
                "meaning": t.meaning,
            }
            for t in self.terms
        ]
