"""Films of recordings: the robot is in the picture, moves as recorded, and the strip below shows its footfalls."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import mujoco
import numpy as np
import pytest
from matplotlib.colors import to_rgb

import rl.pictures.film as gait_film
from rl.judging.simulate import Episode, Script, Segment, run
from rl.physics.model import foot_site
from rl.pictures.film import frames
from rl.pictures.film_config import FilmConfig
from rl.pictures.robot import RobotPictures
from rl.pictures.side_camera import side_views
from rl.pictures.visual_model import VISUAL_GROUP
from symdyn.analysis.recording import Recording
from symdyn.errors import InvalidValue
from symdyn.figures.plots import LEG_COLOURS
from symdyn.gait.library import get
from symdyn.policy.file import Policy
from symdyn.robot.legs import LEGS
from tests.rl.pictures.headless import rendering_or_skip
from tests.robots import GO2
from tests.symdyn.analysis.synthetic import recording
from tests.symdyn.policy.policy_files import swaying

SMALL = FilmConfig(size=(320, 180), fps=10)


def episode(gait: str = "trot", speed: float = 0.8, seconds: float = 1.0) -> Episode:
    """A robot that does what the clock says, 0.36 m above the floor."""
    run_ = recording(get(gait), speed, seconds=seconds, dt=0.005)
    run_ = replace(run_, base_pos_w=run_.base_pos_w + np.array([0.0, 0.0, 0.36]))
    return Episode(Script("film", (Segment(0.0, get(gait), (speed, 0.0, 0.0)),), seconds), run_, None)


def masks(run_: Recording, samples: list[int]) -> np.ndarray:
    """Where the robot is in pictures of 200 x 100 pixels, (n, 100, 200)."""
    point, azimuth = side_views(run_)
    found = []
    with RobotPictures(GO2, 200, 100) as pictures:
        pictures.renderer.enable_segmentation_rendering()
        robot = np.flatnonzero(pictures.model.geom_group == VISUAL_GROUP)
        for k in samples:
            seen = pictures.draw(run_, k, point[k], float(azimuth[k]))
            is_geom = seen[..., 1] == int(mujoco.mjtObj.mjOBJ_GEOM)
            found.append(is_geom & np.isin(seen[..., 0], robot))
    return np.array(found)


class TestReplay:
    def test_a_foot_that_bears_load_in_the_recording_is_on_the_floor_in_the_picture(self, tmp_path: Path):
        # position, orientation and joint angles together: any of them wrong would lift or sink the feet
        rendering_or_skip()
        policy = Policy.load(swaying(tmp_path / "sway.onnx"))
        script = Script("sway", (Segment(0.0, get("trot"), (0.0, 0.0, 0.0)),), 1.0, heading=1.0)
        (done,) = run(policy, [script])
        run_ = done.recording
        standing = 0
        with RobotPictures(GO2, 160, 90) as pictures:
            radius = float(pictures.model.geom(foot_site(LEGS[0])).size[0])
            for sample in range(60, len(run_.time), 20):
                data = pictures.pose(run_, sample)
                for leg, contact in zip(LEGS, run_.contact[sample], strict=True):
                    if contact:
                        standing += 1
                        assert data.geom(foot_site(leg)).xpos[2] == pytest.approx(radius, abs=0.004)
        assert standing > 10

    def test_it_runs_to_the_right_with_its_right_side_in_front(self):
        rendering_or_skip()
        run_ = episode().recording
        point, azimuth = side_views(run_)
        columns, rows = {}, {}
        with RobotPictures(GO2, 200, 100) as pictures:
            pictures.renderer.enable_segmentation_rendering()
            seen = pictures.draw(run_, 100, point[100], float(azimuth[100]))
            for link in ("FL_calf", "FR_calf", "RL_calf", "RR_calf"):
                of_link = np.flatnonzero(pictures.model.geom_bodyid == pictures.model.body(link).id)
                rows[link], columns[link] = (where.mean() for where in np.isin(seen[..., 0], of_link).nonzero())
        assert min(columns["FL_calf"], columns["FR_calf"]) > 20 + max(columns["RL_calf"], columns["RR_calf"])
        assert rows["FR_calf"] > rows["FL_calf"] and rows["RR_calf"] > rows["RL_calf"]  # nearer is lower

    def test_the_robot_is_large_and_whole_in_every_picture(self):
        rendering_or_skip()
        seen = masks(episode().recording, [0, 40, 80, 120, 160, 199])
        for mask in seen:
            rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
            assert rows.min() > 0 and rows.max() < 99
            assert columns.min() > 0 and columns.max() < 199
            assert np.ptp(rows) > 50
            assert abs(columns.mean() - 100) < 20

    def test_the_robots_pixels_move_with_its_legs_and_stay_when_it_stands(self):
        rendering_or_skip()
        run_ = episode().recording
        first, later = masks(run_, [100, 134])  # about half a stride
        assert (first ^ later).sum() > 0.1 * first.sum()
        still = replace(run_, **{n: np.repeat(getattr(run_, n)[:1], 200, axis=0) for n in ("base_pos_w", "joint_pos")})
        first, later = masks(still, [100, 134])
        assert not (first ^ later).any()

    def test_the_floor_moves_under_the_robot(self):
        rendering_or_skip()
        run_ = episode().recording
        point, azimuth = side_views(run_)
        with RobotPictures(GO2, 160, 90) as pictures:
            pictures_of = [pictures.draw(run_, k, point[k], float(azimuth[k])).astype(int) for k in (100, 120)]
        floor = np.abs(pictures_of[1] - pictures_of[0])[75:]
        assert (floor.max(axis=-1) > 15).mean() > 0.05


class TestFrames:
    def test_number_size_and_progress(self):
        rendering_or_skip()
        seen: list[tuple[int, int]] = []
        shown = list(frames(episode(seconds=0.5), GO2, SMALL, lambda done, total: seen.append((done, total))))
        assert seen == [(k + 1, 5) for k in range(5)]
        assert all(frame.shape == (180, 320, 3) and frame.dtype == np.uint8 for frame in shown)
        assert all((a != b).any() for a, b in pairwise(shown))

    def test_slow_motion_shows_each_moment_for_longer(self):
        rendering_or_skip()
        drawn = []
        original = gait_film.RobotPictures.draw

        def spy(self, run_, sample, *args):
            drawn.append(sample)
            return original(self, run_, sample, *args)

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(gait_film.RobotPictures, "draw", spy)
            list(frames(episode(seconds=0.5), GO2, FilmConfig((160, 160), fps=5, slow=4.0)))
        assert len(drawn) == 10
        np.testing.assert_allclose(np.diff(drawn) * 0.005, 0.05, atol=0.006)

    @pytest.mark.parametrize("size", [(320, 180), (200, 400), (1280, 200)])
    def test_what_is_written_overlaps_nothing_and_does_not_stick_out(self, size):
        page = gait_film._Page(episode("half_bound_left"), FilmConfig(size, slow=2.0))
        width, height = page.picture_size
        page.draw(np.zeros((height, width, 3), dtype=np.uint8), 100)
        figure = page._figure
        boxes = [text.get_window_extent() for text in figure.texts if text.get_text()]
        assert len(boxes) == 5
        for k, box in enumerate(boxes):
            assert box.x0 >= 0 and box.x1 <= size[0] and box.y0 >= 0 and box.y1 <= size[1]
            assert not any(box.overlaps(other) for other in boxes[k + 1 :])


class TestStrip:
    def strip(self, run_: Episode, sample: int) -> tuple[np.ndarray, gait_film._Page]:
        page = gait_film._Page(run_, FilmConfig((800, 450)))
        width, height = page.picture_size
        return page.draw(np.zeros((height, width, 3), dtype=np.uint8), sample)[height:], page

    @pytest.mark.parametrize("gait", ["trot", "bound", "rotary_gallop"])
    def test_the_right_edge_is_now(self, gait):
        # just left of the line "now" a leg's row has its colour exactly if the leg is in contact then
        shown = episode(gait, seconds=2.0)
        checked = set()
        for sample in range(150, 400, 7):
            state = shown.recording.contact[sample - 8 : sample + 2]
            picture, page = self.strip(shown, sample)
            box = page._axes.get_window_extent()
            column = picture[:, round(box.x1) - 5]
            for leg, standing in zip(LEGS, state.T, strict=True):
                if standing.any() != standing.all():
                    continue  # lands or lifts off within the pixels looked at
                colour = np.array(to_rgb(LEG_COLOURS[leg])) * 255
                has = (np.abs(column - colour) < 12).all(axis=-1).any()
                assert has == standing.all(), (sample, leg)
                checked.add((leg, bool(standing.all())))
        assert len(checked) == 8

    def test_it_shows_the_last_strides(self):
        shown = episode(seconds=4.0)
        _, page = self.strip(shown, 700)
        left, right = page._axes.get_xlim()
        assert right == pytest.approx(701 * 0.005)
        assert (right - left) / shown.recording.period[0] == pytest.approx(gait_film.STRIDES_SHOWN)

    def test_the_captions_numbers_are_the_recordings(self):
        shown = episode("rotary_gallop", 0.8)
        run_ = replace(shown.recording, velocity_h=shown.recording.velocity_h - np.array([0.25, 0.0, 0.0]))
        _, page = self.strip(replace(shown, recording=run_), 150)
        assert page._gait.get_text() == "rotary gallop"
        assert page._speeds.get_text() == "commanded 0.80 m/s,  measured 0.55 m/s"

    def test_the_gait_is_that_of_the_time(self):
        shown = episode("trot", seconds=2.0)
        segments = (Segment(0.0, get("trot"), (0.8, 0.0, 0.0)), Segment(1.0, get("bound"), (0.8, 0.0, 0.0)))
        shown = replace(shown, script=Script("film", segments, 2.0))
        names = [self.strip(shown, sample)[1]._gait.get_text() for sample in (0, 199, 200, 399)]
        assert names == ["trot", "trot", "bound", "bound"]


class TestConfig:
    @pytest.mark.parametrize(
        ("change", "said"),
        [
            ({"size": (641, 360)}, "width.*even"),
            ({"size": (640, 10)}, "height.*160"),
            ({"size": (10**6, 360)}, "width.*3840"),
            ({"fps": 0}, "--fps"),
            ({"slow": 0.0}, "--slow"),
            ({"slow": math.nan}, "--slow"),
            ({"slow": math.inf}, "--slow"),
        ],
    )
    def test_bad(self, change, said):
        with pytest.raises(InvalidValue, match=said):
            FilmConfig(**change)

    def test_frames_fill_the_time_on_screen(self):
        assert FilmConfig(fps=25).frames_of(8.0) == 200
        assert FilmConfig(fps=30, slow=4.0).frames_of(0.5) == 60
        assert FilmConfig(fps=5, slow=0.05).frames_of(0.1) == 1
