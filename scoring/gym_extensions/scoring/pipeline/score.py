"""Folders of submissions -> scorecards, in parallel and in the order of the folders."""

from __future__ import annotations

import os
import traceback
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

from gym_extensions.catalog.custom_groups import with_custom
from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.folder import submission_folders
from gym_extensions.rollouts.problem import Problem, escape
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.submission import Submission
from gym_extensions.scoring.pipeline.evidence import Evidence, with_evidence
from gym_extensions.scoring.references import References, add_references, load_references, read_references
from gym_extensions.scoring.repetition.scorecard import with_repetition
from gym_extensions.scoring.scorecard.build import score
from gym_extensions.scoring.scorecard.model import ReferencesInfo, Scorecard, ScorecardDocument

MIN_PARALLEL = 6
"""Number of submissions from which further processes pay."""

EXTRA_WORKERS = 1
"""Workers beyond the CPU count, to overlap disk waits."""

QUEUED_PER_WORKER = 4
"""Upper bound on submissions per worker that are being scored or wait to be consumed."""


@dataclass(frozen=True)
class Scorer:
    """Scores one folder; can be sent to another process.

    Args:
        references: floors and ceilings.
        groups: the groups that a submission may contain, by name.
    """

    references: References
    groups: Mapping[str, TaskGroup] = field(default_factory=lambda: GROUPS)

    def __call__(self, path: Path) -> Scorecard:
        """The scorecard of the submission in that folder.

        If scoring fails, it has a problem instead of scores.
        """
        try:
            card = score(read(path, self.groups), self.references)
            return with_repetition(card, path, self.groups)
        except BenchError:
            raise
        except Exception as error:  # noqa: BLE001 - an unforeseen folder must not stop the others
            submission = Submission(escape(path.name), None, {}, (fault(path, error),))
            return score(submission, self.references)


def make_scorer(
    groups: Iterable[str | Path | TaskGroup] = (), references: str | Path | None = None
) -> Scorer:
    """Scores with the published groups and references, and with the user's own.

    Args:
        groups: custom groups: TOML files or TaskGroup objects.
        references: the references file of the custom groups' tasks.

    Raises:
        BenchError: a group or the file is invalid.
    """
    known = load_references()
    if references is not None:
        known = add_references(known, read_references(Path(references)))
    return Scorer(known, with_custom(groups))


def fault(path: Path, error: Exception) -> Problem:
    """The problem of a submission whose checks stopped with an unforeseen error."""
    last = traceback.extract_tb(error.__traceback__)[-1]
    message = f"The scorer stopped with {type(error).__name__} in {Path(last.filename).name}, {last.name}."
    hint = "This is a mistake of gym-extensions, whatever the folder contains: please report it."
    return Problem("fault-of-the-scorer", escape(path.name), message, hint)


def _in_order(
    folders: Sequence[Path], scorer: Callable[[Path], Scorecard], workers: int | None
) -> Iterator[Scorecard]:
    count = min(workers or (os.cpu_count() or 1) + EXTRA_WORKERS, len(folders))
    if count < 2 or (workers is None and len(folders) < MIN_PARALLEL):
        yield from map(scorer, folders)
        return
    with ProcessPoolExecutor(count) as pool:
        remaining = iter(folders)
        queue = deque(pool.submit(scorer, path) for path in islice(remaining, count * QUEUED_PER_WORKER))
        while queue:
            card = queue.popleft().result()
            queue.extend(pool.submit(scorer, path) for path in islice(remaining, 1))
            yield card


def scorecards(
    folders: Sequence[Path],
    scorer: Scorer,
    workers: int | None = None,
    verify: bool = False,
    evidence: Evidence | None = None,
) -> Iterator[Scorecard]:
    """The scorecards of the folders in their order, whatever the number of worker processes.

    Args:
        folders: one submission each.
        scorer: scores each of them.
        workers: number of processes; None chooses it.
        verify: also replay the recorded episodes, which loads the simulator.
        evidence: what else is checked; by default nothing.
    """
    cards = _in_order(folders, scorer, workers)
    checks = evidence or Evidence(verify)
    if not checks.is_needed:
        return cards
    return (
        with_evidence(card, path, checks, scorer.groups) for card, path in zip(cards, folders, strict=True)
    )


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
    return ReferencesInfo(references.version, references.provisional, references.digest)


def scorecard_document(cards: Sequence[Scorecard], references: References) -> ScorecardDocument:
    """The document of these scorecards."""
    return ScorecardDocument(references=references_info(references), submissions=tuple(cards))


def score_folders(
    paths: Sequence[Path],
    references: References | None = None,
    verify: bool = False,
    groups: Mapping[str, TaskGroup] = GROUPS,
) -> ScorecardDocument:
    """The scorecards of all submissions in the folders, sorted by name.

    Args:
        paths: submissions, or folders of submissions.
        references: floors and ceilings; the current benchmark version's where None.
        verify: also replay the recorded episodes, which loads the simulator.
        groups: the groups that a submission may contain, by name.

    Raises:
        BenchError: a path does not exist, or two submissions have the same name.
    """
    references = load_references() if references is None else references
    cards = scorecards(find_submissions(paths), Scorer(references, groups), verify=verify)
    return scorecard_document(tuple(cards), references)


def score_folder(
    path: str | Path, references: References | None = None, groups: Mapping[str, TaskGroup] = GROUPS
) -> Scorecard:
    """The scorecard of the one submission in a folder."""
    return Scorer(load_references() if references is None else references, groups)(Path(path))
