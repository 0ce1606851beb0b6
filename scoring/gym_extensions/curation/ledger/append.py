"""Appends lines to a ledger. The file is replaced as a whole, so it never ends in the middle of a line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path

from gym_extensions.atomic import write_bytes
from gym_extensions.curation.digest import (
    digest_of,
    folder_digest,
    folder_hashes,
    tree_hashes,
)
from gym_extensions.curation.evidence import Evidence, prove
from gym_extensions.curation.git import Repository
from gym_extensions.curation.ledger.chain import FILE, parse, read, states
from gym_extensions.curation.ledger.line import START, Event, LedgerLine, check_values
from gym_extensions.curation.reevaluation import require_reevaluation
from gym_extensions.curation.salt import derive_salt, fixing_commit
from gym_extensions.errors import BenchError, did_you_mean
from gym_extensions.rollouts.auditing.submission_digest import digest_without_traces
from gym_extensions.rollouts.folder import submission_folders
from gym_extensions.scoring.references import load_references
from gym_extensions.scoring.scorecard.record import Level

MERGE = "merge"
OTHER_SALT = (
    "Pass --value merge if the salt of the merge has drawn the traces; otherwise draw them again with "
    "`gym-extensions trace`."
)


@dataclass(frozen=True)
class Author:
    """What a maintainer states about lines: the date, the reason, and a value for the salt.

    The value is empty for no salt, or ``MERGE`` for the commit that fixed the submission.
    """

    date: str
    reason: str
    value: str = ""


def append(folder: Path, lines: Sequence[LedgerLine]) -> tuple[LedgerLine, ...]:
    """Appends lines and returns them with their links; ``previous`` of the arguments is replaced.

    Raises:
        BenchError: the ledger is broken, or a line cannot follow. The file is unchanged then.
    """
    path, before = folder / FILE, read(folder)
    linked: list[LedgerLine] = []
    for line in lines:
        last = [*before, *linked][-1:]
        linked.append(replace(line, previous=last[0].sha256 if last else START))
        check_values(linked[-1], "the new line")
    data = b"".join(line.encode() for line in (*before, *linked))  # a line has one spelling
    parse(data, str(path))
    write_bytes(path, data)
    return tuple(linked)


def repeated(last: LedgerLine, event: Event, author: Author) -> LedgerLine:
    """A line of an entry with the digest and the evidence of its last one."""
    return replace(last, event=event, date=author.date, reason=author.reason)


def verified_line(path: Path, event: Event, author: Author, level: Level | None = None) -> LedgerLine:
    """A line about a submission's folder, with the evidence that replay gives now.

    Args:
        path: the submission's folder.
        event: ``accepted`` or ``rescored``.
        author: date, reason and value.
        level: a level above ``replayed`` that other commands have proven. *Re-evaluated* needs the record of
            ``gym-extensions reevaluate`` with this salt.

    Raises:
        BenchError: the submission has problems, or the level is not proven.
    """
    hashes = folder_hashes(path)
    value, salt = _value_and_salt(path, hashes, author.value)
    if level == "re-evaluated":
        require_reevaluation(path, digest_without_traces(hashes), salt)
    evidence = prove(path, salt)
    if evidence.level is None:
        problem = evidence.problems[0]
        count = len(evidence.problems)
        message = f"It has {count} problem{'s' * (count > 1)}, first {problem.rule}: {problem.message}"
        hint = OTHER_SALT if problem.rule == "other-salt" else f"Run `score --verify {path}`."
        raise BenchError("refused-submission", message, f"{path.name}/{problem.where}", hint)
    return LedgerLine(
        previous=START,
        date=author.date,
        event=event,
        entry=path.name,
        reason=author.reason,
        digest=digest_of(hashes),
        level=_level(evidence, level),
        replayed=evidence.replayed,
        episodes=evidence.episodes,
        scorer=version("gym-extensions"),
        references=load_references().digest,
        value=value,
        salt=salt,
    )


def entry_folder(folder: Path, entry: str) -> Path:
    """The folder of an entry.

    Raises:
        BenchError: there is none.
    """
    path = folder / entry
    if not path.is_dir():
        names = [candidate.name for candidate in submission_folders([folder])]
        message = f"There is no submission {entry!r}."
        raise BenchError("unknown-entry", message, str(folder), did_you_mean(entry, names))
    return path


def salt_of(path: Path, value: str = MERGE) -> str:
    """The salt of a submission's folder that follows from a value.

    Raises:
        BenchError: the value is malformed; or it is ``merge`` and the files, except traces, are not those of
            HEAD.
    """
    return _value_and_salt(path, folder_hashes(path), value)[1]


def _value_and_salt(path: Path, hashes: Mapping[str, str], value: str) -> tuple[str, str]:
    """The value, with ``merge`` replaced by the commit, and the salt; both empty without a value."""
    number = _merge_commit(path, hashes) if value == MERGE else value
    return number, derive_salt(digest_without_traces(hashes), number) if number else ""


def _merge_commit(path: Path, hashes: Mapping[str, str]) -> str:
    """The commit that fixed a submission whose files, except traces, are those of HEAD."""
    repository = Repository(Repository(path).top)
    folder = path.resolve().relative_to(repository.top.resolve()).as_posix()
    committed = tree_hashes(repository, repository.tree("HEAD", folder), f"{folder}/")
    if digest_without_traces(committed) != digest_without_traces(hashes):
        hint = "Commit the entry first. Then the commit fixes its salt."
        raise BenchError("not-committed", "Its files are not those of the last commit.", str(path), hint)
    commit = fixing_commit(repository, "HEAD", folder) if committed else ""
    if not commit:
        hint = "Switch to the branch that has it, such as main after the merge."
        raise BenchError("not-committed", "No commit of this branch has the entry.", str(path), hint)
    return commit


def _level(evidence: Evidence, claimed: Level | None) -> Level:
    measured: Level = evidence.level or "validated"
    if claimed is None or claimed == measured:
        return measured
    if measured != "replayed" or claimed not in ("re-evaluated", "reproduced"):
        message = f"The level {claimed} needs another evidence than {measured}."
        raise BenchError("unproven-level", message, "--level", "Leave --level out.")
    return claimed


def add(folder: Path, entry: str, event: Event, author: Author, level: Level | None = None) -> LedgerLine:
    """Appends one line about an entry. ``accepted`` and ``rescored`` replay its folder first.

    Raises:
        BenchError: there is no such entry, it has problems, or the event cannot follow its last one.
    """
    if event in ("accepted", "rescored"):
        line = verified_line(entry_folder(folder, entry), event, author, level)
    else:
        state = states(read(folder)).get(entry)
        if state is None:
            names = list(states(read(folder)))
            message = f"The ledger has no entry {entry!r}."
            raise BenchError("unknown-entry", message, str(folder / FILE), did_you_mean(entry, names))
        line = repeated(state.last, event, author)
    return append(folder, [line])[0]


def record(folder: Path, author: Author) -> tuple[LedgerLine, ...]:
    """Appends the lines that make the ledger agree with the folder.

    A new entry is accepted. An entry whose files changed is superseded and accepted anew. An entry whose
    folder is gone is withdrawn. Entries that agree get no line.

    Raises:
        BenchError: a submission has problems; no line is appended then.
    """
    before = states(read(folder))
    paths = {path.name: path for path in submission_folders([folder])}
    lines: list[LedgerLine] = []
    for name in sorted(paths.keys() | {name for name, state in before.items() if state.active}):
        state = before.get(name)
        active = state if state and state.active else None
        if name not in paths:
            assert active is not None
            lines.append(repeated(active.last, "withdrawn", author))
        elif active is None or active.last.digest != folder_digest(paths[name]):
            superseded = [repeated(active.last, "superseded", author)] if active else []
            lines += [*superseded, verified_line(paths[name], "accepted", author)]
    return append(folder, lines) if lines else ()
