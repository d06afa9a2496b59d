"""The name of an orbit's family, from which feet touch down together and how the torso turns at the apex."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from slip.model.unknowns import DPHI, PAIRS, PERIOD, SLIP_LEGS, TOUCHDOWN

TOGETHER = 1e-6
"""Touchdowns closer than this share of a stride count as one."""

STILL = 1e-9
"""Pitch rates smaller than this at the apex count as none."""


def together(unknowns: NDArray[np.float64]) -> dict[tuple[str, str], bool]:
    """For every two legs whether they touch down together."""
    times = dict(zip(SLIP_LEGS, unknowns[list(TOUCHDOWN)], strict=True))
    result = {}
    for a in SLIP_LEGS:
        for b in SLIP_LEGS:
            gap = (times[a] - times[b]) / unknowns[PERIOD]
            result[a, b] = bool(abs(gap - np.round(gap)) < TOGETHER)
    return result


def _half_a_stride_apart(unknowns: NDArray[np.float64]) -> bool:
    """Whether left and right of both pairs touch down half a stride apart."""
    gaps = [
        (unknowns[TOUCHDOWN[left]] - unknowns[TOUCHDOWN[right]]) / unknowns[PERIOD] for left, right in PAIRS.values()
    ]
    return all(abs(abs(gap - np.round(gap)) - 0.5) < TOGETHER for gap in gaps)


def family_of(unknowns: NDArray[np.float64], pairs: Collection[str] | None = None) -> str:
    """Family of slip.model.naming.FAMILIES (Ding & Gan 2024, and trot TR and pace PC).

    Args:
        unknowns: of an orbit, (22,).
        pairs: of ``hind``, ``front``: those that move together, if that is known; else it is read off the touchdowns.
    """
    same = together(unknowns)
    if pairs is None:
        pairs = [pair for pair, (left, right) in PAIRS.items() if same[SLIP_LEGS[left], SLIP_LEGS[right]]]
    hind, front = "hind" in pairs, "front" in pairs
    if hind and front and same["LH", "LF"]:
        return "PK"
    if not hind and not front:
        half = _half_a_stride_apart(unknowns)
        if half and same["LH", "RF"] and same["RH", "LF"]:
            return "TR"
        if half and same["LH", "LF"] and same["RH", "RF"]:
            return "PC"
    kind = {(True, True): "B", (True, False): "F", (False, True): "H", (False, False): "G"}[hind, front]
    if abs(unknowns[DPHI]) < STILL:
        return kind
    return kind + ("G" if unknowns[DPHI] > 0.0 else "E")


FAMILIES = {
    "PK": "pronk",
    "BG": "bound, gathered suspension",
    "BE": "bound, extended suspension",
    "FG": "half-bound, front feet spread, gathered",
    "FE": "half-bound, front feet spread, extended",
    "HG": "half-bound, hind feet spread, gathered",
    "HE": "half-bound, hind feet spread, extended",
    "GG": "gallop, gathered suspension",
    "GE": "gallop, extended suspension",
    "B": "bound whose torso does not turn at the apex",
    "F": "half-bound, front feet spread, whose torso does not turn at the apex",
    "H": "half-bound, hind feet spread, whose torso does not turn at the apex",
    "G": "gallop whose torso does not turn at the apex",
    "TR": "trot",
    "PC": "pace",
}
"""Names of the families (Ding & Gan 2024); TR and PC are ours."""
