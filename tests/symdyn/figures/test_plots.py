import subprocess
import sys
from dataclasses import replace
from functools import cache
from itertools import combinations

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from symdyn.analysis.metrics import KEYS, stride_average
from symdyn.analysis.recording import Recording
from symdyn.errors import FileProblem, InvalidValue, UnknownName
from symdyn.figures import plots
from symdyn.gait.library import LIBRARY, PAPER_GAITS, Gait
from symdyn.gait.phase import in_swing, leg_phase
from symdyn.robot.legs import LEGS
from tests.symdyn.analysis.synthetic import recording

LONG = (
    "Footfalls at 0.5 m/s, two seconds each of trot, bound, half_bound_left, rotary_gallop "
    "(policy-without-morphological-term, 98.3M samples)"
)


def tracking(names=PAPER_GAITS, title: str = "Tracking of 0.5 m/s by a synthetic robot") -> Figure:
    recordings = {name: recording(LIBRARY[name], 0.5, dt=0.01) for name in names}
    return plots.velocity_tracking(recordings, title)


def transition() -> Recording:
    parts = [recording(LIBRARY[name], 0.5, seconds=2.0, dt=0.005, late=0.05) for name in ("trot", "half_bound_left")]
    values = {
        name: np.concatenate([getattr(part, name) for part in parts]) if isinstance(value, np.ndarray) else value
        for name, value in vars(parts[0]).items()
    }
    return Recording(**values)


def records(count: int = 50, terms: tuple[str, ...] = ("x_velocity", "temporal")) -> list[dict[str, float]]:
    lines = []
    for k in range(count):
        line = {"iteration": k + 1, "samples": 24000 * (k + 1), "reward/total": 0.01 * k, "learn/action_std": 1.0}
        line |= {f"reward/{term}": -0.1 * (rank + 1) for rank, term in enumerate(terms)}
        line |= {"task/x_velocity_error": 1.0 / (k + 1)} | ({"episode/seconds": float(k)} if k >= 10 else {})
        lines.append(line)
    return lines


def table(names=tuple(LIBRARY), speeds=(-1.0, 0.2, 0.5, 1.0)) -> dict[str, dict[float, dict[str, float]]]:
    return {name: {v: {"cot": 0.1 * k + v * v, "rmsne": 1.0} for v in speeds} for k, name in enumerate(names)}


FIGURES = {
    "footfall_diagram": lambda: plots.footfall_diagram(transition(), "trot to half bound at 0.5 m/s"),
    "gait_diagram": lambda: plots.gait_diagram(LIBRARY["transverse_gallop"], 0.45),
    "velocity_tracking": tracking,
    "velocity_tracking_of_all": lambda: tracking(tuple(LIBRARY)),
    "learning_curves": lambda: plots.learning_curves(records(), "runs/synthetic"),
    "learning_curves_of_many_terms": lambda: plots.learning_curves(
        records(terms=tuple(f"term_{k}" for k in range(14)))
    ),
    "metric_bars": lambda: plots.metric_bars(table(), "cot"),
    "footfall_diagram_with_a_long_title": lambda: plots.footfall_diagram(transition(), LONG),
    "velocity_tracking_with_a_long_title": lambda: tracking(("trot", "bound"), LONG),
    "learning_curves_with_a_long_title": lambda: plots.learning_curves(records(), LONG),
    "metric_bars_with_a_long_title": lambda: plots.metric_bars(table(("trot",), (0.5,)), "gait_identity"),
    "metric_bars_of_one": lambda: plots.metric_bars(table(("trot",), (0.5,)), "rmsne", "rmsne of one run"),
}
# each is made once: no test changes it
every_figure = pytest.mark.parametrize("make", [cache(make) for make in FIGURES.values()], ids=FIGURES.keys())


def texts(figure: Figure) -> dict[str, tuple[float, float, float, float]]:
    """Left, bottom, right and top of everything written in a figure, in pixels."""
    figure.draw_without_rendering()
    written = list(figure.texts) + [text for legend in figure.legends for text in legend.get_texts()]
    for axes in figure.axes:
        written += [axes.title, axes.xaxis.label, axes.yaxis.label, *axes.texts]
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            ticks = zip(axis.get_ticklocs(), axis.get_ticklabels(), strict=False)  # a shared axis has no labels
            written += [label for place, label in ticks if low <= place <= high]
    shown = [text for text in written if text.get_visible() and text.get_text()]
    return {f"{text.get_text()} ({k})": text.get_window_extent().extents for k, text in enumerate(shown)}


