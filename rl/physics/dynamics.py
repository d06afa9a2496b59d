"""What each simulated robot and its ground are like, where they differ from the model."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symdyn.robot.legs import JOINTS

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Dynamics:
    """Of N robots. :meth:`nominal` is the model as it is.

    Attributes:
        added_mass: (N,) kg on the trunk, negative for a lighter one.
        mass_pos_b: (N, 3) where that mass sits, m from the trunk's centre of mass, in axes of the trunk.
        com_shift_b: (N, 3) displacement of the trunk's own centre of mass, m.
        friction: (N,) factor on the friction of the floor.
        strength: (N, 12) factor on a motor's torque and on its limit.
        kp: (N, 12) factor on the proportional gain.
        kd: (N, 12) factor on the derivative gain.
        joint_offset: (N, 12) what an encoder shows too much, rad.
        delay: (N,) from the command to the motor's response, s; counted in whole physics steps.
        slope: (N, 2) rise of the floor along x and along y of the world.
    """

    added_mass: Floats
    mass_pos_b: Floats
    com_shift_b: Floats
    friction: Floats
    strength: Floats
    kp: Floats
    kd: Floats
    joint_offset: Floats
    delay: Floats
    slope: Floats

    @classmethod
    def nominal(cls, n: int, **changes: Floats) -> Dynamics:
        """n robots as the model has them, but for what is given."""
        joints = (n, len(JOINTS))
        same = cls(
            added_mass=np.zeros(n),
            mass_pos_b=np.zeros((n, 3)),
            com_shift_b=np.zeros((n, 3)),
            friction=np.ones(n),
            strength=np.ones(joints),
            kp=np.ones(joints),
            kd=np.ones(joints),
            joint_offset=np.zeros(joints),
            delay=np.zeros(n),
            slope=np.zeros((n, 2)),
        )
        return replace(same, **changes)

    def of(self, i: int) -> dict[str, Any]:
        """Those of one robot, as plain numbers."""
        return {item.name: getattr(self, item.name)[i].tolist() for item in fields(self)}
