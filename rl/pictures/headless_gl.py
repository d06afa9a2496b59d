"""Rendering without a screen: find out what of MuJoCo's ways to do it works on this machine, and take it.

Import this before other modules that import MuJoCo: it turns what MuJoCo then says about MUJOCO_GL into one sentence.
"""

from __future__ import annotations

import functools
import importlib
import logging
import os
import subprocess
import sys

from symdyn.errors import ResourceProblem

_log = logging.getLogger(__name__)

VARIABLE = "MUJOCO_GL"
CANDIDATES = ("egl", "osmesa") if sys.platform == "linux" else ("",)
"""What is tried where the environment does not say; elsewhere MuJoCo's own choice needs no screen."""

REMEDY = f"install Debian's libegl1 and libgl1-mesa-dri and set {VARIABLE}=egl, or libosmesa6 and set {VARIABLE}=osmesa"

_PROBE_S = 60.0
_PROBE = """
import sys, mujoco
model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='1' rgba='1 0 0 1'/></worldbody></mujoco>")
data = mujoco.MjData(model)
mujoco.mj_forward(model, data)
with mujoco.Renderer(model, 16, 16) as renderer:
    renderer.update_scene(data)
    sys.exit(0 if renderer.render().any() else 1)
"""


def _refused(setting: str) -> ResourceProblem:
    return ResourceProblem(f"MuJoCo cannot render with {VARIABLE}={setting} on this machine: unset it, or {REMEDY}.")


try:
    gl_context = importlib.import_module("mujoco.rendering.classic.gl_context")
except ModuleNotFoundError:
    raise
except (AttributeError, ImportError, OSError, RuntimeError) as _error:
    # an unknown value, or a library that is not there: MuJoCo looks when it is imported
    raise _refused(os.environ.get(VARIABLE, "")) from _error


def use_working_backend() -> str:
    """Make MuJoCo render off screen in this process: as MUJOCO_GL says, or else with EGL or OSMesa.

    Returns:
        What MUJOCO_GL is now.

    Raises:
        ResourceProblem: if nothing can be rendered; it says what to install.
    """
    setting = os.environ.get(VARIABLE, "")
    for name in (setting,) if setting else CANDIDATES:
        if renders(name):
            os.environ[VARIABLE] = name
            importlib.reload(gl_context)  # which reads the variable only once
            return name
    if setting:
        raise _refused(setting)
    raise ResourceProblem(f"MuJoCo cannot render on this machine, neither with EGL nor with OSMesa: {REMEDY}.")


@functools.cache
def renders(name: str) -> bool:
    """Whether MuJoCo renders a picture with this value of MUJOCO_GL. In a process of its own: some drivers crash."""
    environment = {**os.environ, VARIABLE: name}
    try:
        probe = subprocess.run(
            [sys.executable, "-c", _PROBE], env=environment, capture_output=True, timeout=_PROBE_S, check=False
        )
    except subprocess.TimeoutExpired:
        _log.debug("%s=%s: no picture within %g s", VARIABLE, name, _PROBE_S)
        return False
    if probe.returncode:
        _log.debug("%s=%s: %s", VARIABLE, name, probe.stderr.decode(errors="replace"))
    return probe.returncode == 0
