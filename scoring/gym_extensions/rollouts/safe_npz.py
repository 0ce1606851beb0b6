"""An .npz file opened without trust: zipfile finds its members, and a pattern of our own reads their headers.

numpy's reader evaluates a header as Python and believes the shape in it; nothing here does.
"""

from __future__ import annotations

import io
import math
import re
import struct
import zipfile
import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

LARGEST_UNPACKED = 256 * 2**20
MOST_ARRAYS = 256
HEADER_BYTES = 4096
MAGIC = {b"\x93NUMPY\x01\x00": "<H", b"\x93NUMPY\x02\x00": "<I", b"\x93NUMPY\x03\x00": "<I"}
"""How a .npy file begins, and how its header's length follows."""
NUMBERS = re.compile(
    rb"\{'descr': '(?P<descr>[<>|=]?(?:b1|[iu][1248]|f[248]|c8|c16))', "
    rb"'fortran_order': (?P<fortran>True|False), "
    rb"'shape': \((?P<shape>|[0-9]{1,15},|[0-9]{1,15}(?:, [0-9]{1,15}){1,31})\), ?\} *\n"
)
OBJECTS = re.compile(rb"'[<>|=]?O[0-9]?'")
ENCRYPTED = 1
UNREADABLE = (
    zipfile.BadZipFile,
    zlib.error,
    struct.error,
    ValueError,
    TypeError,
    LookupError,
    OverflowError,
    OSError,
    EOFError,
    MemoryError,
    RuntimeError,
)
"""What zipfile and zlib raise for bytes that are not theirs."""


@dataclass(frozen=True)
class Header:
    """What an array's header says: its numbers' type, its shape, where they begin; or that it has objects."""

    objects: bool
    dtype: str = ""
    shape: tuple[int, ...] = ()
    order: str = "C"
    start: int = 0

    @property
    def size(self) -> int:
        """The bytes of the whole .npy file."""
        return self.start + math.prod(self.shape) * np.dtype(self.dtype).itemsize


@dataclass(frozen=True)
class Member:
    """One member: its name, its unpacked bytes, whether numpy packs so, its header if that can be read."""

    name: str
    size: int
    plain: bool
    header: Header | None

    @property
    def sound(self) -> bool:
        """Whether it is an array of numbers and nothing else."""
        header = self.header
        return self.plain and header is not None and not header.objects and header.size == self.size


def _header(start: bytes) -> Header | None:
    length = MAGIC.get(start[:8])
    if length is None or len(start) < 8 + struct.calcsize(length):
        return None
    first = 8 + struct.calcsize(length)
    end = first + struct.unpack(length, start[8:first])[0]
    found = NUMBERS.fullmatch(start[first:end]) if end <= len(start) else None
    if found is None:
        return Header(objects=True) if OBJECTS.search(start[first:end]) else None
    shape = tuple(map(int, re.findall(rb"[0-9]+", found["shape"])))
    return Header(False, found["descr"].decode(), shape, "F" if found["fortran"] == b"True" else "C", end)


def _member(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> Member:
    packed = info.compress_type in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
    plain, header = packed and not info.flag_bits & ENCRYPTED, None
    if plain:
        try:
            with archive.open(info) as stream:
                header = _header(stream.read(HEADER_BYTES))
        except UNREADABLE:
            header = None
    return Member(info.filename, info.file_size, plain, header)


def members(data: bytes) -> tuple[list[Member], int] | None:
    """The first members of an archive and the number of all; None where the bytes are no archive."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            found = archive.infolist()
            return [_member(archive, info) for info in found[:MOST_ARRAYS]], len(found)
    except UNREADABLE:
        return None


def read(data: bytes) -> dict[str, NDArray[Any]] | None:
    """The arrays by name; None where one of them is no array of numbers, or cannot be read."""
    found = members(data)
    if found is None or found[1] > MOST_ARRAYS or not all(one.sound for one in found[0]):
        return None
    if sum(one.size for one in found[0]) > LARGEST_UNPACKED:
        return None
    arrays = {}
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            for one in found[0]:
                header, content = one.header or Header(True), archive.read(one.name)
                flat = np.frombuffer(content, np.dtype(header.dtype), offset=header.start)
                arrays[one.name.removesuffix(".npy")] = flat.reshape(
                    header.shape, order="F" if header.order == "F" else "C"
                )
    except UNREADABLE:
        return None
    return arrays
