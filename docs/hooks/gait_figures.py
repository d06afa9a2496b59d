"""Footfall pictures of the gaits of the theory pages, by ``symdyn gaits NAME --figure``."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from tempfile import TemporaryDirectory

from symdyn_cli.main import main

_SHOWN = ("trot", "bound", "half_bound_left", "rotary_gallop")


def pages() -> dict[str, bytes]:
    """Pictures by path."""
    with TemporaryDirectory() as folder:
        return {f"images/gaits/{name}.svg": _drawn(name, Path(folder) / f"{name}.svg") for name in _SHOWN}


def _drawn(name: str, path: Path) -> bytes:
    with contextlib.redirect_stdout(io.StringIO()):
        main(["gaits", name, "--figure", str(path)])
    return path.read_bytes()
