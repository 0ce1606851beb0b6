"""A re-evaluation as a committed document, which pages show without a simulator."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import isclose
from pathlib import Path
from typing import Annotated, Literal

from gym_extensions.atomic import write_text
from gym_extensions.scoring.documents import JsonDocument, about
from gym_extensions.scoring.scorecard.model import FreshScore, GroupScore, NewSeeds, Scorecard

FOLDER = Path("scoring/reevaluations")
"""The committed documents, relative to the root of the repository."""
AGREEMENT = 1e-9
"""Relative difference up to which a logged mean is that of the scorecard."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReevaluationRecord(JsonDocument):
    """The returns of a submission's policies on new seeds, beside the logged ones."""

    format: Annotated[Literal[1], about("version of this document's format")] = 1
    submission: Annotated[str, about("name of the submission's folder")]
    is_complete: Annotated[bool, about("whether the submission has the policies of all its logs")]
    new_seeds: Annotated[NewSeeds, about("what the seeds follow from, and the test")]
    groups: Annotated[dict[str, dict[str, FreshScore]], about("returns by group id and protocol")]


def path_of(folder: Path, submission: str) -> Path:
    """The file of a submission's record."""
    return folder / f"{submission}.json"


def write(folder: Path, record: ReevaluationRecord) -> Path:
    """Writes a record and returns its path."""
    path = path_of(folder, record.submission)
    write_text(path, record.to_json())
    return path


def load(folder: Path, submission: str) -> ReevaluationRecord | None:
    """The record of a submission, or None if it has none.

    Raises:
        BenchError: the file is not a record.
    """
    return ReevaluationRecord.load(
        path_of(folder, submission), "bad-reevaluation", "gym-extensions reevaluate"
    )


def with_record(card: Scorecard, record: ReevaluationRecord | None) -> Scorecard:
    """The scorecard with the returns of a record beside the logged ones.

    A record of an earlier log, whose logged means are not those of the scorecard, changes nothing.
    """
    if record is None or card.problems or not _shows(record, card):
        return card
    return replace(card, groups=with_returns(card.groups, record.groups), new_seeds=record.new_seeds)


def with_returns(
    groups: Mapping[str, Mapping[str, GroupScore]], returns: Mapping[str, Mapping[str, FreshScore]]
) -> dict[str, dict[str, GroupScore]]:
    """The scores of groups, each with the returns on new seeds of its log."""
    return {
        name: {
            protocol: replace(score, reevaluation=returns.get(name, {}).get(protocol))
            for protocol, score in protocols.items()
        }
        for name, protocols in groups.items()
    }


def _shows(record: ReevaluationRecord, card: Scorecard) -> bool:
    """Whether the record's logged means are those of the scorecard."""
    for name, protocols in record.groups.items():
        for protocol, returns in protocols.items():
            score = card.groups.get(name, {}).get(protocol)
            if score is None or not _is_of(returns, score):
                return False
    return True


def _is_of(returns: FreshScore, score: GroupScore) -> bool:
    for cell in returns.cells:
        try:
            stages = score.return_matrix[score.runs.index(cell.run)]
            stage = stages[cell.stage] if len(stages) > 1 else stages[0]
            logged = stage[score.tasks.index(cell.task)]
        except (ValueError, IndexError):
            return False
        if not isclose(logged, cell.logged, rel_tol=AGREEMENT, abs_tol=AGREEMENT):
            return False
    return True
