"""The path of least jerk from 0 to 1 (Flash and Hogan 1985): the way every scripted motion of the joints goes."""

from __future__ import annotations


def least_jerk(share: float) -> float:
    """How much of the way is behind after this share of the time; shares outside [0, 1] count as its ends."""
    share = min(1.0, max(0.0, share))
    return share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
