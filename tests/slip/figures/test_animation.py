import builtins
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from slip.figures.animation import animate, frames, slowed, spring
from slip.figures.animation_config import AnimationConfig
from slip.robot.units import Units
from symdyn.errors import FileProblem, InvalidValue, ResourceProblem
from symdyn.figures.plots import LEG_COLOURS
from tests.slip.orbits.stored_orbits import hop, orbit

SMALL = AnimationConfig(strides=2, seconds=0.4, fps=20, width=320)
GO2_UNITS = Units(mass=15.0, length=0.387)


def close_to(frame: np.ndarray, colour: str) -> np.ndarray:
    """Where a picture has a colour, (height, width)."""
    wanted = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
    return (np.abs(frame.astype(int) - wanted) <= 12).all(axis=-1)


class TestFrames:
    def test_number_and_size(self):
        shown = list(frames(orbit("GG"), "GG", SMALL))
        assert len(shown) == SMALL.strides * 8
        width, height = SMALL.size
        assert all(frame.shape == (height, width, 3) and frame.dtype == np.uint8 for frame in shown)

    def test_progress(self):
        seen = []
        list(frames(hop(), "hop", SMALL, progress=lambda done, total: seen.append((done, total))))
        assert seen == [(i + 1, 16) for i in range(16)]

    def test_the_camera_keeps_the_torso_in_the_middle(self):
        for frame in frames(orbit("BG"), "BG", SMALL):
            columns = np.flatnonzero(close_to(frame, "#3C4650").any(axis=0))
            assert abs(columns.mean() - frame.shape[1] / 2) < 12

    def test_arrows_only_while_feet_stand(self):
        start = orbit("PK")
        shown = list(frames(start, "PK", AnimationConfig(strides=1, seconds=1.0, fps=20, width=320)))
        world = [frame[: int(0.76 * frame.shape[0])] for frame in shown]
        arrows = np.array([close_to(frame, "#B2182B").sum() > 5 for frame in world])
        time = np.arange(20) / 20 * start.period
        touchdown, liftoff = start.touchdowns[0], start.liftoffs[0]
        margin = 0.08 * start.period
        assert not arrows[(time < touchdown) | (time > liftoff)].any()
        assert arrows[(time > touchdown + margin) & (time < liftoff - margin)].all()

    def test_without_forces(self):
        config = AnimationConfig(strides=1, seconds=0.4, fps=20, width=320, forces=False)
        for frame in frames(orbit("PK"), "PK", config):
            assert not close_to(frame[: int(0.76 * frame.shape[0])], "#B2182B").any()

    def test_legs_that_move_together_both_show(self):
        frame = next(iter(frames(orbit("BG"), "BG", AnimationConfig(strides=1, width=800))))
        world = frame[: int(0.6 * frame.shape[0])]
        for leg in ("RH", "RF"):
            assert close_to(world, LEG_COLOURS[leg]).sum() > 50


class TestSpring:
    @given(
        st.tuples(st.floats(-5, 5), st.floats(-5, 5)),
        st.tuples(st.floats(-5, 5), st.floats(-5, 5)),
        st.floats(0.0, 0.2),
    )
    def test_from_hip_to_foot_and_no_wider(self, hip, foot, width):
        hip, foot = np.array(hip), np.array(foot)
        points = spring(hip, foot, width)
        assert np.allclose(points[[0, -1]], [hip, foot])
        along = foot - hip
        length = math.hypot(*along)
        if length > 1e-6:
            off = points - hip
            across = np.abs(off[:, 0] * along[1] - off[:, 1] * along[0]) / length
            assert across.max() <= width + 1e-9
            shares = off @ along / length**2
            assert (np.diff(shares) > -1e-9).all()

    def test_no_length(self):
        assert np.isfinite(spring(np.zeros(2), np.zeros(2), 0.1)).all()


class TestFiles:
    def test_gif(self, tmp_path):
        path = tmp_path / "new" / "gallop.gif"
        animate(orbit("GG"), path, "GG", SMALL)
        with Image.open(path) as image:
            assert image.n_frames == 16
            assert image.size == SMALL.size
            assert image.info["duration"] == 50
            assert image.info["loop"] == 0
        assert list(path.parent.iterdir()) == [path]

    def test_mp4(self, tmp_path):
        ffmpeg = pytest.importorskip("imageio_ffmpeg")
        path = tmp_path / "gallop.mp4"
        animate(orbit("GG"), path, "GG", SMALL, GO2_UNITS)
        count, seconds = ffmpeg.count_frames_and_secs(str(path))
        assert count == 16
        assert seconds == pytest.approx(0.8, abs=0.06)

    def test_mp4_without_the_package(self, tmp_path, monkeypatch):
        real = builtins.__import__

        def missing(name, *args, **kwargs):
            if name == "imageio_ffmpeg":
                raise ModuleNotFoundError(name=name)
            return real(name, *args, **kwargs)

        monkeypatch.setattr(builtins, "__import__", missing)
        with pytest.raises(ResourceProblem, match="imageio-ffmpeg"):
            animate(orbit("GG"), tmp_path / "gallop.mp4", "GG", SMALL)
        assert not list(tmp_path.iterdir())

    def test_unknown_format(self, tmp_path):
        with pytest.raises(InvalidValue, match=r"\.gif, \.mp4"):
            animate(orbit("GG"), tmp_path / "gallop.avi", "GG", SMALL)

    @pytest.mark.parametrize("suffix", ("gif", "mp4"))
    def test_nothing_half_written(self, tmp_path, suffix):
        if suffix == "mp4":
            pytest.importorskip("imageio_ffmpeg")

        def stop(done: int, total: int) -> None:
            if done == 3:
                raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            animate(orbit("GG"), tmp_path / f"gallop.{suffix}", "GG", SMALL, progress=stop)
        assert not list(tmp_path.iterdir())

    def test_no_place(self, tmp_path):
        (tmp_path / "file").write_text("")
        with pytest.raises(FileProblem):
            animate(orbit("GG"), tmp_path / "file" / "gallop.gif", "GG", SMALL)


class TestConfig:
    @pytest.mark.parametrize(
        "change", [{"strides": 0}, {"fps": 1}, {"width": 10}, {"seconds": math.nan}, {"seconds": 0.0}]
    )
    def test_bad(self, change):
        with pytest.raises(InvalidValue, match=next(iter(change))):
            AnimationConfig(**change)

    def test_slow_motion(self):
        config = AnimationConfig(seconds=2.0)
        shown = orbit("PK")
        factor = 2.0 / (shown.period * GO2_UNITS.time)
        assert slowed(shown, config, GO2_UNITS) == f"slow motion, 1 : {factor:.3g}"
        assert f"{shown.period / 2.0:.3g}" in slowed(shown, config, None)
        assert "times as fast" in slowed(shown, AnimationConfig(seconds=0.2), Units(15.0, 5.0))
