"""Messages whose every field has a value of its own, and what Unitree's SDK makes of them.

The checksums and the hashes of the bytes were computed with unitree_sdk2_python (its own classes, its own crc_amd64.so)
on cyclonedds 0.10.2 and Python 3.10. The k-th number of a message, in the order of the fields, is (7 k + 3) mod 127; an
eighth of it where it is a float; the checksum itself is left out.
"""

from __future__ import annotations

from itertools import count
from typing import Any

import numpy as np

from hardware.dds.codec import Codec
from hardware.dds.types import LowCmd, LowState

SDK_CRC = {LowState: 0x4BCFF687, LowCmd: 0x7B3D7425}

SDK_BYTES_SHA256 = {
    LowState: "4282c32abbb562ed73f598dae89f9c87a5541d73b451873927986b550d4104c8",
    LowCmd: "bad30f23a92734d9c7559f4e58db5022aee6e427202a5812f5f732f605003bd5",
}

SDK_TYPE_INFORMATION_SHA256 = {
    "unitree_go::msg::dds_::LowState_": "962a30f8f8550b1b6fe327966bb403c8164de74c233828f2d1037a2093f5f237",
    "unitree_go::msg::dds_::LowCmd_": "cc8f6612e08e97b0feb6a7073c411c803b8fb8aba760950220a1eb8030c4230b",
    "unitree_api::msg::dds_::Request_": "d1e419871f71e120b9038e8efbd1c5e0f8c20aa9496155c47353ad6fab45ccae",
    "unitree_api::msg::dds_::Response_": "bee0d8bff3f57731e48122e8532c64b88d84fce7ca983fbdf8d836fb3e91b447",
}
"""Of the serialised type information that cyclonedds 0.10.2 announces for the SDK's own declarations."""


def numbered(codec: Codec) -> Any:
    """The record of a codec with such values."""
    record, number = codec.new(), count(1)
    _fill(record, codec.dtype, number)
    return record


def _fill(record: Any, dtype: np.dtype[Any], number: count[int]) -> None:
    assert dtype.names is not None and dtype.fields is not None
    for name in dtype.names:
        kind = dtype.fields[name][0]
        element = kind.base
        for place in np.ndindex(kind.shape):
            if name == "crc":
                continue
            if element.names is not None:
                _fill(record[name][place] if place else record[name], element, number)
                continue
            k = (7 * next(number) + 3) % 127
            value = k / 8 if element.kind == "f" else k
            if place:
                record[name][place] = value
            else:
                record[name] = value
