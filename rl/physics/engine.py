"""Settings of the physics engine as data: one set to judge in, a cheaper one to learn in."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from symdyn.errors import InvalidValue, UnknownName


@dataclass(frozen=True)
class EngineConfig:
    """How MuJoCo integrates and solves for contact forces; the defaults are those that policies are judged in.

    Attributes:
        timestep: physics step, s. The robot's control step must be a multiple of it.
        integrator: ``implicitfast``, ``implicit`` or ``euler``.
        solver: solver of the contact forces: ``newton``, ``cg`` or ``pgs`` (projected Gauss-Seidel).
        cone: friction cone: ``elliptic`` or ``pyramidal``. The pyramidal one is weaker along its diagonals.
        impratio: stiffness of friction relative to that of the normal force. With 10 loaded feet creep ten times less
            than with MuJoCo's default of 1.
        iterations: most iterations of the solver.
        ls_iterations: most iterations of Newton's line search.
    """

    timestep: float = 0.005
    integrator: Literal["implicitfast", "implicit", "euler"] = "implicitfast"
    solver: Literal["newton", "cg", "pgs"] = "newton"
    cone: Literal["elliptic", "pyramidal"] = "elliptic"
    impratio: float = 10.0
    iterations: int = 10
    ls_iterations: int = 20

    def __post_init__(self) -> None:
        for name in ("timestep", "impratio", "iterations", "ls_iterations"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise InvalidValue(f"engine.{name}", getattr(self, name), "a number > 0")


ACCURATE = EngineConfig()

ENGINES: Mapping[str, EngineConfig] = {
    "accurate": ACCURATE,
    "fast": EngineConfig(timestep=0.01, solver="pgs"),
}
"""``accurate``: what every reported figure is from. ``fast``: about a third of its cost, for learning."""


def get_engine(name: str) -> EngineConfig:
    """The settings of that name. Raises UnknownName."""
    try:
        return ENGINES[name]
    except KeyError:
        raise UnknownName("engine", name, ENGINES) from None
