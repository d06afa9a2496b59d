"""Diagrams that come with symdyn, explored by the solver that it comes with: ``python -m slip.cli.shipped``.

They are of use as long as their keys (:func:`slip.families.cache.key`) are: a change to any module of the solver
leaves them aside, and whoever makes it explores them anew.
"""

from __future__ import annotations

import shutil
from pathlib import Path

from slip.curves.cells import reaching
from slip.curves.settings import Selection
from slip.families.cache import SEARCH_TIME, SHIPPED, key
from slip.families.explore import ExploreConfig, explore
from slip.families.store import save
from slip.model.parameters import REFERENCE, SlipParameters
from slip.robot.body import load_body
from slip.robot.units import slip_parameters
from symdyn.io.console import make_console
from symdyn.robot.robot_file import DEFAULT_ROBOT


def wanted() -> dict[str, tuple[SlipParameters, ExploreConfig]]:
    """By key: the reference parameters' families, and what symdyn fit-curves fits to, the default robot's slow ones."""
    its = slip_parameters(load_body(DEFAULT_ROBOT))
    pairs = ((REFERENCE, ExploreConfig()), (its, reaching(its, Selection().speeds[1])))
    return {key(parameters, config): (parameters, config) for parameters, config in pairs}


def renew(folder: Path = SHIPPED) -> None:
    """Explore what is wanted and not there; remove what is no longer wanted."""
    console = make_console()
    diagrams = wanted()
    for old in folder.glob("*"):
        if old.name not in diagrams:
            shutil.rmtree(old)
    for name, (parameters, config) in diagrams.items():
        if not (folder / name).is_dir():
            with console.status(f"{parameters} ({SEARCH_TIME})"):
                save(explore(parameters, config), folder / name)
        console.print(folder / name)


if __name__ == "__main__":
    renew()
