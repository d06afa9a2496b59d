"""One-parameter branches of periodic gaits, the junctions between them, and the diagram they make."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from slip.model.naming import FAMILIES
from slip.model.parameters import SlipParameters
from slip.model.unknowns import COUNT, DPHI, DX, PERIOD, UNKNOWN_NAMES
from slip.orbits.orbit import Orbit
from symdyn.errors import InvalidValue, UnknownName

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


def pairs_of(family: str) -> tuple[str, ...]:
    """Pairs of legs, ``hind`` and ``front``, that move together in a family."""
    both, hind, front = ("hind", "front"), ("hind",), ("front",)
    return {"PK": both, "B": both, "F": hind, "H": front}.get(family.rstrip("GE"), ())


@dataclass(frozen=True, eq=False)
class Branch:
    """A family, or a connected part of one: orbits in the order in which they were traced.

    Attributes:
        name: of :data:`FAMILIES`; a family's second branch has a 2 behind it.
        parameters: of the model.
        unknowns: of every orbit, (n, 22).
        multipliers: Floquet multipliers of the apex return map, by falling magnitude, without the one that energy holds
            at 1, (n, 11) complex.
        confirmed: largest difference over a stride to the independent integrator with event detection, (n,); NaN where
            that one found other events.
        ends: why the tracing stopped at the first and at the last orbit.
    """

    name: str
    parameters: SlipParameters
    unknowns: Matrix
    multipliers: NDArray[np.complex128]
    confirmed: Vector
    ends: tuple[str, str]

    def __post_init__(self) -> None:
        if self.unknowns.ndim != 2 or self.unknowns.shape[1] != COUNT or not len(self.unknowns):
            raise InvalidValue("unknowns of a branch", self.unknowns.shape, f"(n, {COUNT}) with n > 0")

    def __len__(self) -> int:
        return len(self.unknowns)

    @property
    def family(self) -> str:
        """Of :data:`FAMILIES`."""
        return self.name.rstrip("0123456789")

    def orbit(self, index: int) -> Orbit:
        """One of the orbits."""
        return Orbit(self.unknowns[index].copy(), self.parameters)

    @cached_property
    def orbits(self) -> tuple[Orbit, ...]:
        """All orbits."""
        return tuple(self.orbit(i) for i in range(len(self)))

    def column(self, name: str) -> Vector:
        """An unknown (slip.model.unknowns.UNKNOWN_NAMES) along the branch, (n,)."""
        return self.unknowns[:, UNKNOWN_NAMES.index(name)]

    @property
    def pairs(self) -> tuple[str, ...]:
        """Pairs of legs that move together: :func:`pairs_of` the family."""
        return pairs_of(self.family)

    @property
    def speeds(self) -> Vector:
        """dx at the apex, (n,)."""
        return self.unknowns[:, DX]

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Where no multiplier is outside the unit circle, (n,)."""
        return np.abs(self.multipliers).max(axis=1) <= 1.0 + 1e-6


@dataclass(frozen=True)
class Junction:
    """Where a branch leaves another.

    Attributes:
        on: family on which it lies.
        to: family that leaves it.
        pair: ``hind`` or ``front``: whose left-right symmetry breaks; ``both`` where both do at once (front and hind
            part there, too); ``none`` where none does (the moving pronk leaves the pronk in place).
        dx: speed at the apex.
        T: stride period.
        dphi: pitch rate at the apex.
        unknowns: of the orbit, (22,).
    """

    on: str
    to: str
    pair: str
    dx: float
    T: float
    dphi: float
    unknowns: tuple[float, ...]

    @classmethod
    def at(cls, unknowns: Vector, on: str, to: str, pair: str) -> Junction:
        """The junction at an orbit."""
        values = tuple(float(value) for value in unknowns)
        return cls(on, to, pair, values[DX], values[PERIOD], values[DPHI], values)


@dataclass(frozen=True, eq=False)
class Diagram:
    """All branches found for one set of parameters, and how they hang together.

    Attributes:
        parameters: of the model.
        branches: a family may have more than one.
        junctions: between them.
        missing: families that were looked for and not found, each with why.
        refused: of those, by family, a solution of the equations that is no gait, (22,): how it looked.
    """

    parameters: SlipParameters
    branches: tuple[Branch, ...]
    junctions: tuple[Junction, ...]
    missing: dict[str, str]
    refused: dict[str, Vector] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """Families that were found, in the order of :data:`FAMILIES`."""
        found = {branch.family for branch in self.branches}
        return tuple(name for name in FAMILIES if name in found)

    def family(self, name: str) -> tuple[Branch, ...]:
        """All branches of a family, or the one branch of a name.

        Raises:
            UnknownName: if there is none here.
        """
        found = tuple(branch for branch in self.branches if name in (branch.name, branch.family))
        if not found:
            raise UnknownName("family", name, self.names)
        return found
