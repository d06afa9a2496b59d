"""A command of symdyn run in this process: an interpreter that imports torch anew for each case would take minutes."""

from __future__ import annotations

import contextlib
import io
import subprocess
from pathlib import Path

from symdyn_cli.main import main

Done = subprocess.CompletedProcess[str]


def symdyn(*arguments: object, cwd: Path | None = None) -> Done:
    """``symdyn ARGUMENTS`` in a directory, or in the present one; never raises for bad input."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.chdir(cwd or "."), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = main(list(map(str, arguments)))
        except SystemExit as stop:  # the parser's own way out
            code = stop.code
    return Done(list(map(str, arguments)), int(code or 0), out.getvalue(), err.getvalue())
