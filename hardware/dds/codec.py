"""Bytes of the two messages that pass 500 times a second, as numpy structures.

On DDS a message is CDR (OMG, DDS-RTPS 9.6 and DDSI): fields one after another, each at a multiple of its own size. The
robot's checksum is over the C structure of the same fields, in which a nested structure starts at a multiple of its
largest field's size. So a message is held as its C structure, a numpy record, and an index says which byte of the CDR
is which byte of that. Through cyclonedds' own classes the same takes a hundred times as long.
"""

from __future__ import annotations

import struct
import zlib
from typing import Any, get_type_hints

import numpy as np
from cyclonedds.idl import IdlStruct

from symdyn.errors import SymdynError

HEADER = b"\x00\x01\x00\x00"
"""Before every CDR message: plain CDR, little-endian."""

_SCALARS = {
    "byte": "u1", "int16": "<i2", "uint16": "<u2", "int32": "<i4", "uint32": "<u4", "int64": "<i8", "float32": "<f4",
}  # fmt: skip
_CRC = "crc"
_WORD = 4
_REVERSED = bytes(int(f"{byte:08b}"[::-1], 2) for byte in range(256))


class BadMessage(SymdynError):
    """Bytes that are no message of their topic's type."""


class Codec:
    """Of one type whose length is fixed and whose last field is ``crc``.

    Args:
        kind: the type.

    Attributes:
        dtype: of the C structure.
        size: of a message on the wire with its header, bytes.
    """

    def __init__(self, kind: type[IdlStruct]) -> None:
        self.dtype = _structure(kind)
        order, end = _cdr_places(self.dtype, 0)
        assert self.dtype.names is not None and self.dtype.names[-1] == _CRC and self.dtype.itemsize % _WORD == 0
        places = np.fromiter((at for at, _ in order), np.intp)
        # padding of the structure is read from a zero that follows the message
        self._to_structure = np.full(self.dtype.itemsize, end)
        self._to_structure[places] = np.fromiter((at for _, at in order), np.intp)
        self._to_cdr = np.full(end, self.dtype.itemsize)
        self._to_cdr[self._to_structure[places]] = places
        self.size = len(HEADER) + end

    def new(self) -> Any:
        """A message of zeros, a record of :attr:`dtype`."""
        return np.zeros((), self.dtype)

    def decode(self, data: bytes) -> Any:
        """The record that bytes hold. Raises BadMessage."""
        if len(data) != self.size:
            raise BadMessage(f"A message has {len(data)} bytes, not {self.size}.")
        if data[:2] != HEADER[:2]:
            raise BadMessage(f"A message begins with {data[:4].hex()}: it is not plain little-endian CDR.")
        cdr = np.frombuffer(data[len(HEADER) :] + b"\0", np.uint8)
        return cdr[self._to_structure].view(self.dtype)[0]

    def encode(self, record: Any) -> bytes:
        """The bytes of a record, as they go over the wire; its checksum is put in."""
        fields = record.tobytes()[:-_WORD]
        structure = np.frombuffer(fields + struct.pack("<I", crc32(fields)) + b"\0", np.uint8)
        return HEADER + structure[self._to_cdr].tobytes()

    def crc_fits(self, record: Any) -> bool:
        """Whether the checksum of a record is that of its bytes."""
        return crc32(record.tobytes()[:-_WORD]) == int(record[_CRC])


def crc32(structure: bytes) -> int:
    """The robot's checksum of a structure's bytes without the checksum's own.

    Words are read as little-endian numbers and put through the polynomial 0x04c11db7 with their highest bit first, from
    0xffffffff, without inversion at the end (unitree_sdk2, crc32_core). zlib's has the same polynomial with the lowest
    bit first and inverts at the end, so the bits of every word are turned round before and those of the sum after.
    """
    turned = np.frombuffer(structure, "<u4").astype(">u4").tobytes().translate(_REVERSED)
    inverted = ~zlib.crc32(turned) & 0xFFFFFFFF
    return int.from_bytes(inverted.to_bytes(_WORD, "little").translate(_REVERSED), "big")


def _structure(kind: type[IdlStruct]) -> np.dtype[Any]:
    hints = get_type_hints(kind, include_extras=True)
    return np.dtype([(name, *_field(hint)) for name, hint in hints.items() if not name.startswith("_")], align=True)


def _field(hint: Any) -> tuple[Any, ...]:
    if isinstance(hint, type):
        return (_structure(hint),)
    (extra,) = hint.__metadata__
    if isinstance(extra, str):
        return (_SCALARS[extra],)
    return (*_field(extra.subtype), (extra.length,))


def _cdr_places(dtype: np.dtype[Any], start: int, at: int = 0) -> tuple[list[tuple[int, int]], int]:
    """Pairs (byte of the structure, byte of the CDR) of a type that lies at byte ``start`` of the structure, where the
    CDR has ``at`` bytes before it; and how many it has after."""
    pairs: list[tuple[int, int]] = []
    if dtype.names is not None and dtype.fields is not None:
        for kind, offset, *_ in dtype.fields.values():
            its, at = _cdr_places(kind, start + offset, at)
            pairs += its
        return pairs, at
    if dtype.subdtype is not None:
        element, (length,) = dtype.subdtype
        for number in range(length):
            its, at = _cdr_places(element, start + number * element.itemsize, at)
            pairs += its
        return pairs, at
    at += -at % dtype.itemsize
    return [(start + byte, at + byte) for byte in range(dtype.itemsize)], at + dtype.itemsize