class TestEveryFigure:
    @every_figure
    def test_nothing_written_overlaps_or_sticks_out(self, make):
        figure = make()
        boxes = texts(figure)
        assert len(boxes) >= 5
        for (one, a), (other, b) in combinations(boxes.items(), 2):
            assert a[0] >= b[2] or b[0] >= a[2] or a[1] >= b[3] or b[1] >= a[3], (one, other)
        width, height = figure.bbox.width, figure.bbox.height
        for text, (left, bottom, right, top) in boxes.items():
            assert left >= -1 and bottom >= -1 and right <= width + 1 and top <= height + 1, text

    @every_figure
    def test_no_curve_is_under_a_figure_legend(self, make):
        figure = make()
        figure.draw_without_rendering()
        for legend in figure.legends:
            for axes in figure.axes:
                assert not legend.get_window_extent().overlaps(axes.get_window_extent())

    @every_figure
    def test_saves(self, make, tmp_path):
        plots.save(make(), tmp_path / "new" / "figure.png", dpi=40)
        assert (tmp_path / "new" / "figure.png").read_bytes().startswith(b"\x89PNG")
        assert len(list((tmp_path / "new").iterdir())) == 1

    def test_no_pyplot(self):
        code = (
            "import sys; from symdyn.figures import plots; from symdyn.gait.library import LIBRARY;"
            "plots.gait_diagram(LIBRARY['trot'], 0.5).draw_without_rendering();"
            "sys.exit('matplotlib.pyplot' in sys.modules)"
        )
        assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


class TestSave:
    def test_dpi(self, tmp_path):
        figure = Figure(figsize=(2.0, 1.0))
        plots.save(figure, tmp_path / "figure.png", dpi=50)
        header = (tmp_path / "figure.png").read_bytes()[16:24]
        assert (int.from_bytes(header[:4]), int.from_bytes(header[4:])) == (100, 50)

    @pytest.mark.parametrize("suffix", ("svg", "pdf"))
    def test_other_formats(self, suffix, tmp_path):
        plots.save(Figure(), tmp_path / f"figure.{suffix}")
        assert suffix.encode() in (tmp_path / f"figure.{suffix}").read_bytes().lower()

    @pytest.mark.parametrize("name", ("figure.xyz", "figure"))
    def test_unknown_format(self, name, tmp_path):
        with pytest.raises(InvalidValue, match="png"):
            plots.save(Figure(), tmp_path / name)
        assert not list(tmp_path.iterdir())

    def test_no_place(self, tmp_path):
        (tmp_path / "file").write_text("")
        with pytest.raises(FileProblem):
            plots.save(Figure(), tmp_path / "file" / "figure.png")


def spans(axes, row: int, colour: str | None) -> list[tuple[float, float]]:
    """Left and right end of the bars of a row; hollow ones if ``colour`` is None."""
    found = []
    for collection in axes.collections:
        filled = len(collection.get_facecolor()) > 0
        if filled != (colour is not None) or (filled and tuple(collection.get_facecolor()[0][:3]) != to_rgb(colour)):
            continue
        for path in collection.get_paths():
            (left, low), (right, high) = path.get_extents().get_points()
            if low < row < high:
                found.append((float(left), float(right)))
    return sorted(found)


