"""Thresholds of the feet's force sensors, found in what they showed while the robot ran.

Over a run a foot is either in the air, where its sensor shows its own zero, or bears load; the raw forces form two
clusters. Otsu's method (Otsu 1979) separates them. Feet that stand for a while, or that load slowly, add a third
cluster in between. So the light cluster is split repeatedly, and the last two clusters that are well apart are taken.
Otsu's own threshold lies midway between their means, which a loading foot reaches late. So only the medians are used:
the threshold is a tenth of the way from the swing median to the stance median.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hardware.estimation.settings import ContactConfig
from hardware.wire.channels import IMU, TICK, WrongMessage
from hardware.wire.event_log import LogReader
from hardware.wire.readings import Imu
from symdyn.errors import FileProblem, SymdynError
from symdyn.io.files import read_json, write_json
from symdyn.robot.legs import LEGS

Floats = NDArray[np.float64]

FORMAT_VERSION = 1
LEAST_SAMPLES = 1000
"""Two seconds of the bridge's messages: three strides or more."""

_ON_THE_WAY = 0.1
"""Of the way from swing's median to stance's: a foot that bears a tenth of its usual load. A higher threshold tells of
touchdown later and of lift-off earlier than it is."""

_CLEAR_OF_SWING = 4.0
"""Deviations of swing by which the threshold for lift-off must at least be above swing's median; the other one is above
it by :attr:`hardware.estimation.contact.ContactConfig.release`."""

_LOWEST = 5.0
"""Raw units; a sensor's zero may be negative, a threshold not."""

_LEAST_SHARE = 0.05
"""Of the samples that each heap must have."""

_LEAST_DISTANCE = 8.0
"""Of the medians, in deviations of swing. One heap cut in two by Otsu's method comes to 3 (uniform, normal) or 4
(exponential)."""

_MOST_IN_SWING = 0.4
"""Of stance's median, by swing's: a foot that shows more in its light heap stands in both."""

_WHAT_TO_DO = (
    "Record the robot trotting in place or forward for 10 s on hard, level ground, and calibrate with that log."
)


class NoTwoModes(SymdynError):
    """A foot's raw forces do not tell stance from swing."""


@dataclass(frozen=True)
class FootSensor:
    """What a foot's force sensor shows, in its raw unit.

    Attributes:
        threshold: above which the foot bears load.
        swing: median in swing.
        swing_deviation: robust standard deviation in swing.
        stance: median in stance.
        stance_share: of the samples that are above the threshold.
    """

    threshold: float
    swing: float
    swing_deviation: float
    stance: float
    stance_share: float


@dataclass(frozen=True)
class FootCalibration:
    """The sensors of all feet.

    Attributes:
        feet: in the order of symdyn.robot.legs.LEGS.
        samples: that it rests on.
        source: where they come from.
    """

    feet: tuple[FootSensor, FootSensor, FootSensor, FootSensor]
    samples: int
    source: str

    @property
    def thresholds(self) -> tuple[float, float, float, float]:
        """As :class:`hardware.estimation.contact.ContactConfig` takes them."""
        lh, lf, rf, rh = (foot.threshold for foot in self.feet)
        return lh, lf, rf, rh

    def save(self, path: Path) -> None:
        """Write as JSON. Raises FileProblem."""
        feet = {leg: asdict(foot) for leg, foot in zip(LEGS, self.feet, strict=True)}
        write_json(
            path, {"format_version": FORMAT_VERSION, "source": self.source, "samples": self.samples, "feet": feet}
        )

    @classmethod
    def load(cls, path: Path) -> FootCalibration:
        """Read :meth:`save`'s file. Raises FileProblem if it is missing or anything else."""
        data = read_json(path)
        if not isinstance(data, dict) or data.get("format_version") != FORMAT_VERSION:
            raise FileProblem(path, f"is not a foot calibration with format_version {FORMAT_VERSION}.")
        feet, samples, source = data.get("feet"), data.get("samples"), data.get("source")
        if not isinstance(feet, dict) or set(feet) != set(LEGS):
            raise FileProblem(path, f"must have the feet {', '.join(LEGS)}, each once.")
        if type(samples) is not int or not isinstance(source, str):
            raise FileProblem(path, "lacks the number of samples or their source.")
        lh, lf, rf, rh = (_read_foot(feet[leg], leg, path) for leg in LEGS)
        return cls((lh, lf, rf, rh), samples, source)


def _read_foot(data: Any, leg: str, path: Path) -> FootSensor:
    names = list(FootSensor.__dataclass_fields__)
    if not isinstance(data, dict) or set(data) != set(names):
        raise FileProblem(path, f"must give foot {leg} the keys {', '.join(names)}, and no others.")
    for name, value in data.items():
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise FileProblem(path, f"has {value!r} for {name} of foot {leg}, which must be a finite number.")
    foot = FootSensor(**{name: float(value) for name, value in data.items()})
    if foot.threshold <= 0.0:
        raise FileProblem(path, f"has the threshold {foot.threshold:g} for foot {leg}, which must be above 0.")
    return foot


def calibrate(raw: Floats, source: str) -> FootCalibration:
    """The thresholds that raw forces tell of.

    Args:
        raw: (N, 4) raw forces of a robot that runs, in the order of symdyn.robot.legs.LEGS.
        source: where they come from.

    Raises:
        NoTwoModes: if there are too few, one is not a number, or those of a foot do not form two heaps that are well
            apart; it says what to do.
    """
    if len(raw) < LEAST_SAMPLES:
        raise NoTwoModes(
            f"{source} has {len(raw)} samples of the feet's forces; {LEAST_SAMPLES} are needed. {_WHAT_TO_DO}"
        )
    if not np.isfinite(raw).all():
        raise NoTwoModes(f"{source} has forces that are not finite.")
    lh, lf, rf, rh = (_calibrate_foot(raw[:, i], leg) for i, leg in enumerate(LEGS))
    return FootCalibration((lh, lf, rf, rh), len(raw), source)


