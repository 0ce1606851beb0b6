"""Folders of submissions -> scorecards, in parallel and in their order, and the files of ``--out``."""

import os
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from gym_extensions.catalog.groups import CORE, CORES, GROUPS, Groups, TaskGroup, with_custom
from gym_extensions.errors import BenchError, require_known
from gym_extensions.references import References, add_references, load_references, read_references
from gym_extensions.scoring.scorecard import ReferencesInfo, Scorecard, ScorecardDocument
from gym_extensions.scoring.submission.scorer import score
from gym_extensions.submissions import reader, submission
from gym_extensions.submissions.layout import MANIFEST, NAME, submission_folders
from gym_extensions.submissions.problem import Problem, escape, refuse_problems

Paths = str | Path | Iterable[str | Path]
"""A submission, a folder of submissions, or several of these."""
MIN_PARALLEL = 6
"""Number of submissions from which further processes pay."""


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
            return score(reader.read(path, self.groups, only=self.only or None), self.references, self.only)
        except BenchError:
            raise
        except Exception as error:  # noqa: BLE001 - an unforeseen folder must not stop the others
            last = traceback.extract_tb(error.__traceback__)[-1]
            place = f"{Path(last.filename).name}, {last.name}"
            message = f"The scorer stopped with {type(error).__name__} in {place}."
            hint = "This is a mistake of gym-extensions, whatever the folder contains: please report it."
            problem = Problem("fault-of-the-scorer", escape(path.name), message, hint)
            return score(submission.Submission(escape(path.name), None, {}, (problem,)), self.references)


def make_scorer(
    groups: Groups = (),
    references: str | Path | None = None,
    only: Sequence[str] = (),
) -> Scorer:
    """Scores with the published groups and references, and with the user's own.

    Args:
        groups: custom groups: TOML files or TaskGroup objects.
        references: the references file of the custom groups' tasks, which must have all of them.
        only: names or ids of the groups that are read and scored; all if empty.

    Raises:
        BenchError: a group or the file is invalid, or there is no group of that name.
    """
    known, scored = load_references(), with_custom(groups)
    if references is not None:
        known = add_references(known, read_references(Path(references)))
        for group in scored.values():
            if not group.published and (missing := known.missing(group.task_ids)):
                message = f"It has no floor and expert for {missing[0]} of group {group.name}."
                hint = f"Run: gym-extensions maintain references --groups GROUP.toml --out {references}"
                raise BenchError("missing-reference", message, str(references), hint)
    wanted = (CORES.get(CORE if name == "core" else name, (name,)) for name in only)
    by_id = {group.id: name for name, group in scored.items()}
    names = [by_id.get(name, name) for part in wanted for name in part]
    for name in names:
        require_known("group", name, scored, "--group")
    return Scorer(known, scored, tuple(names))


def find_submissions(paths: Paths) -> list[Path]:
    """The folders of the submissions, sorted by name.

    Raises:
        BenchError: a path does not exist, or two submissions have the same name.
    """
    return submission_folders([Path(path) for path in ([paths] if isinstance(paths, str | Path) else paths)])


def valid_scorecards(paths: Paths, scorer: Callable[[Path], Scorecard]) -> dict[Path, Scorecard]:
    """The scorecards by folder, made in this process: a notebook cannot start workers safely everywhere.

    Raises:
        BenchError: a path does not exist, or a submission has problems.
    """
    cards = {}
    for folder in find_submissions(paths):
        cards[folder] = scorer(folder)
        refuse_problems(folder, cards[folder].problems)
    return cards


def scorecards(
    folders: Sequence[Path], scorer: Callable[[Path], Scorecard], workers: int | None = None
) -> Iterator[Scorecard]:
    """The scorecards of the folders in their order, whatever the number of worker processes (None: chosen).

    The processes are started at once, the scorecards come as they are taken.
    """
    count = min(workers or (os.cpu_count() or 1) + 1, len(folders))  # one more overlaps disk waits
    if count < 2 or (workers is None and len(folders) < MIN_PARALLEL):
        return map(scorer, folders)
    pool = ProcessPoolExecutor(count)
    results = pool.map(scorer, folders)

    def until_done() -> Iterator[Scorecard]:
        with pool:
            yield from results

    return until_done()


def scorecard_document(cards: Sequence[Scorecard], references: References) -> ScorecardDocument:
    """The document of these scorecards."""
    return ScorecardDocument(references=ReferencesInfo.of(references), submissions=tuple(cards))


def score_folders(
    paths: Paths, references: References | None = None, groups: Mapping[str, TaskGroup] | None = None
) -> ScorecardDocument:
    """The scorecards of all submissions in the folders, sorted by name.

    Args:
        paths: submissions, or folders of submissions.
        references: floors and experts; the current benchmark version's where None.
        groups: the groups that a submission may contain, by name; the published ones where None.

    Raises:
        BenchError: a path does not exist, or two submissions have the same name.
    """
    references = references or load_references()
    cards = scorecards(find_submissions(paths), Scorer(references, groups or GROUPS))
    return scorecard_document(tuple(cards), references)


def score_folder(
    path: str | Path, references: References | None = None, groups: Mapping[str, TaskGroup] | None = None
) -> Scorecard:
    """The scorecard of the one submission in a folder; the arguments are those of :func:`score_folders`."""
    return Scorer(references or load_references(), groups or GROUPS)(Path(path))


def publish(folder: Path, cards: Iterable[Scorecard], references: References) -> list[Scorecard]:
    """Writes ``scorecards/<name>.json`` as the scorecards come, then ``boards.json``, and returns them.

    Scorecards of other submissions in the folder are removed. A submission whose name cannot be a file's name
    (a problem says so) gets no file.

    Raises:
        BenchError: the folder is a submission, to which no files may be added.
    """
    from gym_extensions.scoring.ranking.group_board import boards  # for which scoring does not wait

    if (folder / MANIFEST).exists():
        raise BenchError("bad-out", "The folder is a submission.", str(folder), "Name another one.")
    written = []
    for card in cards:
        written.append(card)
        if NAME.fullmatch(card.name):
            scorecard_document([card], references).write(folder / "scorecards" / f"{card.name}.json")
    names = {card.name for card in written}
    for path in (folder / "scorecards").glob("*.json"):
        if path.stem not in names and b'"submissions"' in path.read_bytes():
            path.unlink()
    boards(written, references).write(folder / "boards.json")
    return written
