"""What is announced on the wire is what the robot announces: a peer on another type sends nothing, or crashes."""

from __future__ import annotations

import hashlib

import pytest

from hardware.dds.types import LowCmd, LowState, Request, Response
from tests.hardware.dds.sdk_values import SDK_TYPE_INFORMATION_SHA256


@pytest.mark.parametrize("kind", [LowState, LowCmd, Request, Response])
def test_type_information_is_that_of_unitrees_sdk(kind):
    kind.__idl__.fill_type_data()
    information, _ = kind.__idl__._xt_bytedata
    its = hashlib.sha256(information).hexdigest()
    assert its == SDK_TYPE_INFORMATION_SHA256[kind.__idl__.idl_transformed_typename]
