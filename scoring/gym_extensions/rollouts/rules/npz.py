"""Rules about .npz files, which contain arrays of numbers within limits and never a pickle.

Only headers are read.
"""

from __future__ import annotations

import functools
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, stages
from gym_extensions.rollouts.layout import MAX_ARRAYS, TRACE, TRACES, max_unpacked_bytes
from gym_extensions.rollouts.problem import Finding, quote
from gym_extensions.rollouts.reading.evaluation_log import Runs
from gym_extensions.rollouts.rules.rule import rule
from gym_extensions.rollouts.safe_npz import Member, members

REWRITE = "Write the file with numpy.savez_compressed."


@dataclass(frozen=True)
class ArrayFile:
    """The bytes of an .npz file, its path in the submission, its group, the runs of the group's logs."""

    path: str
    data: bytes
    group: TaskGroup
    runs: Runs

    @functools.cached_property
    def listing(self) -> tuple[list[Member], int] | None:
        """The first members and the number of all members, or None if the file is not a zip archive."""
        return members(self.data)

    @property
    def members(self) -> list[Member]:
        """The first members of the archive, or none if the file is not a zip archive."""
        return self.listing[0] if self.listing else []


@rule("arrays")
def malformed_arrays(file: ArrayFile) -> Iterator[Finding]:
    """An .npz file is a zip archive of .npy arrays, as numpy writes it."""
    if file.listing is None:
        yield Finding(file.path, "The file cannot be read as a zip archive.", REWRITE)
    for member in file.members:
        if not member.name.endswith(".npy") or member.name.startswith("/") or ".." in member.name:
            hint = "Write only arrays, with numpy.savez_compressed, and no '..' in their names."
            yield Finding(file.path, f"Unexpected member {quote(member.name)}.", hint)


@rule("arrays")
def repeated_array(file: ArrayFile) -> Iterator[Finding]:
    """The arrays of an .npz file have distinct names."""
    for name, count in Counter(member.name for member in file.members).items():
        if count > 1:
            yield Finding(file.path, f"{quote(name)} appears {count} times.", REWRITE)


@rule("arrays")
def unpacks_too_large(file: ArrayFile) -> Iterator[Finding]:
    """An .npz file keeps to the limits on the uncompressed size and the number of arrays."""
    count = file.listing[1] if file.listing else 0
    size, limit = sum(member.size for member in file.members), max_unpacked_bytes(file.path)
    if size > limit or count > MAX_ARRAYS:
        arrays = f"{count} array{'s' if count > 1 else ''}"
        content = f"{arrays} of {size} bytes" if count <= MAX_ARRAYS else arrays
        message = f"The file unpacks to {content}; the limits are {MAX_ARRAYS} and {limit}."
        yield Finding(file.path, message, "Write one episode per trace and one policy per file.")


@rule("arrays")
def foreign_compression(file: ArrayFile) -> Iterator[Finding]:
    """Arrays are stored or deflated, and not encrypted."""
    for member in file.members:
        if not member.is_plain:
            message = f"{quote(member.name)} is encrypted or uses an unsupported compression method."
            yield Finding(file.path, message, REWRITE)


@rule("arrays")
def pickled_arrays(file: ArrayFile) -> Iterator[Finding]:
    """No array holds Python objects: such arrays are pickles, which can run code when they are read."""
    for member in file.members:
        if member.header and member.header.dtype.hasobject:
            hint = "Store only numbers; savez_compressed(..., allow_pickle=False) refuses objects."
            yield Finding(file.path, f"{quote(member.name)} is an array of Python objects (a pickle).", hint)


@rule("arrays")
def malformed_array(file: ArrayFile) -> Iterator[Finding]:
    """Every array has a header for numbers, as numpy writes it, and the size that its header states."""
    for member in file.members:
        if not member.is_plain or (member.header and member.header.dtype.hasobject):
            continue  # another rule reports it
        name = quote(member.name)
        if member.header is None:
            yield Finding(file.path, f"{name} has no valid header of an array of numbers.", REWRITE)
        elif not member.is_valid:
            expected = f"{member.header.size} for its shape {quote(member.header.shape)}"
            yield Finding(file.path, f"{name} has {member.size} bytes; expected {expected}.", REWRITE)


@rule("arrays")
def foreign_trace(file: ArrayFile) -> Iterator[Finding]:
    """A trace belongs to an episode of the group's logs."""
    match = TRACE.fullmatch(file.path.rsplit("/", 1)[-1])
    if f"/{TRACES}/" not in file.path or match is None:
        return
    protocol, run, stage, _, episode = match.groups()
    runs = file.runs.get(protocol, ())
    if runs is not None and int(run) not in runs:
        hint = "Remove the trace, or add the run to the log."
        yield Finding(file.path, f"{protocol}.csv has no run {run}.", hint)
    if int(stage) not in stages(protocol, len(file.group.tasks)):
        yield Finding(file.path, f"{protocol}.csv has no stage {stage}.", "Remove the trace.")
    if int(episode) >= EVALUATION_EPISODES:
        message = f"Episode {episode} does not exist; cells have episodes 0 to {EVALUATION_EPISODES - 1}."
        yield Finding(file.path, message, "Remove the trace.")
