"""Rules about .npz files: arrays of numbers, in bounds, and never a pickle. Headers are read, data is not."""

from __future__ import annotations

import functools
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, stages
from gym_extensions.rollouts.layout import TRACE
from gym_extensions.rollouts.problem import Finding, shown
from gym_extensions.rollouts.reading.evaluation_log import Runs
from gym_extensions.rollouts.rules.rule import rule
from gym_extensions.rollouts.safe_npz import LARGEST_UNPACKED, MOST_ARRAYS, Member, members

REWRITE = "Write it with numpy.savez_compressed."


@dataclass(frozen=True)
class Arrays:
    """The bytes of one .npz file, its path in the submission, its group, the runs of the group's logs."""

    path: str
    data: bytes
    group: TaskGroup
    runs: Runs

    @functools.cached_property
    def found(self) -> tuple[list[Member], int] | None:
        """The first members and the number of all; None where the bytes are no archive."""
        return members(self.data)

    @property
    def members(self) -> list[Member]:
        """The first members of the archive, none where it is no archive."""
        return self.found[0] if self.found else []


@rule("arrays")
def malformed_arrays(arrays: Arrays) -> Iterator[Finding]:
    """An .npz file is a zip archive of .npy arrays, as numpy writes it."""
    if arrays.found is None:
        yield Finding(arrays.path, "It is no .npz file: it cannot be read as a zip archive.", REWRITE)
    for member in arrays.members:
        if not member.name.endswith(".npy") or member.name.startswith("/") or ".." in member.name:
            hint = "Write arrays alone, by numpy.savez_compressed, named without '..'."
            yield Finding(arrays.path, f"It holds {shown(member.name)}.", hint)


@rule("arrays")
def repeated_array(arrays: Arrays) -> Iterator[Finding]:
    """Each array of an .npz file has a name of its own: of two with one name only one would be read."""
    for name, count in Counter(member.name for member in arrays.members).items():
        if count > 1:
            yield Finding(arrays.path, f"It holds {shown(name)} {count} times.", REWRITE)


@rule("arrays")
def unpacks_too_large(arrays: Arrays) -> Iterator[Finding]:
    """An .npz file unpacks to a bounded size and a bounded number of arrays."""
    count = arrays.found[1] if arrays.found else 0
    size = sum(member.size for member in arrays.members)
    if size > LARGEST_UNPACKED or count > MOST_ARRAYS:
        told = f" of {size} bytes" if count <= MOST_ARRAYS else ""
        found = f"It unpacks to {count} arrays{told}; the limits are {MOST_ARRAYS} and {LARGEST_UNPACKED}."
        yield Finding(arrays.path, found, "Keep one episode a trace and one policy a file.")


@rule("arrays")
def foreign_compression(arrays: Arrays) -> Iterator[Finding]:
    """Arrays are stored or deflated, and not encrypted: numpy packs them in no other way."""
    for member in arrays.members:
        if not member.plain:
            found = f"{shown(member.name)} is packed in another way or encrypted."
            yield Finding(arrays.path, found, REWRITE)


@rule("arrays")
def pickled_arrays(arrays: Arrays) -> Iterator[Finding]:
    """No array holds Python objects: those are pickles, which run code when they are read."""
    for member in arrays.members:
        if member.header and member.header.objects:
            hint = "Store numbers alone; savez_compressed(..., allow_pickle=False) refuses the rest."
            yield Finding(
                arrays.path, f"{shown(member.name)} is an array of Python objects (a pickle).", hint
            )


@rule("arrays")
def malformed_array(arrays: Arrays) -> Iterator[Finding]:
    """Every array has a header as numpy writes it for numbers, and as many bytes as its shape needs."""
    for member in arrays.members:
        if not member.plain or (member.header and member.header.objects):
            continue  # told by another rule
        name = shown(member.name)
        if member.header is None:
            yield Finding(arrays.path, f"{name} has no header of an array of numbers.", REWRITE)
        elif not member.sound:
            needed = f"its shape {shown(member.header.shape)} needs {member.header.size}"
            yield Finding(arrays.path, f"{name} has {member.size} bytes; {needed}.", REWRITE)


@rule("arrays")
def foreign_trace(arrays: Arrays) -> Iterator[Finding]:
    """A trace belongs to an episode of the group's logs."""
    match = TRACE.fullmatch(arrays.path.rsplit("/", 1)[-1])
    if "/traces/" not in arrays.path or match is None:
        return
    protocol, run, stage, _, episode = match.groups()
    runs = arrays.runs.get(protocol, ())
    if runs is not None and int(run) not in runs:
        found, hint = f"{protocol}.csv has no run {run}.", "Remove the trace, or add the run's log."
        yield Finding(arrays.path, found, hint)
    if int(stage) not in stages(protocol, len(arrays.group.tasks)):
        yield Finding(arrays.path, f"{protocol}.csv has no stage {stage}.", "Remove the trace.")
    if int(episode) >= EVALUATION_EPISODES:
        yield Finding(arrays.path, f"A cell has no episode {episode}.", "Remove the trace.")
