"""Is it true? Replays the audit sample of a submission, and says what trust it earns.

Loads a simulator; it is imported when replay is asked for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

from gym_extensions.rollouts.folder import scan, submission_folders
from gym_extensions.rollouts.problem import Problem, summarize
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.trace_reader import RecordedEpisode, read_trace, trace_requests
from gym_extensions.scoring.replay.segments import replay
from gym_extensions.scoring.scorecard.build import WELL_FORMED

NO_TRACES = "It holds no traces: nothing could be replayed."


@dataclass(frozen=True)
class Verification:
    """What replay found: ``replayed`` of ``episodes`` logged episodes, and every problem."""

    replayed: int
    episodes: int
    problems: tuple[Problem, ...]

    @property
    def level(self) -> str | None:
        """The level of trust that it earns, or None with a problem; without traces it is as it was."""
        if self.problems:
            return None
        if not self.replayed:
            return WELL_FORMED
        every = self.replayed == self.episodes
        return (
            "replayed (all)" if every else f"replayed (sample: {self.replayed} of {self.episodes} episodes)"
        )


def _by_task(episode: RecordedEpisode) -> str:
    return episode.task.id


def verify(path: Path) -> Verification:
    """Replays the audit sample of a well-formed submission; one with problems is given back with them.

    Traces are optional: a submission without any is replayed in no episode, and has no problem.
    """
    submission = read(path)
    if submission.problems:
        return Verification(0, 0, submission.problems)
    folder = scan(path)
    logs = [log for entry in submission.groups.values() for log in entry.logs.values()]
    episodes = sum(len(log.run) for log in logs)
    if not any("/traces/" in path for path in folder.files):
        return Verification(0, episodes, ())
    found: list[RecordedEpisode] = []
    problems: list[Problem] = []
    for log in logs:
        for request in trace_requests(log, folder.read(log.path)):
            episode = read_trace(folder, request)
            if isinstance(episode, Problem):
                problems.append(episode)
            else:
                found.append(episode)
    for task_id, members in groupby(sorted(found, key=_by_task), key=_by_task):
        episodes_of_task = list(members)
        task = episodes_of_task[0].task
        if task.id != task_id:
            raise ValueError("episodes are not sorted by task")
        problems += replay(task, episodes_of_task)
    return Verification(len(found), episodes, tuple(problems))


def verified(document: dict[str, Any], folders: Sequence[Path]) -> dict[str, Any]:
    """The scorecards of these folders with the trust that replay gives, or with the problems found."""
    cards = []
    for path, card in zip(submission_folders(list(folders)), document["submissions"], strict=True):
        if card["problems"]:
            cards.append(card)
            continue
        found = verify(path)
        problems = [problem.as_dict() for problem in summarize(found.problems, card["name"])]
        notes = [] if problems or found.replayed else [NO_TRACES]
        cards.append(
            card
            | {"trust": found.level, "problems": problems, "notes": [*card["notes"], *notes]}
            | ({"groups": {}, "suites": {}} if problems else {})
        )
    return document | {"submissions": cards}
