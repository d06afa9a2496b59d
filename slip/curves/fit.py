r"""Fit the paper's curves to points: T* and beta over the non-dimensional speed v*.

.. math::  y = a (1 + b \delta |v^*|) e^{-c |v^*|}, \qquad \delta \in [-1, 1]

(eq. 1 of the paper, y = T* or beta, each with constants of its own).

**a, c** minimise the weighted sum of squared residuals y - a exp(-c |v*|) (Levenberg-Marquardt, analytic Jacobian).

**b** is the spread that the paper draws from: with delta uniform in [-1, 1], the relative residual
r = y / (a exp(-c |v*|)) - 1 = b delta |v*| has the mean square b^2 v*^2 / 3. So b^2 = 3 sum(w r^2) / sum(w v*^2), with
the factor n / (n - 2) for the two constants that were fitted. It is no bound: of points spread otherwise than
uniformly, some lie outside the band 1 +- b |v*|, and the share of those inside is reported.

**Intervals** are of 95%. By default they come from the covariance of the residuals, each point's own residual standing
for its variance (HC3: MacKinnon & White, J. Econometrics 29, 1985), since by eq. (1) the spread grows with speed. They
hold for points that are independent. Orbits along a branch are not: neighbours are almost the same orbit, and a finer
trace would shrink the interval without any new knowledge. ``bootstrap`` resamples whole groups (families of orbits,
gaits of trials) instead; with fewer than ten groups that, too, is rough.

The same function fits passive orbits and trials of a trained policy; it does not know which. What the points are is
said where they are made (slip.curves.points, slip.curves.trial_choice) and kept beside the constants
(slip.curves.file).
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.special import stdtrit

from symdyn.errors import InvalidValue
from symdyn.gait.timing import TimingCurve

Floats = NDArray[np.float64]

FEWEST_POINTS = 4
"""Two constants, and two points to judge them by."""

FEWEST_GROUPS = 4
"""Of a bootstrap over groups."""

SMALLEST_SPREAD = 0.05
"""Of |v*| (0.1 m/s with legs of 0.4 m): within less, c is noise."""

FARTHEST = 1e3
"""A curve that is so many times below a point fits nothing."""

STEEPEST = 30.0
"""Largest |c v*| that is tried: a factor of 1e13."""

LEAST_WEIGHT = 1e-9
"""Of the largest weight: what weighs less does not count as a point."""

CONFIDENCE = 0.95

_COURSE = f"such that a exp(-c |v*|) comes within a factor of {FARTHEST:g} of each; leave points out"


@dataclass(frozen=True)
class TimingPoints:
    """n points of stride period and duty factor over speed, non-dimensional (time in sqrt(l / g), speed in sqrt(g l)).

    Attributes:
        group: (n,) what belongs together: the family of an orbit, the gait of a trial.
        v_star: (n,) speed; its sign does not count.
        period_star: (n,) T* > 0.
        duty: (n,) beta in (0, 1).
        weight: (n,) of the squared residuals, >= 0; points of weight 0 (:data:`LEAST_WEIGHT`) do not count.

    Raises:
        InvalidValue: if lengths differ, or a value is not finite or outside its range; it names the point.
    """

    group: tuple[str, ...]
    v_star: Floats
    period_star: Floats
    duty: Floats
    weight: Floats

    def __post_init__(self) -> None:
        n = len(self.group)
        rules = {
            "v_star": (lambda x: np.isfinite(x), "finite"),
            "period_star": (lambda x: np.isfinite(x) & (x > 0.0), "finite and > 0"),
            "duty": (lambda x: (x > 0.0) & (x < 1.0), "in (0, 1)"),
            "weight": (lambda x: np.isfinite(x) & (x >= 0.0), "finite and >= 0"),
        }
        for name, (holds, allowed) in rules.items():
            values = np.asarray(getattr(self, name), dtype=np.float64)
            if values.shape != (n,):
                raise InvalidValue(f"The shape of {name}", values.shape, f"({n},), one value a point")
            bad = np.flatnonzero(~holds(values))
            if len(bad):
                point = f"{name} of point {bad[0]} ({self.group[bad[0]]})"
                raise InvalidValue(point, float(values[bad[0]]), allowed)
            object.__setattr__(self, name, values)

    def __len__(self) -> int:
        return len(self.group)

    def take(self, which: NDArray[np.int64] | NDArray[np.bool_]) -> TimingPoints:
        """Some of the points, by index or mask."""
        index = np.arange(len(self))[which]
        group = tuple(self.group[i] for i in index)
        return TimingPoints(group, self.v_star[index], self.period_star[index], self.duty[index], self.weight[index])


@dataclass(frozen=True)
class Estimate:
    """A constant and its interval of 95%."""

    value: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.value:.4g} [{self.low:.4g}, {self.high:.4g}]"


@dataclass(frozen=True)
class DecayFit:
    """y = a (1 + b delta |v*|) exp(-c |v*|), fitted.

    Attributes:
        a: y at rest.
        b: spread per unit of speed.
        c: decay per unit of speed.
        r_squared: share of the weighted variance of y that a exp(-c |v*|) explains; None if y does not vary.
        rms: weighted root mean square of the residuals, in units of y.
        largest: the largest residual, in units of y.
        inside: share of points within 1 +- b |v*|.
        residuals: (n,) y - a exp(-c |v*|), in the order of the points.
    """

    a: Estimate
    b: Estimate
    c: Estimate
    r_squared: float | None
    rms: float
    largest: float
    inside: float
    residuals: Floats

    def at(self, v_star: Floats, delta: float = 0.0) -> Floats:
        """y at speeds, (...,) -> (...,)."""
        speed = np.abs(v_star)
        return self.a.value * (1.0 + self.b.value * delta * speed) * np.exp(-self.c.value * speed)

    def as_dict(self) -> dict[str, Any]:
        """Without the residuals of the single points, for JSON."""
        constants = {name: vars(getattr(self, name)) for name in ("a", "b", "c")}
        numbers = {name: getattr(self, name) for name in ("r_squared", "rms", "largest", "inside")}
        return {**{name: dict(value) for name, value in constants.items()}, **numbers}


@dataclass(frozen=True)
class CurveFit:
    """Both curves, fitted to the same points.

    Attributes:
        period: T*.
        duty: beta.
        points: number of points that counted.
        groups: how many of them of each group.
        speed_range: smallest and largest |v*|.
        intervals: how the intervals were found, in words.
    """

    period: DecayFit
    duty: DecayFit
    points: int
    groups: dict[str, int]
    speed_range: tuple[float, float]
    intervals: str

    def timing(self, source: str) -> TimingCurve:
        """The constants as the trainer takes them.

        Args:
            source: what they were fitted to, in words; it travels with them into every policy file.

        Raises:
            InvalidValue: if a constant is absurd, a spread of more than 1 for one.
        """
        return TimingCurve(
            a_T=self.period.a.value,
            b_T=self.period.b.value,
            c_T=self.period.c.value,
            a_beta=self.duty.a.value,
            b_beta=self.duty.b.value,
            c_beta=self.duty.c.value,
            source=source,
        )

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "T": self.period.as_dict(),
            "beta": self.duty.as_dict(),
            "points": self.points,
            "groups": dict(self.groups),
            "v_star_range": list(self.speed_range),
            "intervals": self.intervals,
        }


def fit_curves(points: TimingPoints, bootstrap: int = 0, seed: int = 0) -> CurveFit:
    """Fit both curves.

    Args:
        points: at least :data:`FEWEST_POINTS` of positive weight, over a range of speeds.
        bootstrap: number of resamplings of whole groups for the intervals; 0 takes the covariance.
        seed: of the resampling.

    Raises:
        InvalidValue: if there are too few points, or groups for a bootstrap, or no spread in speed.
    """
    counted = points.take(points.weight > LEAST_WEIGHT * points.weight.max(initial=0.0))
    speed = np.abs(counted.v_star)
    if len(counted) < FEWEST_POINTS:
        allowed = f"at least {FEWEST_POINTS} of positive weight, to fit a curve of two constants"
        raise InvalidValue("The number of points", len(counted), allowed)
    if np.ptp(speed) < SMALLEST_SPREAD:
        allowed = f"over a range of at least {SMALLEST_SPREAD:g}, or the decay cannot be told"
        raise InvalidValue("The range of the points' |v*|", (float(speed.min()), float(speed.max())), allowed)
    weight = counted.weight / counted.weight.max()
    values = (counted.period_star, counted.duty)
    fits = [_fit(speed, y, weight) for y in values]
    intervals = "95%, HC3 covariance of the residuals, points taken as independent"
    if bootstrap:
        draws = _resampled(counted, bootstrap, seed)
        fits = [_with_intervals(fit, draws[:, i]) for i, fit in enumerate(fits)]
        intervals = f"95%, percentiles of {len(draws)} bootstrap samples of whole groups"
    return CurveFit(
        period=fits[0],
        duty=fits[1],
        points=len(counted),
        groups=dict(sorted(Counter(counted.group).items())),
        speed_range=(float(speed.min()), float(speed.max())),
        intervals=intervals,
    )


def _fit(speed: Floats, y: Floats, weight: Floats) -> DecayFit:
    a, c = _constants(speed, y, weight)
    decay = np.exp(-c * speed)
    residuals = y - a * decay
    if not (a * decay > y / FARTHEST).all():
        raise InvalidValue("The fit to the points", f"a={a:.3g}, c={c:.3g}", _COURSE)
    n = len(y)
    quantile = float(stdtrit(n - 2, 0.5 + CONFIDENCE / 2.0))
    half_a, half_c = quantile * np.sqrt(_variances(np.stack([decay, -a * speed * decay], axis=1), residuals, weight))
    relative = residuals / (a * decay)
    b = _spread(relative, speed, weight, quantile)
    total = float(np.sum(weight * (y - np.average(y, weights=weight)) ** 2))
    squares = float(np.sum(weight * residuals**2))
    varies = total > 1e-24 * float(np.sum(weight * y**2))
    return DecayFit(
        a=Estimate(a, a - float(half_a), a + float(half_a)),
        b=b,
        c=Estimate(c, c - float(half_c), c + float(half_c)),
        r_squared=1.0 - squares / total if varies else None,
        rms=math.sqrt(squares / float(weight.sum())),
        largest=float(np.abs(residuals).max()),
        inside=float(np.mean(np.abs(relative) <= b.value * speed + 1e-12)),
        residuals=residuals,
    )


def _constants(speed: Floats, y: Floats, weight: Floats) -> tuple[float, float]:
    """a and c of least weighted squares; all (n,)."""
    root, unit = np.sqrt(weight), float(y.max())

    def residuals(x: Floats) -> Floats:
        return root * (x[0] * np.exp(-x[1] * speed) - y / unit)

    def jacobian(x: Floats) -> Floats:
        decay = np.exp(-x[1] * speed)
        return np.stack([root * decay, -root * x[0] * speed * decay], axis=1)

    # for a given c the best a is known; the best of many c is near the best of all
    rates = np.linspace(-STEEPEST, STEEPEST, 401) / speed.max()
    decays = np.exp(-np.outer(rates, speed))
    heights = (decays @ (weight * y / unit)) / (decays**2 @ weight)
    squares = ((heights[:, None] * decays - y / unit) ** 2) @ weight
    start = np.array([heights[squares.argmin()], rates[squares.argmin()]])
    with np.errstate(over="ignore", invalid="ignore"):  # of trial steps, which are then refused
        # SciPy has no stubs, and the default of jac is text
        found = least_squares(residuals, start, jac=jacobian, method="lm", xtol=1e-13, ftol=1e-13, gtol=1e-13)  # pyright: ignore[reportArgumentType]
    a, c = (float(value) for value in found.x)
    if not (found.success and a > 0.0 and abs(c) * speed.max() <= STEEPEST):
        raise InvalidValue("The fit to the points", f"a={a:.3g}, c={c:.3g}", _COURSE)
    return a * unit, c


def _variances(jacobian: Floats, residuals: Floats, weight: Floats) -> Floats:
    """Of the constants, (p,), HC3. Jacobian (n, p), residuals and weight (n,)."""
    weighted = jacobian * np.sqrt(weight)[:, None]
    left, singular, right = np.linalg.svd(weighted / np.linalg.norm(weighted, axis=0), full_matrices=False)
    leverage = np.sum(left**2, axis=1)
    scaled = np.sqrt(weight) * residuals / np.maximum(1.0 - leverage, 1e-3)
    # (J^T W J)^-1 J^T W^(1/2), the columns scaled back
    solve = (right.T / singular) @ left.T / np.linalg.norm(weighted, axis=0)[:, None]
    return np.sum((solve * scaled) ** 2, axis=1)


def _spread(relative: Floats, speed: Floats, weight: Floats, quantile: float) -> Estimate:
    """b from the relative residuals, all (n,). The interval is that of log b, so that it stays above zero."""
    n = len(speed)
    grown = float(np.sum(weight * speed**2))
    square = 3.0 * float(np.sum(weight * relative**2)) / grown * n / (n - 2)
    if not square:
        return Estimate(0.0, 0.0, 0.0)
    terms = weight * (3.0 * relative**2 - square * speed**2) * n / (n - 2)
    half = quantile * float(np.sqrt(np.sum(terms**2))) / grown / square / 2.0
    b = math.sqrt(square)
    return Estimate(b, b * math.exp(-half), b * math.exp(half))


def _resampled(points: TimingPoints, times: int, seed: int) -> Floats:
    """a, b, c of both curves for each resampling that could be fitted, (m, 2, 3)."""
    names = sorted(set(points.group))
    if len(names) < FEWEST_GROUPS:
        allowed = f"at least {FEWEST_GROUPS}; take the intervals from the covariance"
        raise InvalidValue("The number of groups to bootstrap over", len(names), allowed)
    members = {name: np.flatnonzero([group == name for group in points.group]) for name in names}
    rng = np.random.default_rng(seed)
    draws = []
    for _ in range(times):
        chosen = rng.choice(len(names), len(names))
        sample = points.take(np.concatenate([members[names[i]] for i in chosen]))
        try:
            fit = fit_curves(sample)
        except InvalidValue:
            continue  # groups without a spread in speed among them
        draws.append([[curve.a.value, curve.b.value, curve.c.value] for curve in (fit.period, fit.duty)])
    if len(draws) < max(0.8 * times, 2):
        allowed = "fitted in at least 80% of the cases; take the intervals from the covariance"
        raise InvalidValue("The bootstrap over groups", f"{len(draws)} fits in {times} samples", allowed)
    return np.array(draws)


def _with_intervals(fit: DecayFit, draws: Floats) -> DecayFit:
    """The fit with the percentiles of (m, 3) draws of a, b, c as intervals."""
    tail = 50.0 * (1.0 - CONFIDENCE)
    low, high = np.percentile(draws, [tail, 100.0 - tail], axis=0)
    a, b, c = (Estimate(mine.value, float(low[i]), float(high[i])) for i, mine in enumerate((fit.a, fit.b, fit.c)))
    return DecayFit(a, b, c, fit.r_squared, fit.rms, fit.largest, fit.inside, fit.residuals)
