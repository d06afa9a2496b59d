"""A golden trace: a few control steps from raw readings to targets, kept in the policy file and checked at load.

Names and sizes do not tell whether a program feeds a network as its training did: offsets in another order of the legs
cost a third of the accuracy and raise no error. So the file holds readings with the observation, the action and the
targets that followed from them. Whoever ports the observation to another program runs the same readings and compares.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symdyn.errors import FileProblem, PolicyMismatch
from symdyn.gait.library import Gait
from symdyn.policy.driver import PolicyDriver
from symdyn.policy.file import Policy
from symdyn.policy.layout import Layout
from symdyn.policy.observation import Sensed
from symdyn.robot.legs import JOINTS, LEGS

OBSERVATION_TOLERANCE = 1e-6
"""Largest difference of a number of the observation: both sides compute in double precision."""

ACTION_TOLERANCE = 1e-3
"""Largest difference of an action: the network computes in single precision, in another order on other processors."""

_STEPS = 8
_PHASE = 0.3
_RESULTS = {"observation": OBSERVATION_TOLERANCE, "action": ACTION_TOLERANCE, "targets": ACTION_TOLERANCE}


def record(policy: Policy) -> str:
    """The golden trace of a policy as JSON.

    Gait and velocity change from step to step, forwards and backwards; every action becomes ``last_action`` of the next
    step, and the clock turns on by one control step.
    """
    rng = np.random.default_rng(0)
    driver, meta = PolicyDriver(policy, (_PHASE,)), policy.metadata
    low, high = meta.command_range["velocity_x"]
    gaits, steps = list(meta.gaits.values()), []
    for k in range(_STEPS):
        gravity = np.array([0.0, 0.0, -1.0]) + 0.2 * rng.standard_normal(3)
        step: dict[str, Any] = {
            "gravity_b": (gravity / np.linalg.norm(gravity)).tolist(),
            "joint_pos": (np.array(meta.default_joint_pos) + 0.2 * rng.standard_normal(len(JOINTS))).tolist(),
            "joint_vel": rng.standard_normal(len(JOINTS)).tolist(),
            "angular_velocity_b": rng.standard_normal(3).tolist(),
            "offsets": gaits[k % len(gaits)].by_leg(),
            "velocity": [float(np.linspace(high, low, _STEPS)[k]), 0.1 * k, -0.1 * k],
        }
        step |= {name: value.tolist() for name, value in _step(driver, step).items()}
        steps.append(step)
    units = {
        "gravity_b": "unit vector, body frame", "joint_pos": "rad", "joint_vel": "rad/s", "velocity": "m/s, m/s, rad/s",
        "angular_velocity_b": "rad/s, body frame", "offsets": "strides", "observation": "scaled", "targets": "rad",
    }  # fmt: skip
    return json.dumps({"initial_phase": _PHASE, "units": units, "steps": steps}, allow_nan=False)


def check(policy: Policy, text: str, origin: object) -> None:
    """Check that this program does with a policy what the one did that made the file.

    Args:
        policy: of the file.
        text: the golden trace.
        origin: what to call the file in an error.

    Raises:
        FileProblem: if the trace is no golden trace.
        PolicyMismatch: if a number comes out otherwise; it names the number.
    """
    try:
        data = json.loads(text)
        driver, steps = PolicyDriver(policy, (float(data["initial_phase"]),)), list(data["steps"])
        for k, step in enumerate(steps):
            found = _step(driver, step)
            for name, tolerance in _RESULTS.items():
                _compare(policy, k, name, found[name], np.array(step[name], dtype=np.float64), tolerance, origin)
            driver.action = np.array([step["action"]], dtype=np.float64)
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        raise FileProblem(origin, f"contains a golden trace that cannot be read ({error!r}).") from error
    if not steps:
        raise FileProblem(origin, "contains a golden trace without any steps.")


def _step(driver: PolicyDriver, step: dict[str, Any]) -> dict[str, NDArray[np.float64]]:
    """One control step: observation, action and targets."""
    lh, lf, rf, rh = (step["offsets"][leg] for leg in LEGS)
    driver.offsets = Gait("golden", (lh, lf, rf, rh)).theta[None]
    driver.velocity = np.array([step["velocity"]], dtype=np.float64)
    names = ("gravity_b", "joint_pos", "joint_vel", "angular_velocity_b")
    sensed = Sensed(**{name: np.array([step[name]], dtype=np.float64) for name in names})
    observation = np.asarray(driver.observe(sensed))[0]
    targets = driver.act(sensed)[0]
    found = {"observation": observation, "action": driver.action[0], "targets": targets}
    driver.advance(driver.policy.metadata.control_dt)
    return found


def _compare(
    policy: Policy,
    step: int,
    name: str,
    found: NDArray[np.float64],
    wanted: NDArray[np.float64],
    tolerance: float,
    origin: object,
) -> None:
    if wanted.shape != found.shape:
        raise PolicyMismatch(
            f"{origin}: its golden trace has {len(wanted)} numbers of {name}, but this version of symdyn "
            f"computes {len(found)}."
        )
    worst = int(np.argmax(np.abs(found - wanted)))
    if not abs(found[worst] - wanted[worst]) <= tolerance:
        what = _label(policy.metadata.observation, worst) if name == "observation" else JOINTS[worst]
        raise PolicyMismatch(
            f"{origin}: this version of symdyn computes other values than the one that exported it. In step {step} "
            f"of the file's golden trace, {name} number {worst} ({what}) is {found[worst]:.6g}, but must be "
            f"{wanted[worst]:.6g}."
        )


def _label(layout: Layout, number: int) -> str:
    for term in layout.terms:
        where = layout.slices[term.name]
        if where.start <= number < where.stop:
            return f"{term.name} {term.labels[number - where.start]}"
    return "unknown"
