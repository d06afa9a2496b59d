"""The figure shows every family, fit and the paper's curve with units; the report has every number of the file."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from slip.curves.file import FittedCurve, document
from slip.curves.fit import TimingPoints, fit_curves
from slip.curves.report import markdown
from slip.figures.curves import FAMILY_STYLES, curve_figure
from symdyn.figures.plots import save


def points(groups: tuple[str, ...], a_T: float) -> TimingPoints:
    rng, n = np.random.default_rng(0), 12
    v = np.tile(np.linspace(0.0, 1.0, n), len(groups))
    delta = rng.uniform(-0.2, 0.2, (2, len(v))) * v
    period, duty = a_T * (1.0 + delta[0]) * np.exp(-0.1 * v), 0.5 * (1.0 + delta[1]) * np.exp(-0.2 * v)
    return TimingPoints(tuple(np.repeat(groups, n).tolist()), v, period, duty, np.ones(len(v)))


ORBITS, TRIALS = points(("PK", "BG", "GE", "X9"), 1.6), points(("trot", "rotary_gallop"), 2.4)
PASSIVE, CALIBRATED = fit_curves(ORBITS), fit_curves(TRIALS)


def legend(figure: Figure) -> list[str]:
    return [text.get_text() for text in figure.legends[0].get_texts()]


def test_families_fits_and_the_papers_curve_are_named() -> None:
    names = legend(curve_figure(PASSIVE, ORBITS))
    assert set(names) == {"PK", "BG", "GE", "X9", "passive fit: orbits of the SLIP", "paper: its own calibration"}
    names = legend(curve_figure(PASSIVE, ORBITS, CALIBRATED, TRIALS))
    assert {"calibrated fit: chosen trials", "trial: trot", "trial: rotary gallop"} <= set(names)


def test_axes_have_units_and_with_a_leg_length_those_of_the_robot() -> None:
    figure = curve_figure(PASSIVE, ORBITS)
    left, right = figure.axes
    assert "sqrt{l/g}" in left.get_ylabel() and "[1]" in right.get_ylabel()
    assert all("sqrt{g" in axes.get_xlabel() for axes in (left, right))
    figure = curve_figure(PASSIVE, ORBITS, leg_length=0.4)
    figure.draw_without_rendering()
    (top,) = (child for child in figure.axes[1].child_axes)
    assert top.get_xlabel() == "$|v|$ [m/s] for l = 0.4 m"
    assert top.get_xlim()[1] == pytest.approx((9.81 * 0.4) ** 0.5)


def test_lines_lie_where_the_fits_do() -> None:
    axes = curve_figure(PASSIVE, ORBITS).axes[0]
    passive, paper = (np.asarray(line.get_ydata()) for line in axes.get_lines())
    assert passive[0] == pytest.approx(PASSIVE.period.a.value)
    assert (paper[0], paper[-1]) == pytest.approx((2.55, 2.55 * np.exp(-0.975)))


def test_families_are_told_apart() -> None:
    assert len(set(FAMILY_STYLES.values())) == len(FAMILY_STYLES)


def test_it_is_saved(tmp_path: Path) -> None:
    save(curve_figure(PASSIVE, ORBITS, CALIBRATED, TRIALS, 0.4), tmp_path / "curves.png")
    assert (tmp_path / "curves.png").read_bytes().startswith(b"\x89PNG")


DATA = {"robot": "go2", "parameters": {"stiffness": 2.195}, "dropped": (), "rest_length": 1.034}


def test_the_report_has_each_curve_in_a_column_of_its_own() -> None:
    content = document(FittedCurve(PASSIVE, DATA, "48 orbits"), FittedCurve(CALIBRATED, {}, "24 trials"))
    text = markdown(content, "go2", "curves.png")
    assert "| passive | calibrated (active) | paper |" in text
    rows = {cells[1].strip(): [cell.strip() for cell in cells[2:-1]]
            for cells in (line.split("|") for line in text.splitlines()) if len(cells) == 6}  # fmt: skip
    for constant in ("a_T", "b_T", "c_T", "a_beta", "b_beta", "c_beta"):
        passive, calibrated, paper = rows[constant]
        for cell, name in ((passive, "passive"), (calibrated, "calibrated")):
            assert re.fullmatch(r"[\d.e-]+ \[-?[\d.e-]+, [\d.e-]+\]", cell)
            assert float(cell.split()[0]) == pytest.approx(content["curves"][name][constant], rel=1e-3)
        assert float(paper) == content["curves"]["paper"][constant]
    assert rows["points"] == ["48", "24", "not published"]
    assert rows["of"][0] == "BG 12, GE 12, PK 12, X9 12"
    assert "- parameters: stiffness 2.195" in text and "- dropped: none" in text
    assert "![Points, fits and the paper's curve](curves.png)" in text
    assert content["note"] in text


def test_the_report_without_trials_has_no_column_for_them_and_what_does_not_exist_is_a_dash() -> None:
    flat = replace(PASSIVE, period=replace(PASSIVE.period, r_squared=None))
    text = markdown(document(FittedCurve(flat, DATA, "48 orbits")), "go2")
    assert "| passive | paper (active) |" in text
    assert "| R^2, T | - | not published |" in text
    assert "calibrated |" not in text and "![" not in text
