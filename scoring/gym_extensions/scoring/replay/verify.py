"""Replays the audit sample of a submission and returns its level of trust. Loads a simulator."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path

from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.envs.fingerprint import require_published_engine
from gym_extensions.rollouts.auditing.salt import parse_salt
from gym_extensions.rollouts.folder import Folder, scan
from gym_extensions.rollouts.layout import MEBIBYTE, SALT_FILE, TRACES
from gym_extensions.rollouts.policies import Policy
from gym_extensions.rollouts.problem import Problem, summarize
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.trace_reader import (
    RecordedEpisode,
    TraceRequest,
    read_trace,
    requests_with_traces,
    salt_in,
)
from gym_extensions.scoring.replay.segments import replay
from gym_extensions.scoring.scorecard.model import REPORTED, VALIDATED, Scorecard

NO_TRACES = "It holds no traces: nothing could be replayed."
SOME_TRACES = "Not all of its logs have traces: the others were not replayed."
UNBOUND = "Its logs do not commit to traces: nothing could be replayed."
OTHER_SALT = "other-salt"
BATCH_BYTES = 64 * MEBIBYTE
"""Size of the traces that are in memory at a time. Those of a task of an honest entry are smaller."""
MAX_POLICIES = 64
"""Policies that are in memory at a time."""


@dataclass(frozen=True)
class Verification:
    """The result of a replay, with the number of replayed and logged episodes and every problem.

    ``is_salted`` is whether salts drew the samples of all groups, ``is_bound`` whether the logs commit to
    traces, ``is_partial`` whether a log has none although another has.
    """

    replayed: int
    episodes: int
    problems: tuple[Problem, ...]
    is_salted: bool = False
    is_bound: bool = True
    is_partial: bool = False

    @property
    def level(self) -> str | None:
        """The level of trust, or None with a problem. It is ``validated`` if a log has no traces."""
        if self.problems:
            return None
        if not self.replayed or self.is_partial:
            return VALIDATED
        if self.replayed == self.episodes:
            return "replayed (all)"
        kind = "salted sample" if self.is_salted else "unsalted sample"
        return f"replayed ({kind}: {self.replayed} of {self.episodes} episodes)"


def verify(path: Path, groups: Mapping[str, TaskGroup] = GROUPS, salt: str | None = None) -> Verification:
    """Replays the audit sample of a submission; one with problems is not replayed.

    Where the submission has the policy of an episode's stage, the recorded actions are compared with it.
    Traces are optional: runs without traces are not replayed. An entry whose sample is not complete has a
    rank only if all its episodes were repeated (``gym-extensions repeat``).

    Args:
        path: the submission's folder.
        groups: the groups that it may contain, by name.
        salt: the salt that must have drawn the sample of every group, 64 hexadecimal digits, or empty for
            none. By default each group's own (``traces/salt.txt``), or none.

    Raises:
        BenchError: the salt is not 64 hexadecimal digits; or there are traces, and another version of MuJoCo
            or Gymnasium is installed.
    """
    expected = None if salt is None else parse_salt(salt, "salt")
    submission = read(path, groups)
    if submission.problems:
        return Verification(0, 0, submission.problems)
    folder = scan(path, groups)
    logs = [log for entry in submission.groups.values() for log in entry.logs.values()]
    logged = sum(len(log.run) for log in logs)
    if not all(log.trace for log in logs):
        return Verification(0, logged, (), is_bound=False)
    if not any("/traces/" in name for name in folder.files):
        return Verification(0, logged, ())
    salts = {log.group.id: salt_in(folder, log.group.name) for log in logs}
    sampled = {log.path: requests_with_traces(log, folder, salts[log.group.id]) for log in logs}
    salts = {log.group.id: salts[log.group.id] for log in logs if sampled[log.path]}
    if problems := [
        _other_salt(submission.groups[name].group.name, actual, expected)
        for name, actual in salts.items()
        if expected not in (None, actual)
    ]:
        return Verification(0, logged, tuple(problems))
    require_published_engine()
    requests = [request for requests in sampled.values() for request in requests]
    policies = functools.lru_cache(MAX_POLICIES)(lambda path: Policy.from_bytes(folder.read(path)))
    replayed = 0
    for batch in _batches(folder, sorted(requests, key=lambda request: request.task.id), problems):
        episodes = [
            replace(episode, policy=policies(path) if path in folder.files else None)
            for episode, path in batch
        ]
        replayed += len(episodes)
        problems += replay(episodes[0].task, episodes)
    is_partial = not all(sampled.values())
    return Verification(replayed, logged, tuple(problems), all(salts.values()), is_partial=is_partial)


def _batches(
    folder: Folder, requests: Sequence[TraceRequest], problems: list[Problem]
) -> Iterator[list[tuple[RecordedEpisode, str]]]:
    """The recorded episodes of one task with the paths of their policies, about ``BATCH_BYTES`` at a time.

    Args:
        folder: the submission.
        requests: sorted by task.
        problems: takes those of the traces.
    """
    for _, group in groupby(requests, key=lambda request: request.task.id):
        batch: list[tuple[RecordedEpisode, str]] = []
        size = 0
        for request in group:
            trace = read_trace(folder, request)
            if isinstance(trace, Problem):
                problems.append(trace)
                continue
            batch.append((trace, request.policy))
            size += trace.actions.nbytes + sum(states.nbytes for states in trace.states.values())
            if size > BATCH_BYTES:
                yield batch
                batch, size = [], 0
        if batch:
            yield batch


def _other_salt(group_name: str, actual: str, expected: str | None) -> Problem:
    stated = f"The salt is {actual}" if actual else "The traces were drawn without a salt"
    hint = f"Run: gym-extensions trace FOLDER --salt {expected}" if expected else "Run gym-extensions trace."
    where = f"{group_name}/{TRACES}/{SALT_FILE}"
    return Problem(OTHER_SALT, where, f"{stated}; expected {expected or 'none'}.", hint)


def verified(
    card: Scorecard, path: Path, groups: Mapping[str, TaskGroup] = GROUPS, salt: str | None = None
) -> Scorecard:
    """The scorecard with the trust that replay gives or with the problems that it finds.

    A submission with problems and a reported one are returned unchanged.

    Args:
        card: the scorecard of the submission.
        path: the submission's folder.
        groups: the groups that it may contain, by name.
        salt: as for :func:`verify`.
    """
    if card.problems or card.trust == REPORTED:
        return card
    verification = verify(path, groups, salt)
    problems = tuple(summarize(verification.problems, card.name))
    if problems:
        return replace(card, trust=None, problems=problems, groups={}, suites={})
    reason = UNBOUND if not verification.is_bound else SOME_TRACES if verification.is_partial else NO_TRACES
    notes = card.notes if verification.level != VALIDATED else (*card.notes, reason)
    return replace(card, trust=verification.level, notes=notes)
