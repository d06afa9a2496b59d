"""Names and orders, against the URDF's own names and against what a permutation is."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hardware.wire.sdk_order import unitree_joint_name
from symdyn.errors import SymdynError
from symdyn.robot.legs import JOINTS, LEG_JOINTS, LEGS, is_front, is_left, permutation


def test_orders_are_the_papers() -> None:
    assert LEGS == ("LH", "LF", "RF", "RH")
    assert JOINTS[:4] == ("LH_hip", "LH_thigh", "LH_calf", "LF_hip")
    assert len(JOINTS) == 12
    # so that q.reshape(4, 3) is a row a leg
    assert np.array(JOINTS).reshape(len(LEGS), len(LEG_JOINTS))[2, 1] == "RF_thigh"


@pytest.mark.parametrize(("leg", "left", "front"), [("LH", 1, 0), ("LF", 1, 1), ("RF", 0, 1), ("RH", 0, 0)])
def test_sides_and_ends(leg: str, left: int, front: int) -> None:
    assert is_left(leg) == bool(left)
    assert is_front(leg) == bool(front)


@pytest.mark.parametrize(
    ("joint", "unitree"),
    [
        ("LH_hip", "RL_hip_joint"),
        ("LF_thigh", "FL_thigh_joint"),
        ("RF_calf", "FR_calf_joint"),
        ("RH_hip", "RR_hip_joint"),
    ],
)
def test_unitree_calls_hind_rear_and_puts_it_first(joint: str, unitree: str) -> None:
    assert unitree_joint_name(joint) == unitree


def test_unitree_names_are_where_the_legs_are() -> None:
    # x forward, y left in the URDF: the hip of LH is behind and to the left
    import pinocchio

    from symdyn.robot.descriptions import urdf_path
    from tests.robots import GO2

    model = pinocchio.buildModelFromUrdf(str(urdf_path(GO2)))
    for leg in LEGS:
        x, y, _ = model.jointPlacements[model.getJointId(unitree_joint_name(f"{leg}_hip"))].translation
        assert (x > 0.0) == is_front(leg)
        assert (y > 0.0) == is_left(leg)


@given(st.permutations(JOINTS), st.permutations(JOINTS))
def test_permutation_reorders_by_name(source: list[str], target: list[str]) -> None:
    index = list(permutation(source, target))
    assert [source[i] for i in index] == target
    back = list(permutation(target, source))
    assert np.array_equal(np.arange(12)[index][back], np.arange(12))


def test_permutation_of_an_array() -> None:
    in_sdk_order = np.array([10.0, 20.0, 30.0])
    assert in_sdk_order[list(permutation(("FR", "FL", "RR"), ("RR", "FR", "FL")))].tolist() == [30.0, 10.0, 20.0]


@pytest.mark.parametrize(
    ("source", "target"),
    [
        (("a", "b"), ("a", "c")),
        (("a", "a"), ("a", "a")),
        (("a", "b"), ("a",)),
        (("a",), ("a", "b")),
        (("a", "b"), ("a", "a")),
    ],
)
def test_names_that_do_not_match_are_an_error_that_lists_them(source: tuple[str, ...], target: tuple[str, ...]) -> None:
    with pytest.raises(SymdynError, match="need " + ", ".join(target)):
        permutation(source, target)
