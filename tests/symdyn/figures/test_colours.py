"""Colours of gaits and of legs are told apart, in every figure that has both."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import to_rgb
from numpy.typing import NDArray

from symdyn.figures.plots import GAIT_STYLES, LEG_COLOURS

APART = 20.0
"""Distance in CIELAB; 2.3 is just noticeable side by side, and lines in a legend are small and far apart."""


def lab(colour: str) -> NDArray[np.float64]:
    """CIELAB under D65, from its definition."""
    rgb = np.array(to_rgb(colour))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]) @ linear
    t = xyz / np.array([0.9505, 1.0, 1.089])
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def distance(a: str, b: str) -> float:
    return float(np.linalg.norm(lab(a) - lab(b)))


def test_lab_of_known_colours():
    # white, and red as sRGB has it
    assert np.allclose(lab("#FFFFFF"), [100.0, 0.0, 0.0], atol=0.05)
    assert np.allclose(lab("#FF0000"), [53.2, 80.1, 67.2], atol=0.2)


def test_no_gait_has_the_colour_of_a_leg():
    close = {
        (gait, leg): round(distance(colour, other), 1)
        for gait, (colour, _) in GAIT_STYLES.items()
        for leg, other in LEG_COLOURS.items()
        if distance(colour, other) < APART
    }
    assert close == {}


def test_no_two_gaits_and_no_two_legs_look_alike():
    for colours in ({gait: colour for gait, (colour, _) in GAIT_STYLES.items()}, dict(LEG_COLOURS)):
        names = list(colours)
        close = {
            (a, b): round(distance(colours[a], colours[b]), 1)
            for i, a in enumerate(names)
            for b in names[:i]
            if distance(colours[a], colours[b]) < APART
        }
        assert close == {}
