"""Writes arrays of numbers as .npz files, and reads them from untrusted sources.

Refuses pickles and checks sizes before reading.

``numpy.load`` trusts the shape in a header and allocates accordingly. Here a header must agree with the size
of its member, and the data is read as bytes.
"""

from __future__ import annotations

import functools
import io
import math
import tokenize
import warnings
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from gym_extensions.rollouts.layout import MAX_ARRAYS, MAX_UNPACKED_BYTES

MAX_HEADER_BYTES = 4096
MAX_DIMENSIONS = 32
MAX_LENGTH = 2**48
NUMERIC = frozenset(("b1", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "f2", "f4", "f8", "c8", "c16"))
"""Data types of numbers, as in ``dtype.str`` without the byte order."""
ENCRYPTED = 1
HEADER_READERS = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}
"""By version of the .npy format. Version 3.0 is for structured arrays, which are refused."""
ERRORS = (
    zipfile.BadZipFile,
    zlib.error,
    tokenize.TokenError,
    ValueError,
    TypeError,
    LookupError,
    SyntaxError,
    OverflowError,
    OSError,
    EOFError,
    MemoryError,
    RuntimeError,
    Warning,
)
"""Exceptions that zipfile, zlib and numpy raise for malformed bytes."""


@dataclass(frozen=True)
class Header:
    """The header of a .npy file. ``start`` is the offset of the data in bytes."""

    dtype: np.dtype[Any]
    shape: tuple[int, ...]
    fortran_order: bool
    start: int

    @property
    def size(self) -> int:
        """Size in bytes that the .npy file must have."""
        return self.start + math.prod(self.shape) * self.dtype.itemsize


@dataclass(frozen=True)
class Member:
    """A member of an archive, with its uncompressed size, and whether numpy packs this way.

    ``header`` is None if it is malformed.
    """

    name: str
    size: int
    is_plain: bool
    header: Header | None

    @property
    def is_valid(self) -> bool:
        """Whether it is an array of numbers of the size that its header states."""
        header = self.header
        return header is not None and not header.dtype.hasobject and header.size == self.size


@functools.lru_cache(maxsize=1024)
def _read_header(header: bytes) -> Header | None:
    """The header of a .npy file, or None unless its data are numbers or Python objects."""
    stream = io.BytesIO(header)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # numpy warns of headers that it has to repair
        try:
            read_header = HEADER_READERS[npy.read_magic(stream)]
            shape, fortran_order, dtype = read_header(stream, max_header_size=MAX_HEADER_BYTES)
        except ERRORS:
            return None
    is_bounded = len(shape) <= MAX_DIMENSIONS and all(0 <= length < MAX_LENGTH for length in shape)
    if not is_bounded or not (dtype.hasobject or dtype.str[1:] in NUMERIC):
        return None
    return Header(dtype, shape, fortran_order, stream.tell())


def _is_plain(info: zipfile.ZipInfo) -> bool:
    """Whether numpy packs this way."""
    return info.compress_type in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED) and not info.flag_bits & ENCRYPTED


def _header(start: bytes) -> Header | None:
    """The header of a .npy file that begins with these bytes."""
    return _read_header(start[: start.find(b"\n", npy.MAGIC_LEN + 2, MAX_HEADER_BYTES) + 1])


def _member(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> Member:
    is_plain, header = _is_plain(info), None
    if is_plain:
        try:
            with archive.open(info) as stream:
                header = _header(stream.read(MAX_HEADER_BYTES))
        except ERRORS:
            header = None
    return Member(info.filename, info.file_size, is_plain, header)


def members(data: bytes) -> tuple[list[Member], int] | None:
    """The first ``MAX_ARRAYS`` members of a zip archive and the number of all, or None if it is malformed."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            infos = archive.infolist()
            return [_member(archive, info) for info in infos[:MAX_ARRAYS]], len(infos)
    except ERRORS:
        return None


def bounded(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> bytes:
    """The content of a member, of which no more is unpacked than the size that the archive states.

    ``ZipFile.read`` unpacks everything first, and cuts it to that size.
    """
    with archive.open(info) as stream:
        return stream.read(info.file_size)


def read(data: bytes, max_bytes: int = MAX_UNPACKED_BYTES) -> dict[str, NDArray[Any]] | None:
    """The arrays of an .npz file by name, or None unless all are arrays of numbers within the limits.

    Args:
        data: the content of the file.
        max_bytes: the largest uncompressed size.
    """
    arrays = {}
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            infos = archive.infolist()
            if len(infos) > MAX_ARRAYS or sum(info.file_size for info in infos) > max_bytes:
                return None
            for info in infos:
                is_plain = _is_plain(info)
                content = bounded(archive, info) if is_plain else b""
                member = Member(info.filename, info.file_size, is_plain, _header(content))
                if not member.is_valid or (header := member.header) is None:
                    return None
                values = np.frombuffer(content, header.dtype, offset=header.start)
                array = values.reshape(header.shape, order="F" if header.fortran_order else "C")
                arrays[member.name.removesuffix(".npy")] = array
    except ERRORS:
        return None
    return arrays


def npz_bytes(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """The content of the .npz file. Equal arrays give equal bytes (numpy dates every member 1980-01-01)."""
    content = io.BytesIO()
    np.savez_compressed(content, allow_pickle=False, **arrays)
    return content.getvalue()
