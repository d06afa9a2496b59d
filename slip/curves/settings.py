"""Settings of the curves: which orbits and trials are fitted, which springs are identified, what a study varies."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib.util import find_spec
from itertools import product
from typing import Literal

from slip.model.naming import FAMILIES
from slip.model.parameters import SlipParameters
from symdyn.errors import InvalidValue, ResourceProblem, UnknownName
from symdyn.gait.timing import TimingCurve

Weighting = Literal["speed", "orbit", "family"]


@dataclass(frozen=True)
class Selection:
    """Which orbits the passive curves are fitted to.

    Attributes:
        families: names such as PK, TR. If empty, all with orbits in the range but the pace PC, which in the plane has
            the timing of the trot and would count it twice.
        speeds: range of v* = v / sqrt(g l); the default is that of the trainer's commands, 2 m/s with legs of 0.4 m.
        weights: weight of an orbit: speed, the range of speeds that it stands for; orbit, one; family, as speed, but
            the same sum for every family.
        stable_only: leave out orbits with a Floquet multiplier outside the unit circle.
    """

    families: tuple[str, ...] = ()
    speeds: tuple[float, float] = (0.0, 1.01)
    weights: Weighting = "speed"
    stable_only: bool = False

    def __post_init__(self) -> None:
        for name in self.families:
            if name not in FAMILIES:
                raise UnknownName("family", name, FAMILIES)
        if len(set(self.families)) != len(self.families):
            raise InvalidValue("families", self.families, "without duplicates")
        low, high = self.speeds
        if not (math.isfinite(high) and 0.0 <= low < high):
            raise InvalidValue("speeds", self.speeds, "two finite numbers >= 0, the smaller first")


@dataclass(frozen=True)
class IdentifyConfig:
    """What the pronk shall do at rest.

    Attributes:
        period_star: T* = T / sqrt(l / g) at v = 0; the default is the paper's a_T.
        duty: duty factor at v = 0; the default is the paper's a_beta.
    """

    period_star: float = TimingCurve.a_T
    duty: float = TimingCurve.a_beta

    def __post_init__(self) -> None:
        if not 0.0 < self.period_star < math.inf:
            raise InvalidValue("period_star", self.period_star, "a finite number > 0")
        if not 0.0 < self.duty < 1.0:
            raise InvalidValue("duty", self.duty, "in (0, 1)")


@dataclass(frozen=True)
class ChoiceConfig:
    """Which trials may calibrate.

    Attributes:
        tracking_limit: largest error of the mean forward velocity of a trial that counts, m/s.
        min_weight: smallest weight of a trial that counts; in a table of symdyn evaluate --sweep-timing the share of
            strides in the commanded gait.
        speed_bin: width of the bins of commanded speed, m/s, the first about 0.
    """

    tracking_limit: float = 0.2
    min_weight: float = 0.5
    speed_bin: float = 0.1

    def __post_init__(self) -> None:
        for name in ("tracking_limit", "speed_bin"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise InvalidValue(name, getattr(self, name), "a finite number > 0 (m/s)")
        if not 0.0 <= self.min_weight < math.inf:
            raise InvalidValue("min_weight", self.min_weight, "a finite number >= 0")


CurveName = Literal["passive", "calibrated", "paper"]


SYMBOLS: Mapping[str, str] = {
    "k": "stiffness",
    "ks": "swing_stiffness",
    "J": "pitch_inertia",
    "l": "rest_length",
    "lb": "hind_distance",
    "kr": "stiffness_ratio",
}
"""Short names of the parameters, as on the command line and in the table."""


@dataclass(frozen=True)
class Grid:
    """Values to combine, each with each.

    Attributes:
        k: leg stiffness, M g / torso length. This and the next four are the base model's if left out.
        ks: swing stiffness.
        J: pitch inertia, M torso length^2.
        lb: distance of the centre of mass from the hind hip, torso lengths.
        kr: stiffness of a hind leg over that of a front leg.
    """

    k: tuple[float, ...] = ()
    ks: tuple[float, ...] = ()
    J: tuple[float, ...] = ()
    lb: tuple[float, ...] = ()
    kr: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        for name, values in vars(self).items():
            if len(set(values)) != len(values) or not all(0.0 < value < math.inf for value in values):
                raise InvalidValue(name, values, "finite numbers > 0, without duplicates")

    def models(self, base: SlipParameters) -> dict[str, SlipParameters]:
        """All combinations, by a name made of what varies.

        Raises:
            InvalidValue: if a value is out of range.
        """
        varied = {name: values for name, values in vars(self).items() if values}
        found = {}
        for values in product(*varied.values()):
            chosen = dict(zip(varied, values, strict=True))
            name = "_".join(f"{symbol}{value!r}" for symbol, value in chosen.items()) or "base"
            found[name] = replace(base, **{SYMBOLS[symbol]: value for symbol, value in chosen.items()})
        return found


Backend = Literal["loky", "ray", "dask"]


PACKAGES: Mapping[str, tuple[str, str]] = {"ray": ("ray", "ray"), "dask": ("distributed", "'dask[distributed]'")}


@dataclass(frozen=True)
class Workers:
    """Who does the work.

    Attributes:
        jobs: models at a time; 0 uses every processor.
        backend: loky (processes on this machine), ray or dask (a cluster; the package of that name must be installed).
    """

    jobs: int = 0
    backend: Backend = "loky"

    def __post_init__(self) -> None:
        if self.jobs < 0:
            raise InvalidValue("jobs", self.jobs, "a whole number >= 0")
        if self.backend not in ("loky", *PACKAGES):
            raise InvalidValue("backend", self.backend, "one of loky, ray, dask")

    def check(self) -> None:
        """Raises ResourceProblem if the backend's package is not installed."""
        if self.backend in PACKAGES:
            package, requirement = PACKAGES[self.backend]
            if find_spec(package) is None:
                raise ResourceProblem(
                    f"--backend {self.backend} needs the package {package!r}, which is not installed: "
                    f"pip install {requirement}."
                )
