"""Histogram of the feet's raw forces, with what the calibration made of them."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from hardware.estimation.calibration import FootCalibration
from symdyn.figures.plots import LEG_COLOURS
from symdyn.robot.legs import LEGS

_BINS = 80


def contact_figure(raw: NDArray[np.float64], calibration: FootCalibration) -> Figure:
    """A panel a foot: share of the samples by raw force, medians of swing and stance, threshold.

    Args:
        raw: (N, 4), in the order of symdyn.robot.legs.LEGS.
        calibration: of the same.
    """
    figure = Figure(figsize=(8.0, 6.0), layout="constrained")
    panels = figure.subplots(len(LEGS), sharex=True, sharey=True)
    bins = np.linspace(raw.min() - 0.5, raw.max() + 0.5, _BINS + 1)
    share = np.full(len(raw), 1.0 / len(raw))
    for leg, axes, values, foot in zip(LEGS, panels, raw.T, calibration.feet, strict=True):
        axes.hist(values, bins, weights=share, color=LEG_COLOURS[leg])
        axes.axvline(foot.threshold, color="black", linewidth=1.5, label=f"threshold {foot.threshold:.0f}")
        axes.axvline(foot.swing, color="black", linewidth=1.0, linestyle=":", label=f"swing {foot.swing:.0f}")
        axes.axvline(foot.stance, color="black", linewidth=1.0, linestyle="--", label=f"stance {foot.stance:.0f}")
        axes.set_yscale("log")
        axes.set_ylabel(leg)
        axes.legend(loc="upper right", ncols=3, fontsize=8)
    panels[-1].set_xlabel("raw foot force")
    figure.suptitle(f"Share of {len(raw)} samples by raw foot force: {calibration.source}", fontsize=10)
    return figure
