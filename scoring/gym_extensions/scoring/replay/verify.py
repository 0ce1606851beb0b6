"""Replays the audit sample of a submission and returns its level of trust. Loads a simulator."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path

from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.envs.fingerprint import require_published_engine
from gym_extensions.rollouts.folder import scan
from gym_extensions.rollouts.policies import Policy
from gym_extensions.rollouts.problem import Problem, summarize
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.trace_reader import RecordedEpisode, read_trace, trace_requests
from gym_extensions.scoring.replay.segments import replay
from gym_extensions.scoring.scorecard.model import REPORTED, VALIDATED, Scorecard

NO_TRACES = "It holds no traces: nothing could be replayed."


@dataclass(frozen=True)
class Verification:
    """The result of a replay, with the number of replayed and logged episodes and every problem."""

    replayed: int
    episodes: int
    problems: tuple[Problem, ...]

    @property
    def level(self) -> str | None:
        """The level of trust, or None with a problem. It is ``validated`` without traces."""
        if self.problems:
            return None
        if not self.replayed:
            return VALIDATED
        if self.replayed == self.episodes:
            return "replayed (all)"
        return f"replayed (sample: {self.replayed} of {self.episodes} episodes)"


def _task_id(episode: RecordedEpisode) -> str:
    return episode.task.id


def verify(path: Path, groups: Mapping[str, TaskGroup] = GROUPS) -> Verification:
    """Replays the audit sample of a submission; one with problems is not replayed.

    Where the submission has the policy of an episode's stage, the recorded actions are compared with it.
    Traces are optional: without any, nothing is replayed and there is no problem.

    Raises:
        BenchError: there are traces, and another version of MuJoCo or Gymnasium is installed.
    """
    submission = read(path, groups)
    if submission.problems:
        return Verification(0, 0, submission.problems)
    folder = scan(path, groups)
    logs = [log for entry in submission.groups.values() for log in entry.logs.values()]
    logged = sum(len(log.run) for log in logs)
    if not any("/traces/" in name for name in folder.files):
        return Verification(0, logged, ())
    require_published_engine()
    episodes: list[RecordedEpisode] = []
    problems: list[Problem] = []
    policies = functools.cache(lambda path: Policy.from_bytes(folder.read(path)))
    for log in logs:
        for request in trace_requests(log, folder.read(log.path), folder.files):
            trace = read_trace(folder, request)
            if isinstance(trace, Problem):
                problems.append(trace)
            else:
                policy = policies(request.policy) if request.policy in folder.files else None
                episodes.append(replace(trace, policy=policy))
    for _, group in groupby(sorted(episodes, key=_task_id), key=_task_id):
        episodes_of_task = list(group)
        problems += replay(episodes_of_task[0].task, episodes_of_task)
    return Verification(len(episodes), logged, tuple(problems))


def verified(card: Scorecard, path: Path, groups: Mapping[str, TaskGroup] = GROUPS) -> Scorecard:
    """The scorecard with the trust that replay gives or with the problems that it finds.

    A submission with problems and a reported one are returned unchanged.

    Args:
        card: the scorecard of the submission.
        path: the submission's folder.
        groups: the groups that it may contain, by name.
    """
    if card.problems or card.trust == REPORTED:
        return card
    verification = verify(path, groups)
    problems = tuple(summarize(verification.problems, card.name))
    if problems:
        return replace(card, trust=None, problems=problems, groups={}, suites={})
    notes = card.notes if verification.replayed else (*card.notes, NO_TRACES)
    return replace(card, trust=verification.level, notes=notes)
