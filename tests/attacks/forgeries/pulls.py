"""Makes the attacks of the table of the same name in `families`."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from gym_extensions.curation.gate.check import Request, check_pull_request
from gym_extensions.curation.gate.report import read_report
from gym_extensions.curation.git import Repository
from gym_extensions.curation.ledger.append import Author, append, repeated
from gym_extensions.curation.ledger.chain import read
from gym_extensions.curation.salt import fixing_commit
from gym_extensions.errors import BenchError

from ...curation.repositories import commit, git, make_project
from ..attack import NONE, NOT_DETECTED, REPLAYED, Outcome
from ..workshop import Workshop

Play = Callable[[Path], object]


def request(play: Play, branch: str = "request") -> Callable[[Workshop], Outcome]:
    """Judges what an attacker does on a branch: ``request`` equals the base, ``entry`` adds an entry."""

    def run(workshop: Workshop) -> Outcome:
        folder = make_project(workshop.empty() / "project")
        git(folder, "switch", "--quiet", branch)
        play(folder)
        report = check_pull_request(Request(Repository(folder), "main"))
        rules = sorted({problem.rule for problem in report.problems})
        return Outcome(NONE, f"check-pr: {', '.join(rules) or report.verdict}")

    return run


def write(path: str, text: str) -> Play:
    """Commits a file."""
    return lambda folder: commit(folder, {path: text})


def edited_line(folder: Path) -> None:
    """Edits an old line, and writes a whole chain."""
    line = read(folder / "submissions")[-1]
    (folder / "submissions" / "ledger.jsonl").unlink()
    append(folder / "submissions", [replace(line, level="reproduced", replayed=3)])
    commit(folder)


def foreign_line(folder: Path) -> None:
    line = replace(read(folder / "submissions")[-1], entry="absent", date="2026-01-02")
    append(folder / "submissions", [line])
    commit(folder)


def own_level(folder: Path) -> None:
    """Appends a line that states a higher level."""
    line = repeated(read(folder / "submissions")[-1], "rescored", Author("2026-01-02", "Reproduced."))
    append(folder / "submissions", [replace(line, level="reproduced", replayed=3)])
    commit(folder)


def withdrawn(folder: Path) -> None:
    """Withdraws a rival."""
    line = repeated(read(folder / "submissions")[-1], "withdrawn", Author("2026-01-02", "Gone."))
    append(folder / "submissions", [line])
    commit(folder)


def loose_line(folder: Path) -> None:
    path = folder / "submissions" / "ledger.jsonl"
    line = repeated(read(folder / "submissions")[-1], "challenged", Author("2026-01-02", "In doubt."))
    commit(folder, {"submissions/ledger.jsonl": path.read_bytes() + line.encode()})


def outdated(folder: Path) -> None:
    commit(folder, {"submissions/old/README.md": "One text.\n"})
    git(folder, "switch", "--quiet", "main")
    commit(folder, {"submissions/old/README.md": "Another text.\n"})
    git(folder, "switch", "--quiet", "request")


def linked(folder: Path) -> None:
    shutil.rmtree(folder / "submissions" / "old")
    (folder / "submissions" / "old").symlink_to("../scoring")
    commit(folder)


def orphan(folder: Path) -> None:
    git(folder, "switch", "--quiet", "--orphan", "alone")
    commit(folder, {"submissions/new/submission.toml": "x"})


def forged_report(workshop: Workshop) -> Outcome:
    """Hands the second workflow a report with markup and a level of its own."""
    report = check_pull_request(
        Request(Repository(make_project(workshop.empty() / "project")), "main", head="entry")
    )
    text = report.to_json().replace('"validated"', '"<b>first</b>"', 1)
    try:
        read_report(text.encode())
    except BenchError as error:
        return Outcome(NONE, f"comment: {error.code}")
    return Outcome(NONE, NOT_DETECTED)


def fast_forward(workshop: Workshop) -> Outcome:
    """Merges without a merge commit: the author's own commit then determines the salt."""
    folder = make_project(workshop.empty() / "project")
    author = git(folder, "rev-parse", "entry")
    git(folder, "switch", "--quiet", "main")
    git(folder, "merge", "--quiet", "--ff-only", "entry")
    fixed = fixing_commit(Repository(folder), "HEAD", "submissions/new")
    return Outcome(REPLAYED, NOT_DETECTED if fixed == author else "salt: merge commit")
