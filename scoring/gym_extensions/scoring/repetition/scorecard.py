"""The scorecard of a submission whose episodes were all repeated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.rollouts.folder import scan
from gym_extensions.rollouts.reader import read
from gym_extensions.scoring.repetition.digests import run_digests
from gym_extensions.scoring.repetition.record import FOLDER, load
from gym_extensions.scoring.scorecard.model import GroupScore, Scorecard

Groups = Mapping[str, Mapping[str, GroupScore]]


def is_repeated(path: Path, groups: Mapping[str, TaskGroup] = GROUPS) -> bool:
    """Whether the repository of a submission has a record of all runs of all its logs.

    Args:
        path: the submission's folder, in the folder of submissions of a repository.
        groups: the groups that it may contain, by name.

    Raises:
        BenchError: the file is not a record.
    """
    record = load(path.resolve().parent.parent / FOLDER, path.resolve().name)
    if record is None:
        return False
    submission = read(path, groups, merge_runs=False)
    return not submission.problems and record.covers(run_digests(submission, scan(path, groups)))


def without_missing_evidence(groups: Groups) -> dict[str, dict[str, GroupScore]]:
    """The scores of groups of which no trace is missing, because all episodes were replayed."""
    return {
        name: {protocol: replace(score, missing_evidence="") for protocol, score in scores.items()}
        for name, scores in groups.items()
    }


def with_repetition(card: Scorecard, path: Path, groups: Mapping[str, TaskGroup] = GROUPS) -> Scorecard:
    """The scorecard; without missing traces if the repository has the record of a repetition.

    Args:
        card: the scorecard of the submission.
        path: the submission's folder.
        groups: the groups that it may contain, by name.

    Raises:
        BenchError: the record cannot be read.
    """
    is_missing = any(score.missing_evidence for scores in card.groups.values() for score in scores.values())
    if not is_missing or not is_repeated(path, groups):
        return card
    return replace(card, groups=without_missing_evidence(card.groups))
