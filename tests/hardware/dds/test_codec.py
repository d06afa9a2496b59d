"""Bytes and checksums against cyclonedds' own serialiser, Unitree's SDK, and the definition of the polynomial."""

from __future__ import annotations

import hashlib
import random
import struct
from typing import get_type_hints

import numpy as np
import pytest
from cyclonedds.idl import IdlStruct
from hypothesis import given, settings
from hypothesis import strategies as st

from hardware.dds.codec import HEADER, BadMessage, Codec, crc32
from hardware.dds.types import LowCmd, LowState
from tests.hardware.dds.sdk_values import SDK_BYTES_SHA256, SDK_CRC, numbered

CODECS = {kind: Codec(kind) for kind in (LowState, LowCmd)}
BOTH = pytest.mark.parametrize("kind", CODECS)
RANGES = {"byte": (0, 255), "int16": (-(2**15), 2**15 - 1), "uint16": (0, 2**16 - 1), "int32": (-(2**31), 2**31 - 1)}


def drawn(kind: type, rng: random.Random) -> IdlStruct:
    """An object of cyclonedds' with random numbers in every field."""

    def value(hint):
        if isinstance(hint, type):
            return drawn(hint, rng)
        (extra,) = hint.__metadata__
        if isinstance(extra, str):
            if extra == "float32":
                return struct.unpack("<f", struct.pack("<f", rng.uniform(-1e3, 1e3)))[0]
            return rng.randint(*RANGES.get(extra, (0, 2**32 - 1)))
        return [value(extra.subtype) for _ in range(extra.length)]

    return kind(**{name: value(hint) for name, hint in get_type_hints(kind, include_extras=True).items()})


def plain(value):
    """Of a record or an object: nested lists of numbers."""
    if isinstance(value, IdlStruct):
        return [plain(getattr(value, name)) for name in value.__dataclass_fields__]
    if isinstance(value, list | tuple):
        return [plain(one) for one in value]
    if isinstance(value, np.ndarray):
        return [plain(one) for one in value]
    if isinstance(value, np.void):
        return [plain(value[name]) for name in value.dtype.names]
    return value.item() if isinstance(value, np.generic) else value


def bit_by_bit(structure: bytes) -> int:
    """The polynomial division as it is defined, a bit at a time."""
    crc = 0xFFFFFFFF
    for (word,) in struct.iter_unpack("<I", structure):
        for bit in reversed(range(32)):
            out = crc >> 31 ^ word >> bit & 1
            crc = crc << 1 & 0xFFFFFFFF ^ (0x04C11DB7 if out else 0)
    return crc


@BOTH
@settings(max_examples=20)
@given(seed=st.integers(0, 2**32))
def test_bytes_are_those_of_cyclonedds_both_ways(kind, seed):
    codec, message = CODECS[kind], drawn(kind, random.Random(seed))
    data = message.serialize()
    record = codec.decode(data)
    assert plain(record) == plain(message)
    message.crc = crc32(record.tobytes()[:-4])
    assert codec.encode(record) == message.serialize()


@BOTH
def test_bytes_and_checksum_are_those_of_unitrees_sdk(kind):
    codec = CODECS[kind]
    data = codec.encode(numbered(codec))
    assert int(codec.decode(data)["crc"]) == SDK_CRC[kind]
    assert hashlib.sha256(data).hexdigest() == SDK_BYTES_SHA256[kind]


@given(st.binary(min_size=1, max_size=40))
def test_the_checksum_is_the_polynomials(data):
    structure = data * 4
    assert crc32(structure) == bit_by_bit(structure)


@BOTH
@given(place=st.floats(0.0, 1.0, exclude_max=True), bit=st.integers(0, 7))
def test_a_flipped_bit_of_a_field_is_noticed(kind, place, bit):
    codec = CODECS[kind]
    record = codec.decode(codec.encode(numbered(codec)))
    assert codec.crc_fits(record)
    damaged = bytearray(record.tobytes())
    damaged[int(place * len(damaged))] ^= 1 << bit
    assert not codec.crc_fits(np.frombuffer(bytes(damaged), codec.dtype)[0])


@BOTH
def test_a_message_of_another_length_or_coding_is_refused(kind):
    codec = CODECS[kind]
    data = codec.encode(codec.new())
    for wrong in (data[:-4], data + b"\0\0\0\0", b"", HEADER):
        with pytest.raises(BadMessage, match="bytes"):
            codec.decode(wrong)
    with pytest.raises(BadMessage, match="little-endian"):
        codec.decode(b"\x00\x00" + data[2:])
