"""A repetition as a committed document, which proves every number of a log."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Literal

from gym_extensions.atomic import write_text
from gym_extensions.scoring.documents import JsonDocument, about
from gym_extensions.scoring.repetition.digests import RunKey

FOLDER = Path("scoring/repetitions")
"""The committed documents, relative to the root of the repository."""


@dataclass(frozen=True, slots=True)
class RepeatedRun:
    """A run whose logged episodes were all repeated bit by bit."""

    group: Annotated[str, about("group id")]
    protocol: Annotated[str, about("`sequential`, `single` or `joint`")]
    run: Annotated[int, about("the run")]
    episodes: Annotated[int, about("number of its episodes")]
    blas: Annotated[str, about("BLAS library and kernels that repeated it")]
    digest: Annotated[str, about("digest of its rows and policies")]

    @property
    def key(self) -> RunKey:
        """Group, protocol and run."""
        return RunKey(self.group, self.protocol, self.run)


@dataclass(frozen=True, slots=True, kw_only=True)
class RepetitionRecord(JsonDocument):
    """The runs of a submission whose episodes were repeated with its policies."""

    format: Annotated[Literal[1], about("version of this document's format")] = 1
    submission: Annotated[str, about("name of the submission's folder")]
    runs: Annotated[tuple[RepeatedRun, ...], about("the repeated runs, sorted")] = ()

    def of(self, digests: Mapping[RunKey, str]) -> RepetitionRecord:
        """The record without runs whose rows or policies are not those of a submission.

        Args:
            digests: the digest of every run of the submission (:func:`run_digests`).
        """
        return replace(self, runs=tuple(each for each in self.runs if digests.get(each.key) == each.digest))

    def covers(self, digests: Mapping[RunKey, str]) -> bool:
        """Whether it has all runs of a submission, given the digest of every run."""
        repeated = {each.key: each.digest for each in self.runs if each.digest}
        return bool(digests) and all(repeated.get(key) == digest for key, digest in digests.items())

    def with_run(self, run: RepeatedRun) -> RepetitionRecord:
        """The record with another run."""
        return replace(self, runs=tuple(sorted((*self.runs, run), key=lambda each: each.key)))


def path_of(folder: Path, submission: str) -> Path:
    """The file of a submission's record."""
    return folder / f"{submission}.json"


def write(folder: Path, record: RepetitionRecord) -> Path:
    """Writes a record and returns its path."""
    path = path_of(folder, record.submission)
    write_text(path, record.to_json())
    return path


def load(folder: Path, submission: str) -> RepetitionRecord | None:
    """The record of a submission, or None if it has none.

    Raises:
        BenchError: the file is not a record.
    """
    return RepetitionRecord.load(path_of(folder, submission), "bad-repetition", "gym-extensions repeat")
