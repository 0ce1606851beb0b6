"""The rule about what the operating system does not give."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from gym_extensions.rollouts.problem import Finding
from gym_extensions.rollouts.rules.rule import rule


@dataclass(frozen=True)
class Unreadable:
    """A file that the operating system did not give."""

    path: str
    reason: str


@rule("unreadable")
def unreadable_file(file: Unreadable) -> Iterator[Finding]:
    """Every file of a submission can be read."""
    yield Finding(
        file.path, f"The file cannot be read: {file.reason}.", "Give it read permission, or copy it again."
    )
