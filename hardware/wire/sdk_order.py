"""The order of legs and joints on the wire: Unitree's SDK's, no signs flipped."""

from __future__ import annotations

from symdyn.robot.legs import JOINTS, LEG_JOINTS, LEGS, permutation

UNITREE_LEGS = {"LH": "RL", "LF": "FL", "RF": "FR", "RH": "RR"}
"""Unitree's leg names (R and F first for rear and front) by the paper's."""

SDK_LEGS = ("FR", "FL", "RR", "RL")
"""Legs in the order of the wire (unitree_sdk2, unitree_go motor order)."""

SDK_JOINTS = tuple(f"{leg}_{joint}_joint" for leg in SDK_LEGS for joint in LEG_JOINTS)
"""Joints in the order of the wire, by their names in Unitree's URDF."""


def unitree_joint_name(joint: str) -> str:
    """Unitree's name of a joint of :data:`symdyn.robot.legs.JOINTS`: ``LH_hip`` is ``RL_hip_joint``."""
    leg, _, kind = joint.partition("_")
    return f"{UNITREE_LEGS[leg]}_{kind}_joint"


_OUR_JOINTS = tuple(unitree_joint_name(joint) for joint in JOINTS)
_OUR_LEGS = tuple(UNITREE_LEGS[leg] for leg in LEGS)

JOINTS_FROM_SDK = permutation(SDK_JOINTS, _OUR_JOINTS)
"""``array[list(JOINTS_FROM_SDK)]`` is in the order of symdyn.robot.legs.JOINTS if ``array`` is in that of the wire."""

JOINTS_TO_SDK = permutation(_OUR_JOINTS, SDK_JOINTS)
"""The inverse."""

LEGS_FROM_SDK = permutation(SDK_LEGS, _OUR_LEGS)
"""``array[list(LEGS_FROM_SDK)]`` is in the order of symdyn.robot.legs.LEGS if ``array`` is in that of the wire."""

LEGS_TO_SDK = permutation(_OUR_LEGS, SDK_LEGS)
"""The inverse."""
