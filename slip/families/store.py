"""Branch diagrams on disk: ``families.npz`` with every orbit, ``families.json`` for people and other programs."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from slip.families.branch import Branch, Diagram, Junction
from slip.families.search import CONFIRMED
from slip.model.parameters import SlipParameters
from slip.model.unknowns import UNKNOWN_NAMES
from slip.orbits.integrate import TOLERANCE
from slip.orbits.newton import ACCEPTED
from symdyn.errors import FileProblem, SymdynError
from symdyn.io.files import read_json, write_json, write_with

FORMAT_VERSION = 1
ARRAYS = "families.npz"
SUMMARY = "families.json"


def summary(diagram: Diagram) -> dict[str, Any]:
    """What ``families.json`` holds."""
    return {
        "format_version": FORMAT_VERSION,
        "parameters": asdict(diagram.parameters),
        "units": "torso mass, g and torso length are 1",
        "tolerances": {"residual": ACCEPTED, "integration": TOLERANCE, "independent_simulation": CONFIRMED},
        "unknowns": list(UNKNOWN_NAMES),
        "branches": [
            {
                "name": branch.name,
                "dx_min": float(branch.speeds.min()),
                "dx_max": float(branch.speeds.max()),
                "orbits": len(branch),
                "stable_share": float(branch.stable.mean()),
                "confirmed_to": float(branch.confirmed.max()),
                "ends": list(branch.ends),
            }
            for branch in diagram.branches
        ],
        "junctions": [
            {
                "on": junction.on,
                "to": junction.to,
                "pair": junction.pair,
                "dx": junction.dx,
                "T": junction.T,
                "dphi": junction.dphi,
                "unknowns": list(junction.unknowns),
            }
            for junction in diagram.junctions
        ],
        "missing": diagram.missing,
    }


def save(diagram: Diagram, folder: Path) -> tuple[Path, Path]:
    """Write both files, each whole or not at all. Returns their paths.

    Raises:
        FileProblem: if the folder cannot be written to.
    """
    arrays: dict[str, Any] = {}
    for branch in diagram.branches:
        arrays[f"{branch.name}/unknowns"] = branch.unknowns
        arrays[f"{branch.name}/multipliers"] = branch.multipliers
        arrays[f"{branch.name}/confirmed"] = branch.confirmed
    for family, unknowns in diagram.refused.items():
        arrays[f"refused/{family}"] = unknowns

    def write_arrays(path: Path) -> None:
        with path.open("wb") as file:
            np.savez_compressed(file, **arrays)

    paths = folder / ARRAYS, folder / SUMMARY
    write_with(paths[0], write_arrays)
    write_json(paths[1], summary(diagram))
    return paths


def load(folder: Path) -> Diagram:
    """Read what :func:`save` wrote.

    Raises:
        FileProblem: if a file is missing or does not hold what it should.
    """
    try:
        described = read_json(folder / SUMMARY)
        if described["format_version"] != FORMAT_VERSION:
            raise FileProblem(folder / SUMMARY, f"has format {described['format_version']}, not {FORMAT_VERSION}")
        parameters = SlipParameters(**described["parameters"])
        with np.load(folder / ARRAYS, allow_pickle=False) as arrays:
            branches = tuple(
                Branch(
                    entry["name"],
                    parameters,
                    arrays[f"{entry['name']}/unknowns"],
                    arrays[f"{entry['name']}/multipliers"],
                    arrays[f"{entry['name']}/confirmed"],
                    (entry["ends"][0], entry["ends"][1]),
                )
                for entry in described["branches"]
            )
            refused = {name.removeprefix("refused/"): arrays[name] for name in arrays if name.startswith("refused/")}
        junctions = tuple(
            Junction(
                **{key: value for key, value in entry.items() if key != "unknowns"}, unknowns=tuple(entry["unknowns"])
            )
            for entry in described["junctions"]
        )
        return Diagram(parameters, branches, junctions, described["missing"], refused)
    except OSError as problem:
        raise FileProblem(problem.filename or folder, problem.strerror or "cannot be read") from None
    except SymdynError:
        raise
    except (ValueError, KeyError, TypeError, IndexError) as problem:
        raise FileProblem(folder, f"does not hold gait families ({problem!r})") from None
