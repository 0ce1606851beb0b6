"""Repeats the episodes of a submission with its policies and compares them with the log."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, evaluation_seed
from gym_extensions.envs.fingerprint import require_published_engine
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.folder import Folder, scan
from gym_extensions.rollouts.policies import Policy
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.reading.evaluation_log import Log
from gym_extensions.rollouts.submission import Submission
from gym_extensions.scoring.repetition.digests import RunKey
from gym_extensions.scoring.replay.policy_episodes import Environments, Outcome
from gym_extensions.scoring.replay.policy_files import has_policies, policy_path
from gym_extensions.scoring.replay.segments import SUCCESSES
from gym_extensions.scoring.replay.silence import no_log_file

SAMPLED = "sampled"


@dataclass(frozen=True)
class Repetition:
    """The repetition of a run.

    ``episodes`` is the number of its logged episodes. ``difference`` is a sentence on the first one that is
    another, empty if all are the same.
    """

    key: RunKey
    episodes: int
    difference: str = ""


def read_submission(path: Path, groups: Mapping[str, TaskGroup] = GROUPS) -> Submission:
    """The submission, every run for itself.

    Raises:
        BenchError: it has problems, or its policies sample their actions, which cannot be repeated.
    """
    submission = read(path, groups, merge_runs=False)
    if submission.problems:
        first = submission.problems[0]
        raise BenchError(first.rule, first.message, f"{path.name}: {first.where}", first.hint)
    if submission.manifest is None or submission.manifest.reported:
        raise BenchError("no-policies", "A reported entry has no policies.", path.name)
    if submission.manifest.protocol.evaluation == SAMPLED:
        message = "Its policies sample their actions, so that their episodes cannot be repeated."
        raise BenchError("sampled-actions", message, path.name, "Use `score --verify`, which replays traces.")
    return submission


def repeat(
    path: Path, done: Container[RunKey] = (), groups: Mapping[str, TaskGroup] = GROUPS
) -> Iterator[Repetition]:
    """Repeats the episodes of all runs with policies, and yields the result of each run.

    The policies are evaluated in numpy from the prescribed seeds, 20 episodes of a cell side by side as in
    the recorder. Length, return, termination and success of every episode must be those of its row, to the
    last bit. An honest log differs on a machine whose BLAS kernels or maths library give other last bits.

    Args:
        path: the submission's folder.
        done: runs to leave out.
        groups: the groups that it may contain, by name.

    Raises:
        BenchError: as :func:`read_submission`; or another version of MuJoCo or Gymnasium is installed.
    """
    submission, folder = read_submission(path, groups), scan(path, groups)
    require_published_engine()
    with no_log_file():
        for submitted in submission.groups.values():
            environments: dict[int, Environments] = {}
            try:
                for protocol, log in submitted.logs.items():
                    for run in log.runs:
                        key = RunKey(submitted.group.id, protocol, run)
                        if key not in done and has_policies(log, folder):
                            yield _repeat_run(key, log, folder, environments)
            finally:
                for env in environments.values():
                    env.close()


def _repeat_run(key: RunKey, log: Log, folder: Folder, environments: dict[int, Environments]) -> Repetition:
    """Repeats a run up to the first cell that differs. Environments are created on first use, by task."""
    group, rows = log.group, (log.run == key.run).nonzero()[0].tolist()
    for start in range(0, len(rows), EVALUATION_EPISODES):
        cell = rows[start : start + EVALUATION_EPISODES]
        stage, index = int(log.stage[cell[0]]), int(log.position[cell[0]])
        task = group.tasks[index]
        if index not in environments:
            seeds = [evaluation_seed(group.id, task.id, each) for each in range(EVALUATION_EPISODES)]
            environments[index] = Environments(task, index, seeds)
        where = f"stage {stage}, {task.name}"
        try:
            policy = Policy.from_bytes(folder.read(policy_path(log, key.run, stage, index)))
            outcomes = environments[index].episodes(policy)
        except BenchError as error:
            return Repetition(key, len(rows), f"{where}: {error.message}")
        for row, outcome in zip(cell, outcomes, strict=True):
            logged = _logged(log, row)
            if outcome != logged:
                episode = f"{where}, episode {int(log.episode[row])}"
                difference = f"{episode}: {_describe(logged)} in the log, {_describe(outcome)} here."
                return Repetition(key, len(rows), difference)
    return Repetition(key, len(rows))


def _logged(log: Log, row: int) -> Outcome:
    success = SUCCESSES[int(log.success[row])]
    return Outcome(int(log.length[row]), float(log.return_[row]), bool(log.terminated[row]), success)


def _describe(outcome: Outcome) -> str:
    success = "" if outcome.success is None else f", success {outcome.success}"
    return f"return {outcome.return_!r} in {outcome.length} steps{success}"
