"""The protocol between world and guest: frames on two pipes. Nothing is pickled in either direction.

A frame is one byte, its kind, and a body whose size the reader knows or limits before it reads it. The
world sends commands; the guest works on one at a time. While it trains, it sends what its environment
shall do, and the world answers with arrays of known shape.
"""

from __future__ import annotations

import json
import math
import os
import struct
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

COMMAND, STEPPED, RESET_DONE = b"c", b"o", b"i"
"""Of the world: a command, the results of a step, the observations after a reset."""
STARTED, REPLY, ERROR = b"h", b"b", b"e"
"""Of the guest: it runs; the reply to a command, or a text instead."""
FLOAT32, FLOAT64, NO_ACTIONS, RESET, MASKED_RESET = b"f", b"d", b"w", b"r", b"m"
"""Of the guest: actions of either type; a text on what it has instead; a reset of all, or of some."""
ACTION_TYPES: dict[bytes, np.dtype[Any]] = {FLOAT32: np.dtype("<f4"), FLOAT64: np.dtype("<f8")}
MAX_TEXT = 64 * 1024
"""Most bytes of the JSON of a message. A message is JSON and bytes, after the lengths of both."""
ARRAY_TYPES = {name: np.dtype(name) for name in ("<f4", "<f8", "|u1", "|b1", "|i1", "<i4", "<i8")}
"""The types of arrays, and nothing with objects in it."""
CHUNK, LENGTHS = 2**16, struct.Struct("<IQ")


class ProtocolError(Exception):
    """The other end sent something that no frame allows."""


class Pipe:
    """One end of the two pipes. Where they do not block, ``wait`` is called until they are ready.

    Reading raises ``EOFError`` when the other end is closed.
    """

    def __init__(
        self, reader: int, writer: int, wait: Callable[[bool], object] = lambda writing: None
    ) -> None:
        self.reader, self.writer, self.wait = reader, writer, wait
        self._ahead = bytearray()  # read, and not yet asked for

    def read(self, size: int) -> bytearray:
        """Exactly ``size`` bytes."""
        while len(self._ahead) < size:
            try:
                new = os.read(self.reader, max(CHUNK, size - len(self._ahead)))
            except BlockingIOError:
                self.wait(False)
                continue
            if not new:
                raise EOFError
            self._ahead += new
        data = self._ahead[:size]
        del self._ahead[:size]
        return data

    def write(self, *parts: bytes | bytearray | memoryview) -> None:
        """All parts, one after another."""
        left = memoryview(b"".join(parts))
        while left:
            try:
                left = left[os.write(self.writer, left) :]
            except BlockingIOError:
                self.wait(True)
            except BrokenPipeError as error:
                raise EOFError from error

    def read_kind(self) -> bytes:
        return bytes(self.read(1))

    def read_message(self, limit: int) -> tuple[Any, bytearray]:
        """JSON and bytes; raises ``ProtocolError`` if they are too long or no JSON."""
        length, size = LENGTHS.unpack(self.read(LENGTHS.size))
        if length > MAX_TEXT or size > limit:
            raise ProtocolError(f"a reply of {length + size:,} bytes; the limit is {limit:,}")
        text = self.read(length)
        try:
            value = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise ProtocolError("a reply that is not JSON") from error
        return value, self.read(size)

    def write_message(self, kind: bytes, value: Any, blob: bytes = b"") -> None:
        text = json.dumps(value, default=lambda number: number.item()).encode()
        self.write(kind, LENGTHS.pack(len(text), len(blob)), text, blob)


def packed(arrays: Mapping[str, Array]) -> tuple[list[tuple[str, str, list[int]]], bytes]:
    """Arrays as JSON, which has the name, type and shape of each, and their bytes."""
    values = {
        name: np.ascontiguousarray(array, array.dtype.newbyteorder("<")) for name, array in arrays.items()
    }
    shapes = [(name, array.dtype.str, list(arrays[name].shape)) for name, array in values.items()]
    return shapes, b"".join(array.tobytes() for array in values.values())


def unpacked(shapes: Any, blob: bytearray) -> dict[str, Array]:
    """The arrays of :func:`packed`. Raises ``ProtocolError`` unless they fill the bytes exactly."""
    arrays, start = dict[str, Array](), 0
    try:
        for name, type_name, shape in shapes:
            dtype = ARRAY_TYPES[type_name]
            if len(shape) > 8 or any(type(size) is not int or size < 0 for size in shape):
                raise ProtocolError("an array with a strange shape")
            end = start + math.prod(shape) * dtype.itemsize
            if end > len(blob) or not isinstance(name, str):
                raise ProtocolError("arrays that do not fit their bytes")
            arrays[name] = np.frombuffer(blob[start:end], dtype).reshape(shape)
            start = end
    except (TypeError, ValueError, KeyError) as error:
        raise ProtocolError("arrays that cannot be read") from error
    if start != len(blob):
        raise ProtocolError("arrays that do not fit their bytes")
    return arrays
