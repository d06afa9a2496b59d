"""How fast the passive dynamics are: against SciPy's adaptive integrator, and the whole search from a cold start."""

from __future__ import annotations

import subprocess
import sys
import time

import numpy as np
from numpy.typing import NDArray

from benchmarks.result import Result, in_turns
from slip.families.branch import Branch
from slip.families.explore import explore
from slip.model.parameters import REFERENCE
from slip.model.unknowns import COUNT, DX
from slip.orbits import kernel
from slip.orbits.independent_simulation import residual_with_given_times
from slip.orbits.newton import correct
from slip.orbits.orbit import jacobian, residual
from slip.orbits.subspace import subspace

_ROUNDS = 5
_STEP = 1e-6
_SOLVED = 4


def _scipy_jacobian(unknowns: NDArray[np.float64]) -> NDArray[np.float64]:
    base = residual_with_given_times(unknowns, REFERENCE)
    columns = [(residual_with_given_times(unknowns + _STEP * e, REFERENCE) - base) / _STEP for e in np.eye(COUNT)]
    return np.array(columns).T


def _solve_with_scipy(branch: Branch) -> None:
    """Newton's method of slip.orbits.newton on a few orbits of a branch, with SciPy's residuals,
    finite differences."""
    space = subspace(*branch.pairs)
    normal = np.eye(COUNT)[DX] @ space.basis
    for start in _starts(branch):
        coordinates = space.coordinates(start)
        for _ in range(10):
            unknowns = space.unknowns(coordinates)
            found = residual_with_given_times(unknowns, REFERENCE)
            if np.abs(found).max() < 1e-9:
                break
            matrix = np.vstack((space.jacobian(_scipy_jacobian(unknowns)), normal))
            coordinates = coordinates - np.linalg.solve(matrix, np.append(space.residual(found), 0.0))


def _solve(branch: Branch) -> None:
    space = subspace(*branch.pairs)
    normal = np.eye(COUNT)[DX] @ space.basis
    for start in _starts(branch):
        correct(space, space.coordinates(start), normal, REFERENCE.vector())


def _starts(branch: Branch) -> list[NDArray[np.float64]]:
    """Between orbits of a branch, where no orbit is."""
    where = np.linspace(0, len(branch) - 3, _SOLVED).astype(int)
    return [0.5 * (branch.unknowns[i] + branch.unknowns[i + 2]) for i in where]


def measure() -> list[Result]:
    """Speed against SciPy at equal accuracy, one branch solved both ways, and all families from a cold start."""
    start = time.perf_counter()
    # a process of its own: nothing compiled, nothing cached
    code = "from slip.families.explore import explore; from slip.model.parameters import REFERENCE; explore(REFERENCE)"
    subprocess.run([sys.executable, "-c", code], check=True)
    cold = time.perf_counter() - start

    diagram = explore(REFERENCE)
    branch = diagram.family("HE")[0]
    unknowns = branch.unknowns[len(branch) // 2]
    accuracy = float(np.abs(residual(unknowns, REFERENCE) - residual_with_given_times(unknowns, REFERENCE)).max())
    ours, theirs = in_turns(
        [
            lambda: (residual(unknowns, REFERENCE), jacobian(unknowns, REFERENCE)),
            lambda: (residual_with_given_times(unknowns, REFERENCE), _scipy_jacobian(unknowns)),
        ],
        _ROUNDS,
    )
    solved, solved_with_scipy = in_turns([lambda: _solve(branch), lambda: _solve_with_scipy(branch)], 1)
    graphs = sum(f.cache_info().currsize for f in (kernel.step, kernel.stage_jacobians, kernel.event))
    return [
        Result(
            "SciPy DOP853 with finite differences / residual and Jacobian",
            theirs / ours,
            at_least=15.0,
            details={"ours_s": ours, "scipy_s": theirs, "difference": accuracy, "graphs_built": graphs},
        ),
        Result(
            "SciPy / ours, orbits of one branch solved",
            solved_with_scipy / solved,
            at_least=15.0,
            details={"ours_s": solved, "scipy_s": solved_with_scipy, "orbits": _SOLVED},
        ),
        Result(
            "all families, junctions, multipliers, confirmed",
            cold,
            "s",
            at_most=120.0,
            details={"orbits": sum(len(b) for b in diagram.branches), "junctions": len(diagram.junctions)},
        ),
    ]
