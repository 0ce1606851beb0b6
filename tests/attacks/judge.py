"""Judges a submission step by step, as maintainers do, until something stops it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path

from gym_extensions.baselines.reproduction.reproduce import reproduce
from gym_extensions.catalog.registry import TASKS
from gym_extensions.curation.digest import folder_digest, folder_hashes
from gym_extensions.curation.evidence import Evidence, prove
from gym_extensions.curation.ledger.apply import with_record
from gym_extensions.curation.salt import derive_salt
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.auditing.submission_digest import digest_without_traces
from gym_extensions.scoring.leaderboard.board import boards
from gym_extensions.scoring.pipeline.score import Scorer
from gym_extensions.scoring.reevaluation.reevaluate import reevaluate
from gym_extensions.scoring.references import Reference, References
from gym_extensions.scoring.repetition.runs import repeat
from gym_extensions.scoring.scorecard.model import Scorecard
from gym_extensions.scoring.scorecard.record import LedgerRecord

from .attack import NONE, NOT_DETECTED, REEVALUATED, REPLAYED, REPRODUCED, Outcome
from .forger import Forger
from .workshop import Workshop

MERGE = "3f" * 20
"""The commit that merges a submission, which its author does not know."""
EARLIER, LATER = "2026-01-01", "2026-02-01"
"""Days on which an honest submission and an attack are accepted."""
REFERENCES = References("synthetic", True, {task: Reference(-10_000.0, 1000.0, False) for task in TASKS})
"""References of all tasks, so that every group has a board."""
SCORER = Scorer(REFERENCES)

Make = Callable[[Workshop], Path]


def submission(make: Make, *, beside: str = "") -> Callable[[Workshop], Outcome]:
    """Judges a submission.

    Args:
        make: makes its folder.
        beside: the honest submission that is on the board already, by its name in the workshop.
    """

    def play(workshop: Workshop) -> Outcome:
        folder = make(workshop)
        original = workshop.honest(beside) if beside else None
        return judge(folder, [accepted(original, prove(original), EARLIER)] if original else [])

    return play


def judge(folder: Path, others: Iterable[Scorecard] = ()) -> Outcome:
    """The outcome of a submission whose author has the traces in ``.progress`` and draws each sample.

    The steps are those of docs/pull-requests.md and docs/ledger.md: the rules; replay of the sample without a
    salt; after the merge, replay of the sample that the merge commit draws; the board; repetition of all
    episodes; new seeds; retraining of the first run.
    """
    evidence = prove(folder)
    if evidence.problems:
        return Outcome(NONE, step("replay" if evidence.episodes else "rules", evidence))
    salt = derive_salt(digest_without_traces(folder_hashes(folder)), MERGE)
    if evidence.replayed:
        Forger(folder).write_sample(salt)
        evidence = prove(folder, salt)
        if evidence.problems:
            return Outcome(NONE, step("salted replay", evidence))
    card = accepted(folder, evidence, LATER, salt)
    document = boards([*others, card])
    entries = [entry for board in document.boards for entry in board.rows if entry.name == card.name]
    if not entries:
        return Outcome(NONE, "board: not on a board")
    if not entries[0].ranked:
        return Outcome(NONE, f"board: {entries[0].why}")
    return beyond_replay(folder, salt)


def beyond_replay(folder: Path, salt: str) -> Outcome:
    """The outcome of a submission that has a rank as replayed.

    The repetition runs on the machine of the log, so that an honest log is repeated.
    """
    if is_another_in_repetition(folder):
        return Outcome(REPLAYED, "repetition: differs")
    fresh = reevaluate(folder, salt)
    if fresh.problems:
        rules = sorted({problem.rule for problem in fresh.problems})
        return Outcome(REPLAYED, f"new seeds: {', '.join(rules)}")
    if not fresh.is_complete:
        return Outcome(
            REPLAYED,
            "new seeds: no policies" if fresh.p_value is None else "new seeds: no policies for some logs",
        )
    forger = Forger(folder)
    protocol = next(name for name in ("sequential", "single", "joint") if forger.log(name).exists())
    try:
        comparison = reproduce(folder, forger.group, protocol, 0, progress=False).comparison
    except BenchError as error:
        return Outcome(REEVALUATED, f"retraining: {error.code}")
    if comparison.agrees:
        return Outcome(REPRODUCED, NOT_DETECTED)
    return Outcome(REEVALUATED, "retraining: differs")


def is_another_in_repetition(folder: Path) -> bool:
    """Whether stored policies that can be repeated give other episodes than the log."""
    try:
        return any(run.difference for run in repeat(folder))
    except BenchError as error:
        if error.code != "sampled-actions":
            raise
        return False


def step(name: str, evidence: Evidence) -> str:
    """A step with the rules that are broken."""
    return f"{name}: {', '.join(sorted({problem.rule for problem in evidence.problems}))}"


def accepted(folder: Path, evidence: Evidence, date: str, salt: str = "") -> Scorecard:
    """The scorecard of a submission that the ledger accepted on a day with this evidence."""
    record = LedgerRecord(
        event="accepted",
        accepted=date,
        digest=folder_digest(folder),
        level=evidence.level,
        replayed=evidence.replayed,
        episodes=evidence.episodes,
        salt=salt,
    )
    return with_record(replace(SCORER(folder), name=folder.name), record)
