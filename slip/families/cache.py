"""Diagrams that were explored before, by parameters: exploring takes minutes, loading none.

They lie in the user's cache folder: ``$SYMDYN_CACHE``, else ``$XDG_CACHE_HOME/symdyn``, else ``~/.cache/symdyn``.
Some come with symdyn (``python -m slip.cli.shipped`` makes them).
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import json
import logging
import os
import re
from collections.abc import Callable, Iterator
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from rich.console import Console

from slip.families.branch import Diagram
from slip.families.explore import ExploreConfig, explore
from slip.families.store import load, save
from slip.model.parameters import SlipParameters
from symdyn.errors import FileProblem

_IMPORT = re.compile(r"^\s*from (slip[\w.]*) import ([\w, ]+)", re.MULTILINE)
_PACKAGE = Path(__file__).parents[1]

SHIPPED = Path(__file__).parent / "data" / "families"
"""Where those are that come with symdyn."""

Report = Callable[[str, int], None]

SEARCH_TIME = "one to three minutes"
"""How long a search takes on two free cores."""

_log = logging.getLogger(__name__)


def cache_folder() -> Path:
    """Where symdyn keeps what it can compute again."""
    given = os.environ.get("SYMDYN_CACHE")
    if given:
        return Path(given).expanduser()
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "symdyn"


def explored(
    parameters: SlipParameters,
    config: ExploreConfig | None = None,
    cache: bool = True,
    report: Report | None = None,
) -> Diagram:
    """The diagram of a model, from the cache if it is there. Of processes that want the same one, one explores.

    Args:
        parameters: of the model.
        config: what to look for.
        cache: whether to take what comes with symdyn or is in the cache, and to keep the diagram there. A cache that
            cannot be read or written is no error: the diagram is explored anew.
        report: told what is being traced and how many orbits there are so far. If None, the standard error stream
            shows it: a search takes minutes, and a silent one looks as if it hung.
    """
    config = config or ExploreConfig()
    if not cache:
        return _searched(parameters, config, report)
    name = key(parameters, config)
    if (SHIPPED / name).is_dir():
        return load(SHIPPED / name)
    folder = cache_folder() / "families" / name
    with _alone(folder.with_suffix(".lock")):
        if folder.is_dir():
            try:
                return load(folder)
            except FileProblem as problem:
                _log.warning("The cached families cannot be read and are searched again. %s", problem)
        diagram = _searched(parameters, config, report)
        try:
            save(diagram, folder)
        except FileProblem as problem:
            _log.warning("The families are not cached. %s", problem)
        return diagram


def _searched(parameters: SlipParameters, config: ExploreConfig, report: Report | None) -> Diagram:
    if report is not None:
        return explore(parameters, config, report)
    console = Console(stderr=True)
    if not console.is_terminal:
        console.print(f"Searching the families of passive gaits ({SEARCH_TIME}).", soft_wrap=True)
        return explore(parameters, config, lambda _what, _count: None)
    with console.status("Searching the families of passive gaits") as status:
        return explore(parameters, config, lambda what, count: status.update(progress_line(what, count)))


def progress_line(what: str, count: int) -> str:
    """What a display says while a search runs."""
    return f"Tracing {what}: {count} orbits so far ({SEARCH_TIME})"


@contextlib.contextmanager
def _alone(path: Path) -> Iterator[None]:
    """One process at a time, as far as the file can be written."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        stream = path.open("w")
    except OSError:
        yield
        return
    with stream:
        fcntl.flock(stream, fcntl.LOCK_EX)  # ends with the file or the process
        yield


def key(parameters: SlipParameters, config: ExploreConfig) -> str:
    """Name of a diagram's folder: parameters, settings, and the solver's source."""
    settings = json.dumps([parameters.vector().tolist(), asdict(config)], sort_keys=True)
    digest = hashlib.sha256(settings.encode())
    digest.update(_solver().encode())
    return digest.hexdigest()[:20]


def _solver() -> str:
    """What stands for the program that explores: its release, and its source in case someone changes it."""
    try:
        release = version("symdyn-gaits")
    except PackageNotFoundError:
        release = "unknown"
    digest = hashlib.sha256(release.encode())
    for module in solver_modules():
        digest.update(_source(module))
    return digest.hexdigest()


def solver_modules() -> list[str]:
    """Modules that decide what is found: slip.families.explore and all of slip that it imports, sorted."""
    found: set[str] = set()
    queue = ["slip.families.explore"]
    while queue:
        module = queue.pop()
        if module not in found:
            found.add(module)
            for parent, names in _IMPORT.findall(_source(module).decode()):
                # a name is a module of the package, or something inside a module
                inside = [f"{parent}.{name.split()[0]}" for name in names.split(",") if name.strip()]
                queue += [name for name in inside if _path(name).is_file()] or [parent]
    return sorted(found)


def _path(module: str) -> Path:
    return _PACKAGE.joinpath(*module.split(".")[1:]).with_suffix(".py")


def _source(module: str) -> bytes:
    return _path(module).read_bytes()
