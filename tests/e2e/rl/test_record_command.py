"""symdyn record as a user runs it: the file plays, with as many frames of the size as were asked for."""

from __future__ import annotations

import os
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from rl.pictures import headless_gl
from rl.pretrained import policy_path
from tests.e2e.command_in_process import symdyn
from tests.rl.pictures.headless import rendering_or_skip
from tests.symdyn.policy.policy_files import swaying

SHORT = ("--gaits", "trot", "bound", "--seconds", "0.3", "--size", "240", "160", "--fps", "10")


@pytest.fixture
def policy(tmp_path_factory) -> Path:
    return swaying(tmp_path_factory.mktemp("policy") / "sway.onnx")


def read_mp4(path: Path) -> tuple[dict, list[np.ndarray]]:
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    reader = ffmpeg.read_frames(str(path))
    about = next(reader)
    width, height = about["size"]
    return about, [np.frombuffer(frame, dtype=np.uint8).reshape(height, width, 3).astype(int) for frame in reader]


def test_mp4(policy, tmp_path):
    rendering_or_skip()
    done = symdyn("record", policy, *SHORT, "--out", "new/film.mp4", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    about, frames = read_mp4(tmp_path / "new" / "film.mp4")
    assert about["size"] == (240, 160)
    assert about["fps"] == 10
    assert len(frames) == 6
    assert all(np.abs(b - a).max() > 50 for a, b in pairwise(frames))
    said = " ".join(done.stdout.split())
    assert "Wrote new/film.mp4: 0.6 s of running, plays 0.6 s." in said
    assert f"symdyn evaluate {policy}" in "".join(done.stdout.splitlines())
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["film.mp4"]


def test_gif_in_slow_motion(policy, tmp_path):
    rendering_or_skip()
    done = symdyn("record", policy, *SHORT, "--slow", "2", "--out", "film.gif", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    with Image.open(tmp_path / "film.gif") as image:
        assert image.n_frames == 12
        assert image.size == (240, 160)
        assert image.info["duration"] == 100
    assert "0.6 s of running, plays 1.2 s" in done.stdout


def test_a_process_of_its_own_with_the_policy_that_comes_along(tmp_path):
    rendering_or_skip()
    environment = {name: value for name, value in os.environ.items() if name != "MUJOCO_GL"}
    command = [sys.executable, "-m", "symdyn", "record", "--seconds", "0.1", "--size", "160", "160", "--fps", "5"]
    done = subprocess.run(
        command, capture_output=True, text=True, cwd=tmp_path, timeout=300, check=False, env=environment
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    _, frames = read_mp4(tmp_path / "out" / "go2.mp4")
    assert len(frames) == 2
    assert str(policy_path()) in "".join(done.stdout.splitlines())


def test_the_same_seed_gives_the_same_film_and_another_another(policy, tmp_path):
    rendering_or_skip()
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        done = symdyn("record", policy, *SHORT, "--seed", seed, "--out", f"{name}.gif", cwd=tmp_path)
        assert done.returncode == 0, done.stderr
    a, b, c = ((tmp_path / f"{name}.gif").read_bytes() for name in "abc")
    assert a == b
    assert a != c


def test_it_ends_where_the_robot_falls_and_says_so(tmp_path):
    rendering_or_skip()
    policy = swaying(tmp_path / "falls.onnx", amount=3.0)
    done = symdyn("record", policy, *SHORT, "--seconds", "3", "--out", "film.gif", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "The robot fell after" in done.stdout
    with Image.open(tmp_path / "film.gif") as image:
        assert image.n_frames < 60


def test_one_speed_for_each_gait_one_gait_for_each_speed(policy):
    from rl.cli.arguments.record import RecordArguments
    from rl.cli.record import script_of

    for gaits, speeds, wanted in (
        (("trot", "pace"), (0.5, 1.0), [("trot", 0.5), ("pace", 1.0)]),
        (("trot", "pace"), (0.7,), [("trot", 0.7), ("pace", 0.7)]),
        (("trot",), (0.5, -1.0, 0.5), [("trot", 0.5), ("trot", -1.0), ("trot", 0.5)]),
    ):
        script = script_of(RecordArguments(gaits=gaits, speeds=speeds, seconds=1.5))
        assert [(segment.gait.name, segment.velocity[0]) for segment in script.segments] == wanted
        assert [segment.start for segment in script.segments] == [1.5 * k for k in range(len(wanted))]
        assert script.duration == 1.5 * len(wanted)


def test_where_nothing_can_be_rendered(policy, tmp_path, monkeypatch):
    monkeypatch.setattr(headless_gl, "renders", lambda name: False)
    monkeypatch.setenv("MUJOCO_GL", "")
    done = symdyn("record", policy, *SHORT, "--out", "film.gif", cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("symdyn: error: MuJoCo cannot render on this machine")
    assert done.stderr.count("\n") == 1
    for package in ("libegl1", "libgl1-mesa-dri", "libosmesa6"):
        assert package in done.stderr
    assert not list(tmp_path.iterdir())


def test_a_speed_that_was_never_trained_is_told_before_the_film(policy, tmp_path):
    flags = (
        "--gaits",
        "rotary_gallop_mirrored",
        "--speeds",
        "9",
        "--seconds",
        "0.1",
        "--size",
        "160",
        "160",
        "--fps",
        "5",
    )
    done = symdyn("record", policy, *flags, "--out", "film.gif", cwd=tmp_path)
    assert "outside the range of training, -2 to 2 m/s: 9 m/s" in " ".join(done.stdout.split())
    trained = symdyn("record", policy, *SHORT, "--out", "film.gif", cwd=tmp_path)
    assert "outside the range" not in trained.stdout
