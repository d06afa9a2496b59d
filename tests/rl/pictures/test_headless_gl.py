"""Which way of rendering is taken, and the one sentence where none works."""

from __future__ import annotations

import subprocess
import sys

import pytest

from rl.pictures import headless_gl
from symdyn.errors import ResourceProblem
from tests.rl.pictures.headless import rendering_or_skip

PACKAGES = ("libegl1", "libgl1-mesa-dri", "MUJOCO_GL=egl", "libosmesa6", "MUJOCO_GL=osmesa")


@pytest.fixture
def working(monkeypatch: pytest.MonkeyPatch):
    """Pretend that just these values of MUJOCO_GL work; MUJOCO_GL itself is not set."""

    def pretend(*names: str) -> list[str]:
        tried: list[str] = []
        monkeypatch.setattr(headless_gl, "renders", lambda name: tried.append(name) or name in names)
        monkeypatch.setattr(headless_gl.importlib, "reload", lambda module: module)
        return tried

    monkeypatch.setenv("MUJOCO_GL", "")
    return pretend


def test_egl_is_tried_before_osmesa(working) -> None:
    tried = working("osmesa")
    assert headless_gl.use_working_backend() == "osmesa"
    assert tried == ["egl", "osmesa"]
    working("egl", "osmesa")
    headless_gl.os.environ["MUJOCO_GL"] = ""
    assert headless_gl.use_working_backend() == "egl"


def test_what_the_environment_says_is_respected(working, monkeypatch: pytest.MonkeyPatch) -> None:
    tried = working("egl", "osmesa")
    monkeypatch.setenv("MUJOCO_GL", "osmesa")
    assert headless_gl.use_working_backend() == "osmesa"
    assert tried == ["osmesa"]


@pytest.mark.parametrize("setting", ["", "egl", "bogus"])
def test_where_nothing_works_it_says_what_to_install(working, monkeypatch: pytest.MonkeyPatch, setting: str) -> None:
    working()
    monkeypatch.setenv("MUJOCO_GL", setting)
    with pytest.raises(ResourceProblem) as caught:
        headless_gl.use_working_backend()
    for words in (*PACKAGES, f"MUJOCO_GL={setting}"):
        assert words in str(caught.value)
    assert str(caught.value).count(". ") == 0


def test_a_probe_that_fails_crashes_or_hangs_is_no_rendering(monkeypatch: pytest.MonkeyPatch) -> None:
    assert not headless_gl.renders("bogus")
    for code in ("import os; os.abort()", "import time; time.sleep(60)"):
        headless_gl.renders.cache_clear()
        monkeypatch.setattr(headless_gl, "_PROBE", code)
        monkeypatch.setattr(headless_gl, "_PROBE_S", 1.0)
        assert not headless_gl.renders("egl")
    headless_gl.renders.cache_clear()


@pytest.mark.parametrize("setting", ["bogus", "disable"])
def test_a_setting_that_mujoco_refuses_gives_a_process_one_sentence(setting: str, tmp_path) -> None:
    command = ["env", f"MUJOCO_GL={setting}", sys.executable, "-m", "symdyn", "record", "--out", "film.mp4"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, timeout=120, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith(f"symdyn: error: MuJoCo cannot render with MUJOCO_GL={setting}")
    assert done.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_after_that_mujoco_renders_here() -> None:
    rendering_or_skip()
    import mujoco

    model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='1' rgba='1 0 0 1'/></worldbody></mujoco>")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    with mujoco.Renderer(model, 32, 32) as renderer:
        renderer.update_scene(data)
        red, green, blue = renderer.render()[16, 16]
    assert red > 100
    assert max(green, blue) < 0.5 * red
