"""Orbits as points of the timing curves: which families, which speeds, and how much each counts.

The speed of an orbit is its mean speed, stride length over stride period, since that is what a commanded velocity is;
its speed at the apex (by which branches are labelled) is a little higher. v* = v / sqrt(l) and T* = T / sqrt(l) in the
model's units (slip.robot.units); the duty factor is the mean over the legs.

Branches are traced in steps that the curvature decides, so orbits lie densely here and sparsely there. By default each
orbit counts for the range of speeds that it stands for along its branch (``speed``), so that a finer trace changes
nothing; ``orbit`` counts each as one, ``family`` does as ``speed`` but gives every family the same weight in all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slip.curves.fit import Floats, TimingPoints
from slip.curves.settings import Selection
from slip.families.branch import Branch
from slip.robot.units import starred
from symdyn.errors import InvalidValue


@dataclass(frozen=True)
class PassiveOrbits:
    """n orbits of some branches, in the order of the branches.

    Attributes:
        branch: (n,) name of the branch that an orbit lies on.
        family: (n,) its family.
        v_star: (n,) mean speed.
        period_star: (n,)
        duty: (n,) mean over the legs.
        stable: (n,) whether no Floquet multiplier is outside the unit circle.
    """

    branch: tuple[str, ...]
    family: tuple[str, ...]
    v_star: Floats
    period_star: Floats
    duty: Floats
    stable: NDArray[np.bool_]

    @classmethod
    def of(cls, branches: Sequence[Branch]) -> PassiveOrbits:
        """All orbits of some branches."""
        pairs = [(branch, orbit) for branch in branches for orbit in branch.orbits]
        return cls(
            branch=tuple(branch.name for branch, _ in pairs),
            family=tuple(branch.family for branch, _ in pairs),
            v_star=np.array([starred(orbit.mean_speed, branch.parameters) for branch, orbit in pairs]),
            period_star=np.array([starred(orbit.period, branch.parameters) for branch, orbit in pairs]),
            duty=np.array([orbit.duty_factor for _, orbit in pairs]),
            stable=np.concatenate([branch.stable for branch in branches] or [np.zeros(0, dtype=np.bool_)]),
        )

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        arrays = {name: getattr(self, name).tolist() for name in ("v_star", "period_star", "duty", "stable")}
        return {"branch": list(self.branch), "family": list(self.family), **arrays}

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> PassiveOrbits:
        """From :meth:`as_dict`."""
        return cls(
            branch=tuple(data["branch"]),
            family=tuple(data["family"]),
            **{name: np.array(data[name], dtype=np.float64) for name in ("v_star", "period_star", "duty")},
            stable=np.array(data["stable"], dtype=np.bool_),
        )

    def select(self, selection: Selection | None = None) -> TimingPoints:
        """The selected orbits as points; the group is the family.

        Raises:
            InvalidValue: if none is selected; it says what there is.
        """
        selection = selection or Selection()
        speed, family = np.abs(self.v_star), np.array(self.family)
        low, high = selection.speeds
        kept = (speed >= low) & (speed <= high)
        kept &= np.isin(family, selection.families) if selection.families else family != "PC"
        if selection.stable_only:
            kept &= self.stable
        if not kept.any():
            raise InvalidValue("The number of selected orbits", 0, f"at least one; there are {self.describe()}")
        weight = np.ones(len(speed)) if selection.weights == "orbit" else self._share()
        if selection.weights == "family":
            for name in set(self.family):
                members = kept & (family == name)
                weight[members] /= weight[members].sum() or 1.0
        return TimingPoints(self.family, self.v_star, self.period_star, self.duty, weight).take(kept)

    def describe(self) -> str:
        """What there is: ``PK at v* 0 to 1.2 (12 of 40 stable)``."""
        texts = []
        for name in dict.fromkeys(self.family):
            members = np.array(self.family) == name
            speed = np.abs(self.v_star[members])
            stable = f"{self.stable[members].sum()} of {members.sum()} stable"
            texts.append(f"{name} at v* {speed.min():.3g} to {speed.max():.3g} ({stable})")
        return ", ".join(texts) or "none at all"

    def _share(self) -> Floats:
        """The range of speeds that each orbit stands for: half of each gap to its neighbours on its branch. (n,)."""
        weight = np.zeros(len(self.branch))
        for i, j in pairwise(range(len(self.branch))):
            if self.branch[i] == self.branch[j]:
                weight[[i, j]] += 0.5 * abs(self.v_star[j] - self.v_star[i])
        return weight
