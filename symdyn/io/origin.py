"""Where the running code came from."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path


def commit(package: Path = Path(__file__).parent) -> str:
    """The commit of the checkout that a package is imported from, with ``-dirty`` if the checkout has changes.

    Args:
        package: directory of the package.

    Returns:
        40 hex digits, with or without ``-dirty``; ``unknown`` if there is no git or the package is no part of a
        checkout (it may lie, ignored, inside one: a virtual environment in a project of the user's).
    """
    try:
        _git(package, "ls-files", "--error-unmatch", "__init__.py")
        head = _git(package, "rev-parse", "HEAD").strip()
        return head + ("-dirty" if _git(package, "status", "--porcelain").strip() else "")
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


def _git(directory: Path, *arguments: str) -> str:
    command = ["git", "--no-optional-locks", "-C", str(directory), *arguments]
    # inside a git hook these name the hook's repository, wherever -C points
    environment = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
    return subprocess.run(command, check=True, capture_output=True, text=True, env=environment).stdout
