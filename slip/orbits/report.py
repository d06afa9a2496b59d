"""Everything that is said about one periodic gait: numbers, checks, stability and symmetry."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slip.model.unknowns import UNKNOWN_NAMES
from slip.orbits.floquet import multipliers
from slip.orbits.independent_simulation import disagreement
from slip.orbits.orbit import Orbit
from slip.orbits.symmetry import Image, OrbitSymmetry, orbit_symmetry
from slip.robot.units import Units, starred
from symdyn.gait.library import nearest
from symdyn.robot.legs import LEGS

FORMAT_VERSION = 1

STABLE = 1.0 + 1e-6
"""Largest multiplier of a stable gait (slip.families.branch.Branch.stable)."""

_NOTHING = 1e-10
"""What is smaller is a rounding error."""


@dataclass(frozen=True, eq=False)
class OrbitReport:
    """A gait and what was found about it.

    Attributes:
        orbit: it.
        family: its name.
        multipliers: Floquet multipliers of the apex return map, by falling magnitude, (11,) complex.
        check: largest difference to an independent integrator that detects its events; NaN where that met other events.
        symmetry: under every element of the group.
        units: scale of a robot, or None.
    """

    orbit: Orbit
    family: str
    multipliers: NDArray[np.complex128]
    check: float
    symmetry: OrbitSymmetry
    units: Units | None

    @classmethod
    def of(cls, orbit: Orbit, family: str, units: Units | None = None) -> OrbitReport:
        """Compute everything."""
        return cls(orbit, family, multipliers(orbit), disagreement(orbit), orbit_symmetry(orbit), units)

    @property
    def stable(self) -> bool:
        """Whether no multiplier is outside the unit circle."""
        return bool(np.abs(self.multipliers).max() <= STABLE)

    @property
    def check_in_words(self) -> str:
        """The independent check as a sentence."""
        if math.isnan(self.check):
            return "An independent integrator that detects events found different ones."
        return f"An independent integrator that detects events agrees to {self.check:.1e}."

    def numbers(self) -> list[tuple[str, str, str]]:
        """(quantity, value in the model's units, value in SI or "") for a table."""
        orbit, units = self.orbit, self.units
        length = f"{orbit.parameters.rest_length:.4g}"
        rows: list[tuple[str, str, float, str, str]] = [
            ("speed at the apex", "sqrt(g D)", orbit.apex_speed, "speed", "m/s"),
            ("mean speed", "sqrt(g D)", orbit.mean_speed, "speed", "m/s"),
            ("stride period T", "sqrt(D/g)", orbit.period, "time", "s"),
            ("stride length", "D", orbit.stride_length, "length", "m"),
            ("apex height", "D", orbit.value("y"), "length", "m"),
            ("pitch at the apex", "rad", orbit.value("phi"), "", "rad"),
            ("pitch rate at the apex", "sqrt(g/D)", orbit.pitch_rate, "rate", "rad/s"),
            ("energy", "M g D", orbit.energy, "energy", "J"),
        ]
        table = []
        for name, unit, value, kind, si in rows:
            value = 0.0 if abs(value) < _NOTHING else value
            in_si = "" if units is None else f"{value * _factor(units, kind):.5g} {si}"
            table.append((name, f"{value:.6g} {unit}", in_si))
        table.append(
            (f"v* (mean speed, leg length {length} D)", f"{starred(orbit.mean_speed, orbit.parameters):.6g}", "")
        )
        table.append((f"T* (leg length {length} D)", f"{starred(orbit.period, orbit.parameters):.6g}", ""))
        table.append(("duty factor, mean of the legs", f"{orbit.duty_factor:.6g}", ""))
        return table

    def checks(self) -> list[tuple[str, str]]:
        """(what, how well) for a table."""
        return [
            ("largest residual", f"{self.orbit.residual_norm:.1e}"),
            ("energy drift over the stride", f"{self.orbit.energy_drift:.1e}"),
            (
                "independent integrator, events detected",
                "other events" if math.isnan(self.check) else f"{self.check:.1e}",
            ),
            ("least force of a standing leg [M g]", f"{self.orbit.least_force:.1e}"),
            ("largest jump of a leg's rate at touchdown", f"{self.symmetry.touchdown_jump:.1e}"),
        ]

    def stability(self) -> str:
        """In a sentence."""
        largest = self.multipliers[0]
        size = f"{abs(largest):.4g}"
        if self.stable:
            return f"Stable: the largest Floquet multiplier has magnitude {size}."
        outside = int((np.abs(self.multipliers) > STABLE).sum())
        return (
            f"Unstable: {outside} Floquet multiplier{'s' if outside > 1 else ''} outside the unit circle, up to {size}."
        )

    def symmetry_in_words(self) -> str:
        """What the table of symmetries says."""
        found = self.symmetry
        reversal = (
            "Run backwards in time, it is a gait" if found.reversible else "Run backwards in time, it is not a gait"
        )
        reversal += f" (a touchdown changes the leg's rate by up to {found.touchdown_jump:.1e})."
        reason = (
            "No touchdown changes the rate of a leg, so the stride can be reversed."
            if found.reversible
            else "A jump of the leg's rate at touchdown cannot be reversed."
        )
        return f"Symmetry group {{{', '.join(found.group)}}}. {reversal} {reason}"

    def as_dict(self) -> dict[str, Any]:
        """For orbit.json: NaN becomes null."""
        orbit, found = self.orbit, self.symmetry
        return {
            "format_version": FORMAT_VERSION,
            "family": self.family,
            "parameters": asdict(orbit.parameters),
            "unknowns": dict(zip(UNKNOWN_NAMES, orbit.unknowns.tolist(), strict=True)),
            "residual": orbit.residual_norm,
            "energy": orbit.energy,
            "energy_drift": orbit.energy_drift,
            "independent_check": None if math.isnan(self.check) else self.check,
            "least_force": orbit.least_force,
            "mean_speed": orbit.mean_speed,
            "stride_length": orbit.stride_length,
            "v_star": starred(orbit.mean_speed, orbit.parameters),
            "T_star": starred(orbit.period, orbit.parameters),
            "duty_factors": dict(zip(LEGS, orbit.duty_factors.tolist(), strict=True)),
            "stable": self.stable,
            "multipliers": [_finite(value) for value in self.multipliers.tolist()],
            "gait": {
                "offsets": found.gait.by_leg(),
                "class": found.footfall_class.describe(),
                "nearest": nearest(found.gait.theta[None])[0],
            },
            "symmetry": {
                "group": list(found.group),
                "reversible": found.reversible,
                "touchdown_jump": found.touchdown_jump,
                "elements": [_as_dict(image) for image in found.images],
            },
            "units": None if self.units is None else asdict(self.units),
        }


def _as_dict(image: Image) -> dict[str, Any]:
    return {
        "name": image.element.name,
        "meaning": image.element.described,
        "keeps_model": image.keeps_model,
        "residual": image.residual if math.isfinite(image.residual) else None,
        "orbit": image.is_orbit,
        "same": image.is_same,
        "shift": image.shift,
        "distance": image.distance,
    }


def _factor(units: Units, kind: str) -> float:
    factors = {"speed": units.speed, "time": units.time, "length": units.length, "energy": units.energy}
    return (factors | {"rate": 1.0 / units.time, "": 1.0})[kind]


def _finite(value: complex) -> list[float] | None:
    return [value.real, value.imag] if np.isfinite(value) else None
