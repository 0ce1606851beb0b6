"""Scorecards with what the ledger says of them: the board is built from its lines, without replay."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from gym_extensions.curation.challenges import challenges_of, read_challenges
from gym_extensions.curation.digest import folder_digest
from gym_extensions.curation.ledger.chain import FILE, EntryState, read, states
from gym_extensions.scoring.repetition.scorecard import without_missing_evidence
from gym_extensions.scoring.scorecard.model import VALIDATED, Scorecard
from gym_extensions.scoring.scorecard.record import Challenge, LedgerRecord


def ledger_record(digest: str, state: EntryState | None) -> LedgerRecord:
    """What the ledger says of files with a digest.

    Args:
        digest: the digest of the submission's files.
        state: the state of the entry of that name; None if the ledger does not have it.
    """
    if state is None or state.last.digest != digest:
        return LedgerRecord(event="pending", digest=digest)
    line = state.last
    return LedgerRecord(
        event=line.event,
        digest=digest,
        date=line.date,
        accepted=state.accepted.date,
        reason=line.reason,
        level=line.level,
        replayed=line.replayed,
        episodes=line.episodes,
        scorer=line.scorer,
        salt=line.salt,
    )


def with_record(card: Scorecard, record: LedgerRecord) -> Scorecard:
    """The scorecard with the ledger's record, and with its level of trust unless a replay gave one already.

    A scorecard with problems is returned unchanged: files that break a rule are not what was accepted. Where
    all episodes were replayed, no trace is missing for a rank.
    """
    if card.problems:
        return card
    trust = record.trust if card.trust == VALIDATED and not record.is_pending else card.trust
    groups = without_missing_evidence(card.groups) if record.is_complete else card.groups
    return replace(card, ledger=record, trust=trust, groups=groups)


def with_ledgers(
    cards: Iterable[Scorecard], folders: Sequence[Path], digest_of: Callable[[Path], str] = folder_digest
) -> Iterator[Scorecard]:
    """The scorecards with the records of the ledgers and with the challenges of their entries, one by one.

    Args:
        cards: the scorecards of the submissions.
        folders: the folder of each scorecard's submission, in the same order. Its ledger is the file
            ``ledger.jsonl`` beside the folder; without one, the scorecard is unchanged.
        digest_of: the digest of a folder's files.

    Raises:
        BenchError: a ledger is broken.
    """
    ledgers: dict[Path, Mapping[str, EntryState]] = {}
    challenges: dict[Path, tuple[Challenge, ...]] = {}
    for card, path in zip(cards, folders, strict=True):
        root = path.resolve().parent
        if not (root / FILE).is_file() or card.problems:
            yield card
            continue
        if root not in ledgers:
            ledgers[root] = states(read(root))
            challenges[root] = read_challenges(root.parent)
        record = ledger_record(digest_of(path), ledgers[root].get(path.name))
        doubts = challenges_of(path.name, challenges[root])
        yield replace(with_record(card, record), challenges=doubts)
