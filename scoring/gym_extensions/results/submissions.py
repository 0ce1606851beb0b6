"""The submissions that an argument names. A submission with problems is refused."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from gym_extensions.catalog.custom_groups import with_custom
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.problem import Problem
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.submission import Submission
from gym_extensions.scoring.pipeline.score import find_submissions

Paths = str | Path | Iterable[str | Path]
"""A submission, a folder of submissions, or several of these."""
CustomGroups = Iterable[str | Path | TaskGroup]
"""Groups of the user: TOML files or TaskGroup objects."""


def find(submissions: Paths) -> list[Path]:
    """The folders of the submissions, sorted by name.

    Raises:
        BenchError: a path does not exist, or two submissions have the same name.
    """
    if isinstance(submissions, str | Path):
        return find_submissions([Path(submissions)])
    return find_submissions([Path(path) for path in submissions])


def refuse_problems(folder: Path, problems: Sequence[Problem]) -> None:
    """Raises BenchError if a submission has problems."""
    if problems:
        count = f"{len(problems)} problem{'s' if len(problems) > 1 else ''}"
        message = f"The submission has {count}. First: {problems[0].where}: {problems[0].message}"
        raise BenchError("not-valid", message, str(folder), f"Run: score {folder}")


def read_all(submissions: Paths, groups: CustomGroups) -> Iterator[Submission]:
    """The submissions, read in order of their names.

    Raises:
        BenchError: a path does not exist, a submission has problems, or a group is invalid.
    """
    known = with_custom(groups)
    for folder in find(submissions):
        submission = read(folder, known)
        refuse_problems(folder, submission.problems)
        yield submission