class TestFootfallDiagram:
    def test_bars_are_the_contacts(self):
        run = recording(LIBRARY["walk"], 0.5, seconds=1.5, dt=0.005, late=0.2)
        (axes,) = plots.footfall_diagram(run, "walk").axes
        assert [label.get_text() for label in axes.get_yticklabels()] == list(LEGS)
        assert axes.get_ylim()[0] > axes.get_ylim()[1]  # the first leg on top
        for row, leg in enumerate(LEGS):
            for state, colour in ((run.contact, plots.LEG_COLOURS[leg]), (run.desired_stance, None)):
                bars = spans(axes, row, colour)
                drawn = np.any([(run.time + 1e-9 >= a) & (run.time + 1e-9 < b) for a, b in bars], axis=0)
                assert np.array_equal(drawn, state[:, row])

    def test_names_the_gaits_where_they_change(self):
        (axes,) = plots.footfall_diagram(transition(), "two gaits").axes
        assert [text.get_text() for text in axes.texts] == ["trot", "half bound left"]
        (line,) = axes.lines
        assert line.get_xdata()[0] == pytest.approx(2.0)

    def test_a_gait_without_a_name(self):
        run = transition()
        offsets = run.offsets.copy()
        offsets[400:] = (0.0, 0.2, 0.1, 0.45)
        (axes,) = plots.footfall_diagram(replace(run, offsets=offsets), "two gaits").axes
        assert axes.texts[1].get_text() == "(no gait of the library)"

    def test_a_leg_that_never_lands(self):
        run = recording(LIBRARY["walk"], 0.5, seconds=1.0)
        (axes,) = plots.footfall_diagram(replace(run, contact=np.zeros_like(run.contact)), "nothing").axes
        assert not any(spans(axes, row, plots.LEG_COLOURS[leg]) for row, leg in enumerate(LEGS))


class TestGaitDiagram:
    @pytest.mark.parametrize("name", LIBRARY)
    @pytest.mark.parametrize("duty", (0.3, 0.7))
    def test_bars_are_the_stance_of_the_clock(self, name, duty):
        (axes,) = plots.gait_diagram(LIBRARY[name], duty, strides=3).axes
        assert axes.get_xlim() == (0.0, 3.0)
        phase = (np.arange(300) + 0.5) / 100
        n = len(phase)
        legs = leg_phase(phase, np.tile(LIBRARY[name].theta, (n, 1)), np.ones(n))
        stance = ~in_swing(legs, np.full(n, duty))
        for row, leg in enumerate(LEGS):
            bars = spans(axes, row, plots.LEG_COLOURS[leg])
            drawn = np.any([(phase >= a) & (phase < b) for a, b in bars], axis=0)
            # the middle of a cell may lie on an edge of a bar
            assert np.sum(drawn != stance[:, row]) <= 1

    def test_title_and_range(self):
        figure = plots.gait_diagram(Gait("my_gait", (0.0, 0.1, 0.2, 0.3)), 0.4)
        assert figure.axes[0].get_title().startswith("my gait, duty factor 0.4")
        with pytest.raises(InvalidValue, match="duty"):
            plots.gait_diagram(LIBRARY["trot"], 1.0)


class TestVelocityTracking:
    def test_lines(self):
        runs = {}
        for rank, name in enumerate(("trot", "bound")):
            run = recording(LIBRARY[name], 0.5, dt=0.01)
            sway = 0.1 * (rank + 1) * np.sin(2.0 * np.pi * run.stride_phase)
            velocity = run.velocity_h + np.stack([sway, 2.0 * sway, sway], axis=1)
            runs[name] = replace(run, velocity_h=velocity)
        figure = plots.velocity_tracking(runs, "two gaits at 0.5 m/s")
        assert figure.get_suptitle() == "two gaits at 0.5 m/s"
        for component, axes in enumerate(figure.axes):
            by_label = {line.get_label(): line for line in axes.lines}
            for name, run in runs.items():
                line = by_label[name]
                averaged = stride_average(run.velocity_h[:, component], run.period, run.dt)
                assert np.array_equal(line.get_ydata(), averaged)
                raw = [other for other in axes.lines if other.get_color() == line.get_color() and other is not line]
                assert len(raw) == 1
                assert np.array_equal(raw[0].get_ydata(), run.velocity_h[:, component])
            assert by_label["command"].get_color() == "k"
            assert np.array_equal(by_label["command"].get_ydata(), run.velocity_command[:, component])
        assert [text.get_text() for text in figure.legends[0].get_texts()] == ["trot", "bound", "command"]

    def test_every_gait_of_the_library_has_a_colour_of_its_own(self):
        assert set(plots.GAIT_STYLES) == set(LIBRARY)
        assert len({colour for colour, _ in plots.GAIT_STYLES.values()}) == len(LIBRARY)

    def test_other_names(self):
        runs = {f"policy_{k}": recording(LIBRARY["trot"], 0.5, seconds=1.0, dt=0.02) for k in range(9)}
        lines = plots.velocity_tracking(runs, "nine policies").axes[0].lines
        styles = {(line.get_color(), line.get_linestyle()) for line in lines if line.get_label().startswith("policy")}
        assert len(styles) == 9

    def test_nothing(self):
        with pytest.raises(InvalidValue, match="at least one"):
            plots.velocity_tracking({}, "nothing")


