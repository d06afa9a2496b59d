from dataclasses import replace
from functools import cache
from itertools import combinations

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from slip.families.branch import Branch, Diagram, Junction
from slip.figures.diagram import FAMILY_COLOURS, QUANTITIES, branch_diagram, described
from slip.figures.orbit import SAMPLES, STRIDES, caption, orbit_figure
from slip.model.naming import FAMILIES as KNOWN_FAMILIES
from slip.model.parameters import REFERENCE
from slip.model.unknowns import DPHI, DX, PERIOD, Y
from slip.orbits.trajectory import sample
from slip.robot.units import Units
from symdyn.figures.plots import LEG_COLOURS, save
from symdyn.robot.legs import LEGS
from tests.slip.orbits.stored_orbits import FAMILIES, hop, orbit

GO2_UNITS = Units(mass=15.0, length=0.387)


def branch(name: str, count: int = 12) -> Branch:
    """Made up, on a curve through a real orbit: half of it stable."""
    middle = orbit(name).unknowns
    unknowns = np.tile(middle, (count, 1))
    along = np.linspace(-0.8, 0.8, count)
    unknowns[:, DX] += along
    unknowns[:, PERIOD] -= 0.01 * along
    unknowns[:, Y] -= 0.02 * along**2
    multipliers = np.full((count, 11), 0.5 + 0.1j)
    multipliers[count // 2 :, 0] = 1.2
    return Branch(name, REFERENCE, unknowns, multipliers, np.zeros(count), ("began", "ended"))


def diagram(names=FAMILIES) -> Diagram:
    branches = tuple(branch(name) for name in names)
    pairs = [("PK", "BG"), ("PK", "BE"), ("BG", "HG"), ("BG", "FG"), ("HE", "GE")]
    where = {on: orbit(on).unknowns for on in names}
    junctions = tuple(Junction.at(where[on], on, to, "hind") for on, to in pairs if on in where)
    return Diagram(REFERENCE, branches, junctions, {})


FIGURES = {
    "diagram": lambda: branch_diagram(diagram()),
    "diagram_in_si": lambda: branch_diagram(diagram(), "The Go2 as a spring-loaded model", GO2_UNITS),
    "diagram_of_one": lambda: branch_diagram(diagram(("PK",))),
    "diagram_without_junctions": lambda: branch_diagram(replace(diagram(("BG", "HG")), junctions=())),
    "gallop": lambda: orbit_figure(orbit("GG"), "GG, gallop with gathered suspension"),
    "bound_in_si": lambda: orbit_figure(orbit("BG"), "BG", "Independent check: 2.1e-11.", GO2_UNITS),
    "hop": lambda: orbit_figure(hop(), "pronk in place"),
}
# each is made once: no test changes it
every_figure = pytest.mark.parametrize("make", [cache(make) for make in FIGURES.values()], ids=FIGURES.keys())


def texts(figure: Figure) -> dict[str, tuple[float, float, float, float]]:
    """Left, bottom, right and top of everything written in a figure, in pixels."""
    figure.draw_without_rendering()
    parts = [figure]
    for part in parts:
        parts += part.subfigs
    written = [text for part in parts for text in part.texts]
    written += [text for part in parts for legend in part.legends for text in legend.get_texts()]
    for axes in figure.axes:
        written += [axes.title, *axes.texts]
        for axis in (axis for axis in (axes.xaxis, axes.yaxis) if axis.get_visible()):
            low, high = sorted(axis.get_view_interval())
            labels = [axis.label] if axis.label.get_visible() else []
            ticks = zip(axis.get_ticklocs(), axis.get_ticklabels(), strict=False)
            written += labels + [label for place, label in ticks if low <= place <= high]
        for child in axes.child_axes:
            written += [child.xaxis.label, child.yaxis.label]
    shown = [text for text in written if text.get_visible() and text.get_text().strip()]
    return {f"{text.get_text()} ({k})": text.get_window_extent().extents for k, text in enumerate(shown)}


class TestEveryFigure:
    @every_figure
    def test_nothing_written_overlaps_or_sticks_out(self, make):
        figure = make()
        boxes = texts(figure)
        assert len(boxes) >= 5
        for (one, a), (other, b) in combinations(boxes.items(), 2):
            # a pixel of overlap is none to the eye
            apart = a[0] >= b[2] - 1 or b[0] >= a[2] - 1 or a[1] >= b[3] - 1 or b[1] >= a[3] - 1
            assert apart, (one, other)
        width, height = figure.bbox.width, figure.bbox.height
        for text, (left, bottom, right, top) in boxes.items():
            assert left >= -1 and bottom >= -1 and right <= width + 1 and top <= height + 1, text

    @every_figure
    def test_saves(self, make, tmp_path):
        save(make(), tmp_path / "figure.png", dpi=30)
        assert (tmp_path / "figure.png").read_bytes().startswith(b"\x89PNG")


class TestBranchDiagram:
    def test_every_family_has_a_colour_of_its_own(self):
        assert set(FAMILY_COLOURS) == set(KNOWN_FAMILIES)
        assert len({to_rgb(colour) for colour in FAMILY_COLOURS.values()}) == len(FAMILY_COLOURS)

    def test_curves_are_the_branches(self):
        figure = branch_diagram(diagram(("BG",)))
        shown = branch("BG")
        labels = {"stride period": "period", "apex height": "y", "pitch rate": "dphi"}
        panels = {label: axes for axes in figure.axes for label in labels if axes.get_ylabel().startswith(label)}
        assert len(panels) == 3
        for label, axes in panels.items():
            solid, dashed = (
                next(line for line in axes.lines if line.get_linestyle() == style) for style in ("-", "--")
            )
            values = shown.column(labels[label])
            assert np.array_equal(np.isfinite(solid.get_ydata()), shown.stable)
            assert np.array_equal(solid.get_ydata()[shown.stable], values[shown.stable])
            drawn = np.isfinite(dashed.get_ydata())
            assert drawn[~shown.stable].all()
            assert np.array_equal(solid.get_xdata(), shown.speeds)

    def test_duty_factor(self):
        unknowns = np.array([orbit(name).unknowns for name in FAMILIES])
        duty = next(quantity for quantity in QUANTITIES if quantity.label == "duty factor").of(unknowns)
        assert duty == pytest.approx([orbit(name).duty_factor for name in FAMILIES])

    def test_the_legend_names_families_and_junctions_with_speeds(self):
        (legend,) = branch_diagram(diagram()).legends
        written = [text.get_text() for text in legend.get_texts()]
        for name in FAMILIES:
            assert any(text.startswith(f"{name}: ") for text in written)
        speed = orbit("PK").apex_speed
        assert any("PK \N{RIGHTWARDS ARROW} BG, BE" in text and f"{speed:.4f}" in text for text in written)

    def test_si_axes(self):
        figure = branch_diagram(diagram(), units=GO2_UNITS)
        figure.draw_without_rendering()
        top = next(child for child in figure.axes[0].child_axes if "m/s" in child.get_xlabel())
        low, high = figure.axes[0].get_xlim()
        assert top.get_xlim() == pytest.approx((low * GO2_UNITS.speed, high * GO2_UNITS.speed))
        pitch = next(c for axes in figure.axes for c in axes.child_axes if c.get_ylabel() == "[rad/s]")
        assert pitch is not None

    def test_described(self):
        assert described(REFERENCE) == "k = 10, ks = 20, J = 2"
        assert described(replace(REFERENCE, hind_distance=0.45)) == "k = 10, ks = 20, J = 2, lb = 0.45"


def bars(axes, colour: str) -> list[tuple[float, float]]:
    found = []
    for collection in axes.collections:
        if tuple(collection.get_facecolor()[0][:3]) == to_rgb(colour):
            found += [tuple(path.get_extents().get_points()[:, 0]) for path in collection.get_paths()]
    return sorted(found)


class TestOrbitFigure:
    @pytest.mark.parametrize("family", ("BG", "GE"))
    def test_bars_are_stances(self, family):
        shown = orbit(family)
        axes = orbit_figure(shown, family).axes[0]
        assert axes.get_xlim() == pytest.approx((0.0, STRIDES * shown.period))
        path = sample(shown, 101)
        for i, leg in enumerate(LEGS):
            drawn = [any(a <= t < b for a, b in bars(axes, LEG_COLOURS[leg])) for t in path.time[1:-1]]
            column = ("LH", "LF", "RH", "RF").index(leg)
            assert drawn == path.contact[1:-1, column].tolist()
            assert bars(axes, LEG_COLOURS[leg])[1][1] - bars(axes, LEG_COLOURS[leg])[1][0] == pytest.approx(
                shown.duty_factors[i] * shown.period
            )

    def test_vertical_forces_carry_the_weight(self):
        shown = orbit("HG")
        axes = orbit_figure(shown, "HG", units=GO2_UNITS).axes[1]
        curves = [line for line in axes.lines if len(line.get_ydata()) == STRIDES * (SAMPLES + 1)]
        assert len(curves) == len(LEGS)
        total = sum(np.nan_to_num(line.get_ydata()) for line in curves)[: SAMPLES + 1]
        time = curves[0].get_xdata()[: SAMPLES + 1]
        impulse = np.trapezoid(total, time)
        assert impulse == pytest.approx(GO2_UNITS.force * shown.period * GO2_UNITS.time, rel=1e-4)

    def test_caption_is_honest(self):
        text = caption(orbit("BG"), "Independent check: 2.1e-11.")
        assert "k = 10, ks = 20, J = 2" in text
        assert f"{orbit('BG').residual_norm:.1e}" in text
        assert "Independent check: 2.1e-11." in text

    def test_pitch_rate_of_the_phase_plot(self):
        figure = orbit_figure(orbit("BG"), "BG")
        torso = next(axes for axes in figure.axes if axes.get_xlabel() == "pitch [deg]")
        assert torso.lines[0].get_ydata()[0] == pytest.approx(orbit("BG").unknowns[DPHI])
