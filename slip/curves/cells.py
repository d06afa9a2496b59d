"""The families of one set of parameters as a cell of parallel, resumable work (:mod:`slip.curves.parallel`)."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any

from slip.curves.points import PassiveOrbits
from slip.families.branch import Diagram
from slip.families.continuation import StepConfig
from slip.families.explore import ExploreConfig, explore
from slip.model.parameters import SlipParameters
from slip.robot.units import unstarred

TRACER = 2
"""Counts changes of the tracer that change its results: what an earlier one found is not taken for today's."""

WORK = "families of passive gaits (slip.families.explore.explore)"

_FASTER_AT_THE_APEX = 1.25
"""Orbits whose mean speed is within the range are at the apex at most so much faster."""


def reaching(parameters: SlipParameters, fastest: float, trot: bool = True, carry: bool = True) -> ExploreConfig:
    """How far to trace.

    Args:
        parameters: of the model.
        fastest: v* up to which orbits are wanted.
        trot: whether to look for trot and pace, too.
        carry: whether to carry over, from the reference parameters, families that no junction leads to.
    """
    steps = StepConfig(max_speed=unstarred(fastest, parameters) * _FASTER_AT_THE_APEX)
    default = ExploreConfig(steps=steps, trot=trot)
    return default if carry else replace(default, seeds=0)


def settings(fastest: float, trot: bool, carry: bool) -> dict[str, Any]:
    """What the cells of a study have in common; arguments as for :func:`reaching`."""
    return {"work": WORK, "tracer": TRACER, "fastest": fastest, "trot": trot, "carry": carry}


def cell(parameters: SlipParameters, fastest: float, trot: bool = True, carry: bool = True) -> dict[str, Any]:
    """What is to be traced; arguments as for :func:`reaching`."""
    return {"parameters": asdict(parameters), "fastest": fastest, "trot": trot, "carry": carry}


def trace_cell(cell: dict[str, Any]) -> dict[str, Any]:
    """Trace the families of :func:`cell`.

    Returns:
        ``orbits`` (:meth:`slip.curves.points.PassiveOrbits.as_dict`), ``branches``, ``junctions``, ``missing``.

    Raises:
        SymdynError: for bad parameters.
    """
    parameters = SlipParameters(**cell["parameters"])
    diagram = explore(parameters, reaching(parameters, cell["fastest"], cell["trot"], cell["carry"]))
    return {
        "orbits": PassiveOrbits.of(diagram.branches).as_dict(),
        "branches": branch_table(diagram),
        "junctions": [
            {"on": j.on, "to": j.to, "pair": j.pair, "dx": j.dx, "T": j.T, "dphi": j.dphi} for j in diagram.junctions
        ],
        "missing": dict(diagram.missing),
    }


def branch_table(diagram: Diagram) -> list[dict[str, Any]]:
    """Extent, number of orbits and of stable ones, and ends of every branch, for JSON."""
    return [
        {
            "name": branch.name,
            "dx_min": float(branch.speeds.min()),
            "dx_max": float(branch.speeds.max()),
            "orbits": len(branch),
            "stable": int(branch.stable.sum()),
            "ends": list(branch.ends),
        }
        for branch in diagram.branches
    ]
