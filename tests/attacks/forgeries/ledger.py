"""Makes the attacks of the table of the same name in `families`."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.curation.ledger.append import Author, append, record, repeated
from gym_extensions.curation.ledger.apply import with_ledgers
from gym_extensions.curation.ledger.chain import read
from gym_extensions.curation.ledger.history import check_history
from gym_extensions.curation.ledger.verify import check_evidence, check_folders
from gym_extensions.errors import BenchError
from gym_extensions.scoring.leaderboard.board import boards
from gym_extensions.scoring.replay.archive import with_archive
from gym_extensions.scoring.replay.verify import verify

from ...curation.repositories import commit, git, make_repository, write_entry
from ..attack import NONE, NOT_DETECTED, Outcome
from ..forger import Forger
from ..judge import SCORER
from ..workshop import Workshop, put

Edit = Callable[[Path], object]
CHOSEN = "5a" * 32
"""A salt that the author chose."""


def repository(workshop: Workshop) -> Path:
    """The folder of submissions of a repository with two entries, whose ledger is committed."""
    folder = make_repository(workshop.empty() / "project")
    for name, bonus in (("first", 0.0), ("second", 5.0)):
        write_entry(folder / "submissions", name, bonus)
    record(folder / "submissions", Author("2026-01-02", "They are accepted."))
    commit(folder)
    return folder / "submissions"


def ledger(edit: Edit) -> Callable[[Workshop], Outcome]:
    """Judges an edited ledger as ``ledger verify --replay`` does."""

    def play(workshop: Workshop) -> Outcome:
        folder = repository(workshop)
        edit(folder)
        try:
            read(folder)
            check_history(folder)
        except BenchError as error:
            return Outcome(NONE, f"ledger verify: {error.code}")
        problems = list(check_folders(folder))
        problems += [problem for _, listed in check_evidence(folder) for problem in listed]
        rules = sorted({problem.rule for problem in problems})
        return Outcome(NONE, f"ledger verify: {', '.join(rules)}" if rules else NOT_DETECTED)

    return play


def text(old: bytes, new: bytes) -> Edit:
    """Replaces a text of the ledger."""

    def edit(folder: Path) -> None:
        path = folder / "ledger.jsonl"
        data = path.read_bytes()
        assert old in data
        path.write_bytes(data.replace(old, new, 1))

    return edit


def rewritten(**changes: object) -> Edit:
    """Writes the whole chain anew with a line that differs."""

    def edit(folder: Path) -> None:
        lines = read(folder)
        (folder / "ledger.jsonl").unlink()
        append(folder, [replace(lines[0], **changes), *lines[1:]])  # type: ignore[arg-type]

    return edit


def appended(**changes: object) -> Edit:
    """Appends a line about the first entry that states something else."""

    def edit(folder: Path) -> None:
        line = repeated(read(folder)[0], "rescored", Author("2026-01-03", "Verified anew."))
        append(folder, [replace(line, **changes)])  # type: ignore[arg-type]

    return edit


def attempted(edit: Edit) -> Callable[[Workshop], Outcome]:
    """Judges an attempt to append a line."""

    def play(workshop: Workshop) -> Outcome:
        try:
            edit(repository(workshop))
        except BenchError as error:
            return Outcome(NONE, f"ledger add: {error.code}")
        return Outcome(NONE, NOT_DETECTED)

    return play


def removed(folder: Path) -> None:
    """Removes the ledger, and starts it anew."""
    (folder / "ledger.jsonl").unlink()
    commit(folder.parent)
    record(folder, Author("2026-01-05", "Accepted."))
    commit(folder.parent)


def last_line_cut(folder: Path) -> None:
    path = folder / "ledger.jsonl"
    path.write_bytes(path.read_bytes()[:-20])


def changed_files(folder: Path) -> None:
    """Edits an entry after it was accepted."""
    (folder / "first" / "README.md").write_text("Better.\n")


def pending(workshop: Workshop) -> Outcome:
    """Edits an accepted entry, and looks at the board."""
    folder = repository(workshop)
    changed_files(folder)
    paths = [folder / "first", folder / "second"]
    cards = list(with_ledgers((replace(SCORER(path), name=path.name) for path in paths), paths))
    rows = [row for board in boards(cards).boards for row in board.rows if row.name == "first"]
    return Outcome(NONE, f"board: {rows[0].why}")


def salted(edit: Callable[[Forger], object], salt: str) -> Callable[[Workshop], Outcome]:
    """Judges a sample of a salt that the author chose, where another one is expected."""

    def play(workshop: Workshop) -> Outcome:
        forger = Forger(workshop.copy("random"))
        edit(forger)
        problems = verify(forger.folder, salt=salt).problems
        return Outcome(NONE, f"salted replay: {', '.join(sorted({problem.rule for problem in problems}))}")

    return play


def archive(edit: Callable[[Forger, Path], object]) -> Callable[[Workshop], Outcome]:
    """Judges an archive of all traces."""

    def play(workshop: Workshop) -> Outcome:
        forger = Forger(workshop.copy("random"))
        source = forger.folder / ".progress" / forger.group.name / "traces"
        edit(forger, source)
        path = forger.folder.parent / "archive.zip"
        with zipfile.ZipFile(path, "w") as content:
            for trace in sorted(source.iterdir()):
                content.write(trace, f"{forger.group.name}/traces/{trace.name}")
        card = with_archive(SCORER(forger.folder), forger.folder, path, GROUPS)
        rules = sorted({problem.rule for problem in card.problems})
        return Outcome(NONE, f"archive: {', '.join(rules)}" if rules else NOT_DETECTED)

    return play


def wrong_sample(forger: Forger) -> None:
    """Draws the traces with one salt and states another."""
    forger.write_sample(CHOSEN)
    put(forger.folder / forger.group.name / "traces" / "salt.txt", b"b7" * 32 + b"\n")


def swapped(forger: Forger, source: Path) -> None:
    first, second = sorted(source.iterdir())[:2]
    data = first.read_bytes()
    put(first, second.read_bytes())
    put(second, data)


def incomplete(forger: Forger, source: Path) -> None:
    min(source.iterdir()).unlink()


def shallow(folder: Path) -> None:
    """Hides the history, as a shallow clone does."""
    head = git(folder.parent, "rev-parse", "HEAD")
    (folder.parent / ".git" / "shallow").write_text(f"{head}\n")
