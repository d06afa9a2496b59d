"""What a policy sees: named terms, the layouts made of them, and the one function that assembles them.

Trainer, evaluation, viewer and robot call :func:`observe`; on tensors and on numpy arrays alike. A configuration names
a layout of :data:`LAYOUTS`; a policy file carries its own, term by term (:func:`read_layout`).

A new term is an entry of :data:`TERMS` and one of :data:`VALUES`.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, Literal

import numpy as np
from array_api_compat import array_namespace

from symdyn.arrays import Array
from symdyn.errors import PolicyMismatch, UnknownName
from symdyn.policy.layout import Layout, Term
from symdyn.robot.legs import JOINTS, LEGS

_XYZ = ("x", "y", "z")

TERMS: Mapping[str, Term] = {
    term.name: term
    for term in (
        # noise: Table III of the paper
        Term("projected_gravity_b", _XYZ, "1", 1.0, 0.05, "polar_b", "unit vector of gravity in the body frame"),
        Term("joint_pos_rel", JOINTS, "rad", 1.0, 0.01, "joint", "joint positions minus the default pose"),
        Term("joint_vel", JOINTS, "rad/s", 0.05, 1.5, "joint", "joint velocities"),
        Term("last_action", JOINTS, "1", 1.0, 0.0, "joint", "the action of the step before, as the policy gave it"),
        Term(
            "velocity_command", ("v_x", "v_y", "yaw_rate"), "m/s, m/s, rad/s", 1.0, 0.0, "planar_velocity_b",
            "commanded forward, lateral and yaw velocity",
        ),
        Term("clock_sin", LEGS, "1", 1.0, 0.0, "leg", "sin(2 pi phi_i) of each leg"),
        Term("phase_offset", ("LF", "RF", "LH", "RH"), "stride", 1.0, 0.0, "leg", "offsets theta_i of the gait"),
        Term("duty_ratio", ("beta", "1-beta"), "1", 1.0, 0.0, "invariant", "duty factor and its complement"),
        Term("clock_cos", LEGS, "1", 1.0, 0.0, "leg", "cos(2 pi phi_i) of each leg"),
        # scale and noise as in legged_gym (Rudin et al. 2022)
        Term("base_ang_vel_b", _XYZ, "rad/s", 0.25, 0.2, "axial_b", "angular velocity of the trunk: the gyroscope"),
    )
}  # fmt: skip
"""Every term that a driver can supply, by name."""


@dataclass(frozen=True)
class Sensed:
    """What the sensors of n robots say. The fields are the names of sensors in :data:`NEEDS`.

    Attributes:
        gravity_b: (n, 3) unit vector of gravity in the body frame.
        joint_pos: (n, 12) rad.
        joint_vel: (n, 12) rad/s.
        angular_velocity_b: (n, 3) rad/s, the gyroscope; None for a driver without one.
        heading: (n,) yaw of the trunk, rad, from any origin; None for a driver without one. No policy observes it:
            heading hold goes by it (symdyn.policy.steering).
    """

    gravity_b: Array
    joint_pos: Array
    joint_vel: Array
    angular_velocity_b: Array | None = None
    heading: Array | None = None


SENSORS: tuple[str, ...] = tuple(field.name for field in fields(Sensed))
"""Every sensor that a driver can have."""


@dataclass(frozen=True)
class Situation:
    """All that an observation of n robots can be made of.

    Attributes:
        sensed: by the sensors.
        default_joint_pos: (12,) rad.
        last_action: (n, 12).
        offsets: (n, 4) of the commanded gaits, in the order of LEGS.
        velocity: (n, 3) commanded v_x, v_y (m/s) and yaw rate (rad/s).
        leg_phases: (n, 4).
        duty: (n,) commanded duty factor.
    """

    sensed: Sensed
    default_joint_pos: Array
    last_action: Array
    offsets: Array
    velocity: Array
    leg_phases: Array
    duty: Array


_OFFSET_ORDER = [LEGS.index(leg) for leg in TERMS["phase_offset"].labels]


def _clock(s: Situation, function: Literal["sin", "cos"]) -> Array:
    return getattr(array_namespace(s.leg_phases), function)(2.0 * np.pi * s.leg_phases)


VALUES: Mapping[str, Callable[[Situation], Array]] = {
    "projected_gravity_b": lambda s: s.sensed.gravity_b,
    "joint_pos_rel": lambda s: s.sensed.joint_pos - s.default_joint_pos,
    "joint_vel": lambda s: s.sensed.joint_vel,
    "last_action": lambda s: s.last_action,
    "velocity_command": lambda s: s.velocity,
    "clock_sin": lambda s: _clock(s, "sin"),
    "phase_offset": lambda s: s.offsets[..., _OFFSET_ORDER],
    "duty_ratio": lambda s: array_namespace(s.duty).stack([s.duty, 1.0 - s.duty], axis=-1),
    "clock_cos": lambda s: _clock(s, "cos"),
    "base_ang_vel_b": lambda s: s.sensed.angular_velocity_b,
}
"""How each term follows from a situation, unscaled, in the order of its labels."""

NEEDS: Mapping[str, str] = {
    "projected_gravity_b": "gravity_b",
    "joint_pos_rel": "joint_pos",
    "joint_vel": "joint_vel",
    "base_ang_vel_b": "angular_velocity_b",
}
"""The sensor that a term needs; the other terms need none."""


def _layout(names: Iterable[str]) -> Layout:
    return Layout(tuple(TERMS[name] for name in names))


_PAPER = (
    "projected_gravity_b", "joint_pos_rel", "joint_vel", "last_action", "velocity_command", "clock_sin", "phase_offset",
    "duty_ratio",
)  # fmt: skip

LAYOUTS: Mapping[str, Layout] = {
    "paper": _layout(_PAPER),
    "extended": _layout((*_PAPER, "clock_cos", "base_ang_vel_b")),
}
"""``paper``: the 52 numbers of the paper, section III-C. ``extended``: these, the cosine of the clock (whose sine alone
does not tell early from late), and the gyroscope (without which a yaw command is hardly learned): 59 numbers."""


def get_layout(name: str) -> Layout:
    """The layout of that name. Raises UnknownName."""
    try:
        return LAYOUTS[name]
    except KeyError:
        raise UnknownName("observation", name, LAYOUTS) from None


def read_layout(table: Iterable[Mapping[str, Any]], origin: object) -> Layout:
    """The layout that a policy file carries.

    Args:
        table: of :meth:`symdyn.policy.layout.Layout.as_list`: name, size and scale of each term, and labels but for
            older files. The scales are the file's, whatever :data:`TERMS` says.
        origin: what to call the file in an error.

    Raises:
        PolicyMismatch: if a term is unknown, of another size or order, or stands twice.
    """
    found: dict[str, Term] = {}
    for entry in table:
        name, size = entry["name"], entry["size"]
        if name not in TERMS:
            raise PolicyMismatch(
                f"{origin}: observes {name!r}, which this version of symdyn cannot supply. "
                f"It can supply {', '.join(TERMS)}."
            )
        if size != TERMS[name].size:
            raise PolicyMismatch(
                f"{origin}: observes {name!r} with {size} numbers, but this version of symdyn "
                f"supplies {TERMS[name].size}."
            )
        labels = tuple(entry.get("labels", TERMS[name].labels))
        if labels != TERMS[name].labels:
            raise PolicyMismatch(
                f"{origin}: observes {name!r} in the order {' '.join(map(str, labels))}, but this version of symdyn "
                f"supplies {' '.join(TERMS[name].labels)}."
            )
        if name in found:
            raise PolicyMismatch(f"{origin}: observes {name!r} twice.")
        found[name] = replace(TERMS[name], scale=entry["scale"])
    return Layout(tuple(found.values()))


def check_supplied(layout: Layout, sensors: Collection[str], driver: str) -> None:
    """Check that a driver has the sensors that a policy's observation needs.

    Args:
        layout: of the policy.
        sensors: that the driver has, of :data:`SENSORS`.
        driver: what to call it in an error.

    Raises:
        PolicyMismatch: naming the terms that cannot be supplied.
    """
    lacking = [name for name in layout.names if name in NEEDS and NEEDS[name] not in sensors]
    if lacking:
        raise PolicyMismatch(
            f"{driver} cannot supply {', '.join(lacking)}, which the policy observes: it has no "
            f"{', '.join(dict.fromkeys(NEEDS[name] for name in lacking))}."
        )


def observe(layout: Layout, situation: Situation) -> Array:
    """The observation vector of n robots, (n, size of the layout), scaled, without noise."""
    return layout.assemble({name: VALUES[name](situation) for name in layout.names})
