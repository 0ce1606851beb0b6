"""Folders of submissions -> scorecards, in parallel and in their order, and the files of ``--out``."""

from __future__ import annotations

import json
import os
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from gym_extensions.catalog.groups import CORE, CORES, GROUPS, TaskGroup, with_custom
from gym_extensions.errors import BenchError, did_you_mean
from gym_extensions.files import write_text
from gym_extensions.rollouts.layout import MANIFEST, NAME, submission_folders
from gym_extensions.rollouts.problem import Problem, escape
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.submission import Submission
from gym_extensions.scoring.leaderboard import boards
from gym_extensions.scoring.references import (
    References,
    add_references,
    load_references,
    read_references,
    references_of_ruler,
    require_references,
)
from gym_extensions.scoring.scorecard import ReferencesInfo, Scorecard, ScorecardDocument
from gym_extensions.scoring.scorer import score

MIN_PARALLEL = 6
"""Number of submissions from which further processes pay."""

EXTRA_WORKERS = 1
"""Workers beyond the CPU count, to overlap disk waits."""


@dataclass(frozen=True)
class Scorer:
    """Scores one folder; can be sent to another process.

    Args:
        references: floors and experts.
        groups: the groups that a submission may contain, by name.
        only: names of the groups that are read and scored; all if empty.
    """

    references: References
    groups: Mapping[str, TaskGroup] = field(default_factory=lambda: GROUPS)
    only: tuple[str, ...] = ()

    def __call__(self, path: Path) -> Scorecard:
        """The scorecard of the submission in that folder.

        If scoring fails, it has a problem instead of scores.
        """
        try:
            return score(read(path, self.groups, only=self.only or None), self.references)
        except BenchError:
            raise
        except Exception as error:  # noqa: BLE001 - an unforeseen folder must not stop the others
            submission = Submission(escape(path.name), None, {}, (fault(path, error),))
            return score(submission, self.references)


def make_scorer(
    groups: Iterable[str | Path | TaskGroup] = (),
    references: str | Path | None = None,
    only: Sequence[str] = (),
    ruler: str | None = None,
) -> Scorer:
    """Scores with the published groups and references, and with the user's own.

    Args:
        groups: custom groups: TOML files or TaskGroup objects.
        references: the references file of the custom groups' tasks, which must have all of them.
        only: names or ids of the groups that are read and scored; all if empty.
        ruler: ``alone``, where 1 is the reference agent on each task alone; None for that of the boards.

    Raises:
        BenchError: a group or the file is invalid, or there is no group or ruler of that name.
    """
    known, scored = references_of_ruler(ruler), with_custom(groups)
    if references is not None:
        known = add_references(known, read_references(Path(references)))
        for group in scored.values():
            if not group.published:
                require_references(known, group.name, group.task_ids, str(references))
    names = [
        each.removesuffix("-v0")
        for name in only
        for each in CORES.get(CORE if name == "core" else name, (name,))
    ]
    for name in names:
        if name not in scored:
            message = f"There is no group {name!r}."
            raise BenchError("unknown-group", message, "--group", did_you_mean(name, scored))
    return Scorer(known, scored, tuple(names))


def fault(path: Path, error: Exception) -> Problem:
    """The problem of a submission whose checks stopped with an unforeseen error."""
    last = traceback.extract_tb(error.__traceback__)[-1]
    message = f"The scorer stopped with {type(error).__name__} in {Path(last.filename).name}, {last.name}."
    hint = "This is a mistake of gym-extensions, whatever the folder contains: please report it."
    return Problem("fault-of-the-scorer", escape(path.name), message, hint)


def scorecards(
    folders: Sequence[Path], scorer: Callable[[Path], Scorecard], workers: int | None = None
) -> Iterator[Scorecard]:
    """The scorecards of the folders in their order, whatever the number of worker processes.

    The processes are started at once, the scorecards come as they are taken.

    Args:
        folders: one submission each.
        scorer: scores each of them.
        workers: number of processes; None chooses it.
    """
    count = min(workers or (os.cpu_count() or 1) + EXTRA_WORKERS, len(folders))
    if count < 2 or (workers is None and len(folders) < MIN_PARALLEL):
        return map(scorer, folders)
    pool = ProcessPoolExecutor(count)
    return _until_done(pool, pool.map(scorer, folders))


def _until_done(pool: ProcessPoolExecutor, results: Iterator[Scorecard]) -> Iterator[Scorecard]:
    with pool:
        yield from results


def find_submissions(paths: Sequence[Path]) -> list[Path]:
    """The submissions that the paths name, sorted by name.

    A path is a submission or a folder of submissions.

    Raises:
        BenchError: a path does not exist, or two submissions have the same name.
    """
    for path in paths:
        if not os.path.lexists(path):
            hint = "Name a submission, or a folder of submissions."
            raise BenchError("no-such-folder", "There is no such folder.", str(path), hint)
    return submission_folders(list(paths))


def references_info(references: References) -> ReferencesInfo:
    """How a document names its references."""
    return ReferencesInfo(references.version, references.digest)


def scorecard_document(cards: Sequence[Scorecard], references: References) -> ScorecardDocument:
    """The document of these scorecards."""
    return ScorecardDocument(references=references_info(references), submissions=tuple(cards))


def score_folders(
    paths: Sequence[str | Path],
    references: References | None = None,
    groups: Mapping[str, TaskGroup] | None = None,
) -> ScorecardDocument:
    """The scorecards of all submissions in the folders, sorted by name.

    Args:
        paths: submissions, or folders of submissions.
        references: floors and experts; the current benchmark version's where None.
        groups: the groups that a submission may contain, by name; the published ones where None.

    Raises:
        BenchError: a path does not exist, or two submissions have the same name.
    """
    references = load_references() if references is None else references
    cards = scorecards(find_submissions(list(map(Path, paths))), Scorer(references, groups or GROUPS))
    return scorecard_document(tuple(cards), references)


def score_folder(
    path: str | Path, references: References | None = None, groups: Mapping[str, TaskGroup] | None = None
) -> Scorecard:
    """The scorecard of the one submission in a folder; the arguments are those of :func:`score_folders`."""
    return Scorer(load_references() if references is None else references, groups or GROUPS)(Path(path))


class Publisher:
    """Writes ``scorecards/<name>.json`` and ``boards.json`` into a folder and removes older scorecards.

    A submission whose name cannot be a file's name (a problem says so) gets no scorecard file.

    Raises:
        BenchError: the folder is a submission, to which no files may be added.
    """

    def __init__(self, folder: Path, references: References) -> None:
        if (folder / MANIFEST).exists():
            raise BenchError("bad-out", "The folder is a submission.", str(folder), "Name another one.")
        self.folder = folder
        self.references = references
        self.cards: list[Scorecard] = []

    def add(self, card: Scorecard) -> None:
        """Writes one scorecard and remembers it for the boards."""
        if NAME.fullmatch(card.name):
            path = self.folder / "scorecards" / f"{card.name}.json"
            write_text(path, scorecard_document([card], self.references).to_json())
        self.cards.append(card)

    def finish(self) -> None:
        """Writes the boards and removes the scorecards of submissions that were not added."""
        names = {card.name for card in self.cards}
        for path in (self.folder / "scorecards").glob("*.json"):
            if path.stem not in names and _is_scorecard(path):
                path.unlink()
        write_text(self.folder / "boards.json", boards(self.cards, self.references).to_json())


def _is_scorecard(path: Path) -> bool:
    try:
        content = json.loads(path.read_bytes())
    except ValueError:
        return False
    return isinstance(content, dict) and {"references", "submissions"} <= content.keys()
