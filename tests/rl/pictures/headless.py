"""Tests that render: skipped, with the reason, where nothing can be rendered; failing there if that must not be."""

from __future__ import annotations

import os

import pytest

from rl.pictures import headless_gl
from symdyn.errors import ResourceProblem

REQUIRED = "SYMDYN_TEST_RENDERING"
"""Set to ``required`` where the libraries are installed: then a test that cannot render fails."""


def rendering_or_skip() -> None:
    """Make MuJoCo render in this process."""
    try:
        headless_gl.use_working_backend()
    except ResourceProblem as problem:
        if os.environ.get(REQUIRED) == "required":
            raise
        pytest.skip(str(problem))
