"""Rules about .npz files: arrays of numbers, in bounds, and never a pickle. Headers are read, data is not."""

from __future__ import annotations

import io
import struct
import zipfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gym_extensions.scoring.checks.files import TRACE
from gym_extensions.scoring.checks.manifest import shown
from gym_extensions.scoring.checks.rule import rule
from gym_extensions.scoring.problems import Finding

LARGEST_UNPACKED = 256 * 2**20
MOST_ARRAYS = 256
HEADER_BYTES = 4096


@dataclass(frozen=True)
class Arrays:
    """The bytes of one .npz file, its path in the submission, the runs of the group's logs by protocol."""

    path: str
    data: bytes
    runs: dict[str, tuple[int, ...]]


UNREADABLE = (
    zipfile.BadZipFile,
    zlib.error,
    struct.error,
    ValueError,
    TypeError,
    KeyError,
    SyntaxError,
    OverflowError,
    OSError,
    EOFError,
    MemoryError,
    RuntimeError,  # an encrypted member; NotImplementedError, an unknown compression, is one of them
)
"""What zipfile, zlib and numpy raise for bytes that are not theirs."""


def _members(arrays: Arrays) -> list[zipfile.ZipInfo]:
    """The members of the archive; none where it is malformed, which a rule of its own tells."""
    try:
        with zipfile.ZipFile(io.BytesIO(arrays.data)) as archive:
            return archive.infolist()
    except UNREADABLE:
        return []


@rule("arrays")
def malformed_arrays(arrays: Arrays) -> Iterator[Finding]:
    """An .npz file is a zip archive of .npy arrays, as numpy writes it."""
    try:
        members = zipfile.ZipFile(io.BytesIO(arrays.data)).infolist()
    except UNREADABLE as mistake:
        yield Finding(arrays.path, f"It is no .npz file: {mistake}.", "Write it with numpy.savez_compressed.")
        return
    for member in members:
        if not member.filename.endswith(".npy") or "/" in member.filename or ".." in member.filename:
            yield Finding(
                arrays.path,
                f"It holds {shown(member.filename)}.",
                "Write arrays alone, by numpy.savez_compressed.",
            )


@rule("arrays")
def unpacks_too_large(arrays: Arrays) -> Iterator[Finding]:
    """An .npz file unpacks to a bounded size and a bounded number of arrays."""
    members = _members(arrays)
    size = sum(member.file_size for member in members)
    if size > LARGEST_UNPACKED or len(members) > MOST_ARRAYS:
        limits = f"the limits are {MOST_ARRAYS} and {LARGEST_UNPACKED}"
        found = f"It unpacks to {len(members)} arrays of {size} bytes; {limits}."
        yield Finding(arrays.path, found, "Keep one episode a trace and one policy a file.")


def _holds_objects(arrays: Arrays, member: zipfile.ZipInfo) -> bool:
    """Whether an array's header names Python objects; raises one of ``UNREADABLE`` where it has no header."""
    with zipfile.ZipFile(io.BytesIO(arrays.data)) as archive, archive.open(member) as stream:
        header = io.BytesIO(stream.read(HEADER_BYTES))
    version = np.lib.format.read_magic(header)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    return bool(read(header)[2].hasobject)


@rule("arrays")
def pickled_arrays(arrays: Arrays) -> Iterator[Finding]:
    """No array holds Python objects: those are pickles, which run code when they are read."""
    for member in _members(arrays):
        name = shown(member.filename)
        try:
            if _holds_objects(arrays, member):
                hint = "Store numbers alone; savez_compressed(..., allow_pickle=False) refuses the rest."
                yield Finding(arrays.path, f"{name} is an array of Python objects (a pickle).", hint)
        except UNREADABLE as mistake:
            found = f"{name} cannot be read: {str(mistake)[:200]}."
            yield Finding(arrays.path, found, "Write it with numpy.savez_compressed.")


@rule("arrays")
def foreign_trace(arrays: Arrays) -> Iterator[Finding]:
    """A trace belongs to an episode of the group's logs."""
    match = TRACE.fullmatch(arrays.path.rsplit("/", 1)[-1])
    if "/traces/" in arrays.path and match and int(match[2]) not in arrays.runs.get(match[1], ()):
        yield Finding(
            arrays.path, f"{match[1]}.csv has no run {match[2]}.", "Remove the trace, or add the run's log."
        )
