"""Moving pictures read back from their files: number, size, order and speed of the frames."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from symdyn.errors import InvalidValue
from symdyn.figures.video import stretched, write_video


def greys(count: int) -> list[np.ndarray]:
    """Frames from black to white."""
    return [np.full((64, 96, 3), round(250 * k / (count - 1)), dtype=np.uint8) for k in range(count)]


def bars(count: int) -> list[np.ndarray]:
    """Black frames with a white bar that wanders to the right."""
    frames = [np.zeros((64, 96, 3), dtype=np.uint8) for _ in range(count)]
    for k, frame in enumerate(frames):
        frame[:, 4 * k : 4 * k + 4] = 255
    return frames


@pytest.mark.parametrize("fps", [7, 25, 30, 50])
def test_a_gif_plays_as_long_as_its_frames_say(tmp_path, fps):
    write_video(tmp_path / "x.gif", iter(bars(20)), fps)
    with Image.open(tmp_path / "x.gif") as image:
        assert (image.n_frames, image.size) == (20, (96, 64))
        delays, shown = [], []
        for k in range(image.n_frames):
            image.seek(k)
            delays.append(image.info["duration"])
            shown.append(np.asarray(image.convert("L")))
    assert sum(delays) == pytest.approx(1000.0 * 20 / fps, abs=5.0)
    assert max(delays) - min(delays) <= 10
    np.testing.assert_array_equal(shown, [frame[..., 0] for frame in bars(20)])


def test_an_mp4_holds_the_frames_in_order(tmp_path):
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    write_video(tmp_path / "x.mp4", iter(greys(12)), 30)
    reader = ffmpeg.read_frames(str(tmp_path / "x.mp4"))
    about = next(reader)
    shown = [np.frombuffer(frame, dtype=np.uint8).mean() for frame in reader]
    assert about["size"] == (96, 64)
    assert about["fps"] == 30
    np.testing.assert_allclose(shown, [frame.mean() for frame in greys(12)], atol=6.0)


def test_no_frame_is_made_for_a_format_that_does_not_exist(tmp_path):
    def never():
        raise AssertionError
        yield

    with pytest.raises(InvalidValue, match=r"\.gif, \.mp4"):
        write_video(tmp_path / "x.avi", never(), 25)


def test_words_for_the_speed():
    assert stretched(4.0) == "slow motion, 1 : 4"
    assert stretched(0.5) == "2 times as fast"
