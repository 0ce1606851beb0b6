"""The protocol between world and guest: frames on two pipes. Nothing is pickled in either direction.

A frame is one byte, its kind, and a body whose size the reader knows or limits before it reads it. The
world sends commands; the guest works on one at a time. While it trains, it sends what its environment
shall do, and the world answers with arrays of known shape.
"""

import json
import math
import os
import struct
from collections.abc import Callable, Mapping
from typing import Annotated, Any, Literal

import msgspec
import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

Array = NDArray[Any]

COMMAND, STEPPED, RESET_DONE = b"c", b"o", b"i"
"""Of the world: a command, the results of a step, the observations after a reset."""
STARTED, REPLY, ERROR = b"h", b"b", b"e"
"""Of the guest: it runs; the reply to a command, or a text instead."""
FLOAT32, FLOAT64, RESET = b"f", b"d", b"r"
"""Of the guest: actions of either type; which environments are reset, where none means all."""
ACTION_TYPES: dict[bytes, np.dtype[Any]] = {FLOAT32: np.dtype("<f4"), FLOAT64: np.dtype("<f8")}
MAX_TEXT = 64 * 1024
"""Most bytes of the JSON of a message. A message is JSON and bytes, after the lengths of both."""
ArrayType = Literal["<f4", "<f8", "|u1", "|b1", "|i1", "<i4", "<i8"]
"""The types of arrays, and nothing with objects in it."""
Shape = Annotated[tuple[Annotated[int, Meta(ge=0)], ...], Meta(max_length=8)]
Shapes = list[tuple[str, ArrayType, Shape]]
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

    def read_array(self, shape: tuple[int, ...], dtype: Any) -> Array:
        return np.frombuffer(self.read(math.prod(shape) * np.dtype(dtype).itemsize), dtype).reshape(shape)

    def read_message(self, limit: int) -> tuple[Any, bytearray]:
        """JSON and bytes; raises ``ProtocolError`` if they are too long or no JSON."""
        length, size = LENGTHS.unpack(self.read(LENGTHS.size))
        for sent, most, what in ((length, MAX_TEXT, "a text"), (size, limit, "a reply")):
            if sent > most:
                raise ProtocolError(f"{what} of {sent:,} bytes; the limit is {most:,}")
        try:
            value = json.loads(self.read(length))
        except (ValueError, RecursionError) as error:
            raise ProtocolError("a reply that is not JSON") from error
        return value, self.read(size)

    def write_message(self, kind: bytes, value: Any, blob: bytes = b"") -> None:
        text = json.dumps(value, default=lambda value: value.tolist()).encode()
        self.write(kind, LENGTHS.pack(len(text), len(blob)), text, blob)


def packed(arrays: Mapping[str, Array]) -> tuple[list[tuple[str, str, tuple[int, ...]]], bytes]:
    """Arrays as JSON, which has the name, type and shape of each, and their bytes."""
    little = {name: array.astype(array.dtype.newbyteorder("<"), copy=False) for name, array in arrays.items()}
    shapes = [(name, array.dtype.str, array.shape) for name, array in little.items()]
    return shapes, b"".join(array.tobytes() for array in little.values())


def unpacked(shapes: Any, blob: bytearray) -> dict[str, Array]:
    """The arrays of :func:`packed`. Raises ``ProtocolError`` unless they fill the bytes exactly."""
    arrays, end = dict[str, Array](), 0
    try:
        for name, kind, shape in msgspec.convert(shapes, Shapes):
            start, end = end, end + math.prod(shape) * np.dtype(kind).itemsize
            if end > len(blob):
                break
            arrays[name] = np.frombuffer(blob[start:end], kind).reshape(shape)
    except ValueError as error:
        raise ProtocolError("arrays that cannot be read") from error
    if end != len(blob):
        raise ProtocolError("arrays that do not fit their bytes")
    return arrays
