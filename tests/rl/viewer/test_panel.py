"""The panel that reports: strips show what they are given, the last stride's numbers are those of the metrics."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rl.pretrained import policy_path
from rl.viewer.panel import report, strips
from rl.viewer.panel.last_stride import last_stride
from rl.viewer.panel.strips import WINDOW_S, Trace
from rl.viewer.shown import Pose
from rl.viewer.window.watched import SILENT_S, News, Watched
from symdyn.analysis import metrics
from symdyn.analysis.footfall import NO_GAIT, cut_strides
from symdyn.figures.plots import LEG_COLOURS
from symdyn.gait.library import PAPER_GAITS, get
from symdyn.gait.timing import TimingCurve
from symdyn.policy.file import Policy
from symdyn.robot.legs import JOINTS, LEGS
from tests.robots import GO2
from tests.symdyn.analysis.synthetic import recording

DT = 0.005


@pytest.fixture(scope="module")
def policy() -> Policy:
    return Policy.load(policy_path())


def parsed(svg: str) -> ET.Element:
    return ET.fromstring(svg)


def intervals(group: ET.Element) -> list[tuple[float, float]]:
    """Where the bars of a row lie, s before now."""
    edges = strips.WIDTH - strips._RIGHT
    scale = WINDOW_S / (edges - strips._LEFT)
    found = []
    for bar in group.findall("rect"):
        x, width = float(bar.get("x", "nan")), float(bar.get("width", "nan"))
        found.append(((edges - x) * scale, (edges - x - width) * scale))
    return found


def rows(svg: str) -> dict[str, dict[str, list[tuple[float, float]]]]:
    """Bars by leg, solid and hollow."""
    drawn: dict[str, dict[str, list[tuple[float, float]]]] = {leg: {"solid": [], "hollow": []} for leg in LEGS}
    leg = LEGS[0]
    for part in parsed(svg):
        if part.tag == "text":
            leg = str(part.text)
            assert part.get("fill") == LEG_COLOURS[leg]
        elif part.tag == "g":
            hollow = part.get("fill") == "none"
            assert hollow or part.get("fill") == LEG_COLOURS[leg]
            drawn[leg]["hollow" if hollow else "solid"] = intervals(part)
    return drawn


def sampled(bars: list[tuple[float, float]], samples: int) -> np.ndarray:
    """Whether the middle of each sample lies in a bar."""
    ago = (samples - np.arange(samples) - 0.5) * DT
    inside = np.zeros(samples, dtype=bool)
    for begins, ends in bars:
        inside |= (ends < ago) & (ago < begins)
    return inside


class TestFootfalls:
    @settings(deadline=None)
    @given(st.integers(0, 2**32 - 1), st.integers(3, 400))
    def test_bars_are_exactly_the_samples_in_contact_and_desired(self, seed: int, samples: int):
        rng = np.random.default_rng(seed)
        runs = rng.integers(0, 2, (2, samples // 3 + 1, len(LEGS))).repeat(3, axis=1)[:, :samples].astype(bool)
        trace = Trace(DT, runs[0], np.zeros(samples), np.zeros(samples), desired=runs[1])
        drawn = rows(strips.footfalls(trace))
        for k, leg in enumerate(LEGS):
            np.testing.assert_array_equal(sampled(drawn[leg]["solid"], samples), runs[0][:, k])
            np.testing.assert_array_equal(sampled(drawn[leg]["hollow"], samples), runs[1][:, k])

    def test_solid_bars_are_narrower_than_hollow_ones(self):
        trace = Trace.of(recording(get("trot"), 0.8, dt=DT))
        for part in parsed(strips.footfalls(trace)).findall("g"):
            heights = {float(bar.get("height", "nan")) for bar in part.findall("rect")}
            assert heights == {strips._BAR if part.get("fill") == "none" else strips._BAR / 2}

    def test_a_change_of_gait_is_marked_where_it_was(self):
        run = recording(get("trot"), 0.8, seconds=3.0, dt=DT)
        run.offsets[-100:] = get("bound").theta
        trace = Trace.of(run)
        assert trace.changes == (300,)
        (dotted,) = (p for p in parsed(strips.footfalls(trace)).findall("polyline") if p.get("stroke-dasharray"))
        x = float(str(dotted.get("points")).split(",")[0])
        now = strips.WIDTH - strips._RIGHT
        assert (now - x) / (now - strips._LEFT) * WINDOW_S == pytest.approx(0.5, abs=0.002)

    def test_nobody_knows_what_is_desired(self):
        run = Trace.of(recording(get("trot"), 0.8, dt=DT))
        drawn = rows(strips.footfalls(replace(run, desired=None)))
        assert all(row["solid"] and not row["hollow"] for row in drawn.values())


class TestVelocity:
    @pytest.mark.parametrize("speed", [-1.7, 0.0, 0.62, 2.0])
    def test_everything_lies_within_the_picture(self, speed):
        run = recording(get("trot"), speed, dt=DT)
        run.velocity_h[:, 0] += 0.2 * np.sin(np.arange(len(run.time)))
        svg = parsed(strips.velocity(Trace.of(run)))
        height = strips._SPEED_HEIGHT
        lines = svg.findall("polyline")
        points = [tuple(map(float, p.split(","))) for line in lines for p in str(line.get("points")).split()]
        assert all(0.0 <= x <= strips.WIDTH and 0.0 <= y <= height for x, y in points)
        labels = [float(str(label.text)) for label in svg.findall("text")]
        assert min(labels) <= speed <= max(labels) and len(labels) >= 2

    def test_lines_stand_at_the_height_of_their_labels(self):
        run = recording(get("trot"), 0.5, dt=DT)
        svg = parsed(strips.velocity(Trace.of(run)))
        (label,) = (text for text in svg.findall("text") if text.text == "0.5")
        (command,) = (line for line in svg.findall("polyline") if line.get("stroke-dasharray"))
        heights = [float(p.split(",")[1]) for p in str(command.get("points")).split()]
        assert heights == pytest.approx([float(label.get("y", "nan")) - 3.5] * len(heights), abs=0.11)

    def test_unknown_velocities_are_left_out(self):
        unknown = np.full(400, math.nan)
        svg = strips.velocity(Trace(DT, np.zeros((400, 4), dtype=bool), unknown, unknown))
        assert "nan" not in svg
        assert parsed(svg) is not None


class TestTiming:
    @pytest.mark.parametrize("command", [-2.0, 0.0, 0.8])
    def test_the_command_lies_on_the_curve_and_the_stride_where_it_was(self, policy, command):
        run = recording(get("trot"), command, dt=DT)
        stride = last_stride(run)
        assert stride is not None
        for panel in parsed(strips.timing(policy, command, stride)).findall("g"):
            curve = panel.findall("polyline")[-1]
            points = np.array([tuple(map(float, p.split(","))) for p in str(curve.get("points")).split()])
            hollow, solid = sorted(panel.findall("circle"), key=lambda circle: circle.get("fill") != "none")
            places = [(float(c.get("cx", "nan")), float(c.get("cy", "nan"))) for c in (hollow, solid)]
            for x, y in places:  # it does what the clock says: both are on the curve
                assert y == pytest.approx(np.interp(x, points[:, 0], points[:, 1]), abs=1.5)
            assert places[0] == pytest.approx(places[1], abs=1.5)

    def test_no_stride_yet(self, policy):
        svg = strips.timing(policy, 0.5, None)
        assert [len(panel.findall("circle")) for panel in parsed(svg).findall("g")] == [1, 1]


class TestLastStride:
    @pytest.mark.parametrize("gait", PAPER_GAITS)
    @pytest.mark.parametrize("speed", [-1.2, 0.3, 1.6])
    def test_of_a_robot_that_does_what_the_clock_says(self, gait, speed):
        stride = last_stride(recording(get(gait), speed))
        assert stride is not None
        at = np.array([speed])
        assert stride.gait == gait
        assert stride.speed == pytest.approx(speed)
        assert stride.period == pytest.approx(float(TimingCurve().period(at, GO2.leg_length)[0]), abs=0.003)
        assert stride.duty == pytest.approx(float(TimingCurve().duty(at, GO2.leg_length)[0]), abs=0.02)
        assert stride.gc_stance == 0.0

    def test_numbers_are_those_of_the_metrics_over_that_stride_alone(self):
        run = recording(get("trot"), 0.8, late=0.1)
        early = run.contact[: len(run.contact) // 2]
        early[:] = ~early  # long ago
        strides = cut_strides(run)
        whole = slice(int(strides.start[-1]), int(strides.stop[-1]))
        stride = last_stride(run)
        assert stride is not None
        assert stride.gc_stance == metrics.gc_stance(run.contact[whole], run.desired_stance[whole]) > 0.0
        way = 0.8 * run.dt * (whole.stop - whole.start)
        power = np.maximum(run.joint_torque[whole] * run.joint_vel[whole], 0.0).sum()
        assert stride.cot == pytest.approx(power * run.dt / (run.mass * run.gravity * way))

    def test_another_gait_than_the_commanded_is_named(self):
        stride = last_stride(recording(get("trot"), 0.8, played=get("bound")))
        assert stride is not None and stride.gait == "bound"

    def test_standing_still_is_no_gait_and_too_short_is_no_stride(self):
        run = recording(get("trot"), 0.0)
        run.contact[:] = True
        stride = last_stride(run)
        assert stride is not None
        assert stride.gait == NO_GAIT and math.isnan(stride.period) and math.isinf(stride.cot)
        assert last_stride(run.between(0.0, 0.1)) is None


class TestReport:
    def test_is_one_well_formed_element_whatever_is_known(self, policy):
        for stride in (None, last_stride(recording(get("bound"), 0.5))):
            trace = Trace.of(recording(get("trot"), 0.5, dt=DT))
            html = report.page(
                report.headline(report.readable("trot:bound:0.25"), "a < b & c"),
                report.notice("<b>"),
                report.footfalls(trace),
                report.velocity(trace),
                report.timing(policy, 0.5, stride),
                report.numbers(policy, "trot:bound:0.25", 0.5, stride),
            )
            words = "".join(
                ET.fromstring(
                    html.replace("data-report", 'data-report=""').replace("data-notice", 'data-notice=""')
                ).itertext()
            )
            assert "trot + 25% bound" in words and "a < b & c" in words and "<b>" in words and "mixture" in words
            assert "nan" not in words and "inf" not in words

    @pytest.mark.parametrize(
        ("name", "said"),
        [("trot", "trot"), ("half_bound_left", "half bound left"), ("trot:pace:0.5", "trot + 50% pace")],
    )
    def test_names_for_people(self, name, said):
        assert report.readable(name) == said


class TestWatched:
    def news(self, time: float, contact: list[bool], speed: float | None) -> News:
        pose = Pose(time, None, np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(12), np.array(contact))
        return News(time, pose, np.linspace(-3.0, 8.0, len(JOINTS)), speed)

    def test_silence_is_said_before_and_after(self):
        watched = Watched("Go2", "No messages arrive.")
        assert watched.pose() is None
        assert "No messages arrive." in watched.report(5.0)
        watched.hear(self.news(5.0, [True] * 4, 0.0))
        assert "No message" not in watched.report(5.0 + 0.9 * SILENT_S)
        assert f"No message for {SILENT_S + 1.5:.1f} s" in watched.report(5.0 + SILENT_S + 1.5)

    def test_strips_show_what_was_heard_when_it_was_heard(self):
        watched = Watched("Go2", "")
        for k in range(250):  # 2.5 s, 100 a second; LH is in contact every other quarter of a second
            watched.hear(self.news(10.0 + 0.01 * k, [k // 25 % 2 == 0, True, False, k >= 200], 0.5))
        drawn = rows(re.findall(r"<svg.*?</svg>", watched.report(12.5))[0])
        # the last news is that of 12.49 s
        assert [pytest.approx(t, abs=0.012) for t in drawn["LH"]["solid"][-1]] == [0.49, 0.24]
        assert [pytest.approx(t, abs=0.012) for t in drawn["LF"]["solid"][0]] == [WINDOW_S, 0.0]
        assert drawn["RF"]["solid"] == []
        assert [pytest.approx(t, abs=0.012) for t in drawn["RH"]["solid"][0]] == [0.49, 0.0]

    def test_the_hardest_working_joint_is_named(self):
        watched = Watched("Go2", "")
        watched.hear(self.news(1.0, [True] * 4, None))
        assert f"8.0 N m ({JOINTS[-1]})" in watched.report(1.0)
        assert "nan" not in watched.report(1.0)