def _calibrate_foot(raw: Floats, leg: str) -> FootSensor:
    if raw.min() == raw.max():
        raise NoTwoModes(
            f"Foot {leg} always shows {raw[0]:g}: its sensor is dead, or the bridge had no data from the robot. "
            "Without it: --contact.source torque."
        )
    whole = _Heaps.of(raw, otsu(raw))
    if not whole.both_there:
        raise NoTwoModes(f"Foot {leg} was hardly ever in swing, or hardly ever in stance ({whole}). {_WHAT_TO_DO}")
    heaps, deeper = None, whole
    while deeper is not None:
        heaps = _Heaps.of(raw, deeper.cut) if deeper.apart else heaps
        deeper = _Heaps.of(raw, deeper.cut).of_light()
    if heaps is None:
        raise NoTwoModes(f"The forces of foot {leg} do not separate into swing and stance ({whole}). {_WHAT_TO_DO}")
    swing, stance = heaps.swing, heaps.stance
    clear = (swing + _CLEAR_OF_SWING * heaps.deviation) / ContactConfig().release
    threshold = max(swing + _ON_THE_WAY * (stance - swing), clear, _LOWEST)
    return FootSensor(threshold, swing, heaps.deviation, stance, float(np.mean(raw > threshold)))


@dataclass(frozen=True, eq=False)
class _Heaps:
    """Raw forces parted in two.

    Attributes:
        cut: between them.
        light: up to the cut, (L,).
        heavy: above it, (H,).
    """

    cut: float
    light: Floats
    heavy: Floats

    @classmethod
    def of(cls, raw: Floats, cut: float) -> _Heaps:
        return cls(cut, raw[raw <= cut], raw[raw > cut])

    def of_light(self) -> _Heaps | None:
        """The light heap parted in turn, or None if there is nothing to part."""
        if self.light.min() == self.light.max():
            return None
        deeper = _Heaps.of(self.light, otsu(self.light))
        least = _LEAST_SHARE * (len(self.light) + len(self.heavy))
        return deeper if len(deeper.light) >= least else None

    @property
    def swing(self) -> float:
        return float(np.median(self.light))

    @property
    def stance(self) -> float:
        return float(np.median(self.heavy))

    @property
    def deviation(self) -> float:
        """Robust standard deviation of the light heap: 1.4826 times the median absolute deviation of a normal one."""
        of_whole_numbers = 1.0 / math.sqrt(12.0)
        return max(1.4826 * float(np.median(np.abs(self.light - self.swing))), of_whole_numbers)

    @property
    def both_there(self) -> bool:
        return min(len(self.light), len(self.heavy)) >= _LEAST_SHARE * (len(self.light) + len(self.heavy))

    @property
    def apart(self) -> bool:
        far = self.stance - self.swing >= _LEAST_DISTANCE * self.deviation
        return far and self.swing <= _MOST_IN_SWING * self.stance

    def __str__(self) -> str:
        share = len(self.light) / (len(self.light) + len(self.heavy))
        return (
            f"{share:.0%} of the samples about {self.swing:.0f}, spread by {self.deviation:.1f}; the others about "
            f"{self.stance:.0f}"
        )


def otsu(values: Floats) -> float:
    """The cut that makes the variance between the values up to it and those above it greatest, (N,).

    Raises:
        ValueError: if there is but one value.
    """
    rising = np.sort(values)
    places = np.flatnonzero(rising[1:] > rising[:-1])
    below = places + 1.0
    sums = np.cumsum(rising)[places]
    mean = rising.mean()
    between = (sums - below * mean) ** 2 / (below * (len(rising) - below))
    best = places[np.argmax(between)]
    return float((rising[best] + rising[best + 1]) / 2.0)


def read_raw(
    path: Path, on_progress: Callable[[int, int], None] = lambda done, total: None, state: str | None = None
) -> Floats:
    """The raw forces in an event log, (N, 4), in the order of symdyn.robot.legs.LEGS.

    Messages from before the bridge has heard of the robot, and such as are damaged, are left out.

    Args:
        path: of the log.
        on_progress: called with the bytes that were gone through, and all there are.
        state: of the deployer, in which messages count; all do if None, or if the log has no ticks of a deployer.

    Raises:
        FileProblem: if the file is no event log, is two of them, has no such message, or never was in that state.
    """
    reader, found = LogReader(path), []
    ticks, within = 0, True
    for k, event in enumerate(reader):
        if k % 1000 == 0:
            on_progress(reader.position, reader.size)
        reader.check_single()
        if event.channel == TICK and state is not None:
            if not ticks:
                found.clear()  # from before the deployer began
            ticks += 1
            with contextlib.suppress(WrongMessage):
                within = event.message().state == state
        if event.channel != IMU or not within:
            continue
        try:
            imu = Imu.of(event.message())
        except WrongMessage:
            continue
        if imu.finite() and imu.quat_w.any():
            found.append(imu.foot_force)
    if not found and ticks:
        raise FileProblem(path, f"has no message of a robot in the state {state}: the policy never ran. {_WHAT_TO_DO}")
    if not found:
        raise FileProblem(path, f"has no message of a robot on channel {IMU}.")
    return np.array(found)
