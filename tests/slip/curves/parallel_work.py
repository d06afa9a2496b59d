"""Work on cells for tests/test_parallel.py: at the top of a module, since it travels to other processes.

Run as a program, it does forty slow cells in the folder of its argument, to be killed.
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path
from typing import Any

from slip.curves.parallel import run_cells
from slip.curves.settings import Workers
from symdyn.errors import InvalidValue


def square(cell: dict[str, Any]) -> dict[str, Any]:
    """x^2; logs that it was called if the cell names a file."""
    if "log" in cell:
        with Path(cell["log"]).open("a") as stream:
            stream.write(f"{cell['x']}\n")
    if cell["x"] == 3:
        raise InvalidValue("x", 3, "another number")
    if cell["x"] == 5:
        raise TypeError("a defect")
    return {"square": cell["x"] ** 2}


def slow_square(cell: dict[str, Any]) -> dict[str, Any]:
    """x^2 after a while."""
    time.sleep(0.2)
    return square(cell)


def die(cell: dict[str, Any]) -> dict[str, Any]:
    """End the process as a lack of memory would."""
    os._exit(9)


def slow_cells(folder: Path) -> dict[str, dict[str, Any]]:
    """Forty cells that log their work; none of those that fail."""
    return {f"x{i}": {"x": i, "log": str(folder / "log.txt")} for i in range(10, 50)}


if __name__ == "__main__":
    out = Path(sys.argv[1])
    run_cells(slow_square, slow_cells(out), out, {"work": "squares"}, Workers(int(sys.argv[2])))