class TestLearningCurves:
    def test_lines(self):
        lines = records()
        figure = plots.learning_curves(lines, "runs/synthetic")
        assert figure.get_suptitle() == "runs/synthetic: 50 updates, 1.2M samples"
        total, error, episode, std, terms = figure.axes
        assert np.array_equal(total.lines[0].get_ydata(), [line["reward/total"] for line in lines])
        assert np.array_equal(error.lines[0].get_ydata(), [line["task/x_velocity_error"] for line in lines])
        assert np.array_equal(episode.lines[0].get_xdata(), [line["samples"] for line in lines[10:]])
        assert np.array_equal(episode.lines[0].get_ydata(), [line["episode/seconds"] for line in lines[10:]])
        assert np.array_equal(std.lines[0].get_ydata(), np.ones(50))
        assert {line.get_label(): line.get_ydata()[0] for line in terms.lines} == {"temporal": -0.2, "x velocity": -0.1}

    @pytest.mark.parametrize("count", (0, 1))
    def test_of_hardly_anything(self, count):
        figure = plots.learning_curves(records(count))
        figure.draw_without_rendering()
        assert all(line.get_marker() == "o" for line in figure.axes[0].lines if len(line.get_xdata()))


class TestMetricBars:
    def test_heights(self):
        (axes,) = plots.metric_bars(table(("trot", "bound"), (0.5, -1.0)), "cot").axes
        assert [label.get_text() for label in axes.get_xticklabels()] == ["-1", "0.5"]
        by_place = sorted((bar.get_x(), bar.get_height()) for bar in axes.patches)
        assert [height for _, height in by_place] == pytest.approx([1.0, 1.1, 0.25, 0.35])
        groups = np.round([bar.get_x() + bar.get_width() / 2 for bar in axes.patches]).tolist()
        assert sorted(groups) == [0.0, 0.0, 1.0, 1.0]

    def test_what_has_no_height_is_written_out(self):
        values = table(("trot", "bound"), (0.5, 1.0))
        values["trot"][0.5]["cot"], values["bound"][1.0]["cot"] = np.inf, np.nan
        del values["trot"][1.0]
        (axes,) = plots.metric_bars(values, "cot").axes
        assert len(axes.patches) == 1
        assert sorted(text.get_text() for text in axes.texts) == ["inf", "n/a", "n/a"]
        assert all(axes.get_xlim()[0] < text.xy[0] < axes.get_xlim()[1] for text in axes.texts)

    def test_of_what_json_holds(self):
        values = table(("trot", "bound"), (-1.0, 0.5, 10.0))
        values["bound"][0.5]["cot"] = np.nan
        read = {
            gait: {f"{v:g}": {k: None if np.isnan(x) else x for k, x in found.items()} for v, found in by_speed.items()}
            for gait, by_speed in values.items()
        }
        (expected,), (axes,) = plots.metric_bars(values, "cot").axes, plots.metric_bars(read, "cot").axes
        assert [text.get_text() for text in axes.get_xticklabels()] == ["-1", "0.5", "10"]
        assert [text.get_text() for text in axes.texts] == ["n/a"]
        assert [bar.get_bbox().bounds for bar in axes.patches] == [bar.get_bbox().bounds for bar in expected.patches]

    def test_of_nothing(self):
        plots.metric_bars({}, "cot").draw_without_rendering()

    @pytest.mark.parametrize("key", KEYS)
    def test_says_what_it_shows(self, key):
        unit, _, meaning = KEYS[key].partition(": ")
        (axes,) = plots.metric_bars(table(("trot",)), key).axes
        assert axes.get_title() == f"{key}: {meaning}"
        assert axes.get_ylabel() == (key if unit == "1" else f"{key} [{unit}]")

    def test_unknown_key(self):
        with pytest.raises(UnknownName, match="rmsne"):
            plots.metric_bars(table(), "rmse")
