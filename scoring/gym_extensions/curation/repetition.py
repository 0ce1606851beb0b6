"""Whether a committed record proves that all episodes of a submission were repeated with its policies."""

from __future__ import annotations

from pathlib import Path

from gym_extensions.rollouts.folder import scan
from gym_extensions.scoring.repetition.digests import run_digests
from gym_extensions.scoring.repetition.record import FOLDER, load
from gym_extensions.scoring.repetition.repeat import read_submission


def is_repeated(path: Path) -> bool:
    """Whether the repository of a submission has a record of all runs of all its logs.

    Args:
        path: the submission's folder, in the folder of submissions of a repository.

    Raises:
        BenchError: the file is not a record.
    """
    record = load(path.resolve().parent.parent / FOLDER, path.name)
    return record is not None and record.covers(run_digests(read_submission(path), scan(path)))
