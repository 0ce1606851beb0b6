"""Rules about .npz files: arrays of numbers, in bounds, and never a pickle. Headers are read, data is not."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gym_extensions.scoring.checks.files import LARGEST, TRACE
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


def _members(arrays: Arrays) -> list[zipfile.ZipInfo]:
    with zipfile.ZipFile(io.BytesIO(arrays.data)) as archive:
        return archive.infolist()


@rule("arrays")
def malformed_arrays(arrays: Arrays) -> Iterator[Finding]:
    """An .npz file is a zip archive of .npy arrays, as numpy writes it."""
    try:
        members = _members(arrays)
    except (zipfile.BadZipFile, ValueError, NotImplementedError, OSError) as mistake:
        yield Finding(arrays.path, f"It is no .npz file: {mistake}.", "Write it with numpy.savez_compressed.")
        return
    for member in members:
        if not member.filename.endswith(".npy") or "/" in member.filename or ".." in member.filename:
            yield Finding(
                arrays.path,
                f"It holds {member.filename!r}.",
                "Write arrays alone, by numpy.savez_compressed.",
            )


@rule("arrays")
def unpacks_too_large(arrays: Arrays) -> Iterator[Finding]:
    """An .npz file unpacks to a bounded size and a bounded number of arrays."""
    try:
        members = _members(arrays)
    except (zipfile.BadZipFile, ValueError, NotImplementedError, OSError):
        return
    size = sum(member.file_size for member in members)
    if size > LARGEST_UNPACKED or len(members) > MOST_ARRAYS:
        limits = f"the limits are {MOST_ARRAYS} and {LARGEST_UNPACKED}"
        found = f"It unpacks to {len(members)} arrays of {size} bytes; {limits}."
        yield Finding(arrays.path, found, "Keep one episode a trace and one policy a file.")


def _kind(header: bytes) -> str:
    """The dtype kind of a .npy header; raises ValueError where it is malformed."""
    stream = io.BytesIO(header)
    version = np.lib.format.read_magic(stream)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    return "O" if read(stream)[2].hasobject else "number"


@rule("arrays")
def pickled_arrays(arrays: Arrays) -> Iterator[Finding]:
    """No array holds Python objects: those are pickles, which run code when they are read."""
    try:
        with zipfile.ZipFile(io.BytesIO(arrays.data)) as archive:
            for member in archive.infolist():
                with archive.open(member) as stream:
                    header = stream.read(HEADER_BYTES)
                if _kind(header) == "O":
                    hint = "Store numbers alone; savez_compressed(..., allow_pickle=False) refuses the rest."
                    yield Finding(
                        arrays.path, f"{member.filename!r} is an array of Python objects (a pickle).", hint
                    )
    except zipfile.BadZipFile:
        return
    except (ValueError, NotImplementedError, OSError, RuntimeError, EOFError) as mistake:
        found = f"An array cannot be read: {str(mistake)[:200]}."
        yield Finding(arrays.path, found, "Write it with numpy.savez_compressed.")


@rule("arrays")
def foreign_trace(arrays: Arrays) -> Iterator[Finding]:
    """A trace belongs to an episode of the group's logs."""
    match = TRACE.fullmatch(arrays.path.rsplit("/", 1)[-1])
    if "/traces/" in arrays.path and match and int(match[2]) not in arrays.runs.get(match[1], ()):
        yield Finding(
            arrays.path, f"{match[1]}.csv has no run {match[2]}.", "Remove the trace, or add the run's log."
        )


LARGEST_PACKED = LARGEST[".npz"]
