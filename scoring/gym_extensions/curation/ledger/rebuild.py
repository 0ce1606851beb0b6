"""Rebuilds the boards as of an old line of the ledger, from the files of that time in git."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from gym_extensions.atomic import write_text
from gym_extensions.curation.digest import folder_digest, tree_digest
from gym_extensions.curation.git import Repository, TreeEntry
from gym_extensions.curation.ledger.apply import ledger_record, with_record
from gym_extensions.curation.ledger.chain import FILE, EntryState, read, states
from gym_extensions.curation.ledger.line import LedgerLine
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.layout import MAX_FILES, MAX_SUBMISSION_BYTES, PROGRESS
from gym_extensions.scoring.leaderboard.board import boards
from gym_extensions.scoring.leaderboard.model import BoardsDocument
from gym_extensions.scoring.pipeline.score import score_folders
from gym_extensions.scoring.references import load_references


def extract(repository: Repository, entries: Sequence[TreeEntry], prefix: str, target: Path) -> None:
    """Writes regular files of a commit below a folder.

    Args:
        repository: the repository.
        entries: files with mode 100644 or 100755, whose paths begin with ``prefix`` and are safe.
        prefix: the part of the paths that is left out.
        target: the folder to write to.

    Raises:
        BenchError: the files exceed the limits of a submission.
    """
    if len(entries) > MAX_FILES or sum(entry.size or 0 for entry in entries) > MAX_SUBMISSION_BYTES:
        raise BenchError("too-large", "The files exceed the limits of a submission.", prefix)
    contents = repository.blobs(entry.object_id for entry in entries)
    for entry, content in zip(entries, contents, strict=True):
        path = target / entry.path.removeprefix(prefix)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)


def _restore(repository: Repository, prefix: str, digest: str, target: Path) -> None:
    """Writes the files below a path that have a digest, from the newest commit of HEAD that has them."""
    commits = repository.run("rev-list", "--full-history", "HEAD", "--", prefix.rstrip("/")).decode().split()
    for commit in commits:
        entries = repository.tree(commit, prefix.rstrip("/"))
        if entries and tree_digest(repository, entries, prefix) == digest:
            extract(repository, entries, prefix, target)
            return
    message = f"No commit has files with the digest {digest[:12]}…."
    hint = "Fetch the whole history: `git fetch --unshallow`."
    raise BenchError("lost-entry", message, prefix.rstrip("/"), hint)


def board_after(folder: Path, lines: Sequence[LedgerLine]) -> BoardsDocument:
    """The boards after some lines of a ledger, from the work tree or else from git's history.

    Raises:
        BenchError: the files of an entry are lost, or its line was written with other references.
    """
    present: dict[str, EntryState] = {name: state for name, state in states(lines).items() if state.active}
    references = load_references()
    other = [state.last for state in present.values() if state.last.references != references.digest]
    if other:
        message = f"{other[0].entry!r} was scored by version {other[0].scorer} with other references."
        hint = "Check out a commit with these references and rebuild the board there."
        raise BenchError("other-references", message, FILE, hint)
    repository = Repository(Repository(folder).top)
    root = folder.resolve().relative_to(repository.top.resolve()).as_posix()
    with tempfile.TemporaryDirectory() as scratch:
        submissions = Path(scratch) / "submissions"
        for name, state in present.items():
            target = submissions / name
            path = folder / name
            if path.is_dir() and folder_digest(path) == state.last.digest:
                shutil.copytree(path, target, ignore=shutil.ignore_patterns(PROGRESS))
            else:
                _restore(repository, f"{root}/{name}/", state.last.digest, target)
        cards = score_folders([submissions], references).submissions if present else ()
    recorded = [
        with_record(card, ledger_record(present[card.name].last.digest, present[card.name])) for card in cards
    ]
    return boards([replace(card, challenges=()) for card in recorded])


def write_board(folder: Path, count: int, out: Path) -> None:
    """Writes ``boards.json`` as of the first lines of the ledger in a folder.

    Raises:
        BenchError: the ledger has fewer lines, or the board cannot be rebuilt.
    """
    lines = read(folder)
    if not 1 <= count <= len(lines):
        message = f"The ledger has {len(lines)} lines, so there is no line {count}."
        raise BenchError("no-such-line", message, "--lines", "Name a number from 1 to that.")
    write_text(out, board_after(folder, lines[:count]).to_json())
