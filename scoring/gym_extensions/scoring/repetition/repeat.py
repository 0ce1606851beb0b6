"""Repeats the episodes of a run with its policies and compares them with the log."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, evaluation_seed
from gym_extensions.envs.fingerprint import require_published_engine
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.folder import scan
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


class Repeater:
    """Repeats runs of one submission; environments are kept until a run of another group.

    The policies are evaluated in numpy from the prescribed seeds, 20 episodes of a cell side by side as in
    the recorder. Length, return, termination and success of every episode must be those of its row, to the
    last bit. An honest log differs on a machine whose BLAS kernels or maths library give other last bits.

    Args:
        path: the submission's folder.
        groups: the groups that it may contain, by name.

    Raises:
        BenchError: as :func:`read_submission`; or another version of MuJoCo or Gymnasium is installed.
    """

    def __init__(self, path: Path, groups: Mapping[str, TaskGroup]) -> None:
        require_published_engine()
        self._folder = scan(path, groups)
        logs = [log for group in read_submission(path, groups).groups.values() for log in group.logs.values()]
        self._logs = {
            RunKey(log.group.id, log.protocol, run): log
            for log in logs
            if has_policies(log, self._folder)
            for run in log.runs
        }
        self._environments: dict[int, Environments] = {}
        self._group = ""

    @property
    def keys(self) -> list[RunKey]:
        """The runs with policies, group by group."""
        return list(self._logs)

    def __call__(self, key: RunKey) -> Repetition:
        """Repeats a run up to the first cell that differs."""
        if key.group != self._group:
            self.close()
            self._group = key.group
        log = self._logs[key]
        rows = (log.run == key.run).nonzero()[0].tolist()
        for start in range(0, len(rows), EVALUATION_EPISODES):
            difference = self._difference(log, rows[start : start + EVALUATION_EPISODES], key.run)
            if difference:
                return Repetition(key, len(rows), difference)
        return Repetition(key, len(rows))

    def close(self) -> None:
        """Closes the environments."""
        while self._environments:
            self._environments.popitem()[1].close()

    def _difference(self, log: Log, cell: list[int], run: int) -> str:
        """A sentence on the first episode of a cell that is another than its row, or nothing."""
        group, stage, index = log.group, int(log.stage[cell[0]]), int(log.position[cell[0]])
        task = group.tasks[index]
        if index not in self._environments:
            seeds = [evaluation_seed(group.id, task.id, each) for each in range(EVALUATION_EPISODES)]
            self._environments[index] = Environments(task, index, seeds)
        where = f"stage {stage}, {task.name}"
        try:
            policy = Policy.from_bytes(self._folder.read(policy_path(log, run, stage, index)))
            with no_log_file():
                outcomes = self._environments[index].episodes(policy)
        except BenchError as error:
            return f"{where}: {error.message}"
        for row, outcome in zip(cell, outcomes, strict=True):
            logged = _logged(log, row)
            if outcome != logged:
                episode = f"{where}, episode {int(log.episode[row])}"
                return f"{episode}: {_describe(logged)} in the log, {_describe(outcome)} here."
        return ""


def _logged(log: Log, row: int) -> Outcome:
    success = SUCCESSES[int(log.success[row])]
    return Outcome(int(log.length[row]), float(log.return_[row]), bool(log.terminated[row]), success)


def _describe(outcome: Outcome) -> str:
    success = "" if outcome.success is None else f", success {outcome.success}"
    return f"return {outcome.return_!r} in {outcome.length} steps{success}"
