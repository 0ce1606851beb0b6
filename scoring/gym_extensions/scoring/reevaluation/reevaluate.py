"""Evaluates the policies of a submission on new seeds and compares the returns with the log."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from statistics import fmean

import numpy as np

from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.envs.fingerprint import require_published_engine
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.auditing.salt import require_salt
from gym_extensions.rollouts.auditing.submission_digest import submission_digest
from gym_extensions.rollouts.folder import Folder, scan
from gym_extensions.rollouts.policies import Policy
from gym_extensions.rollouts.problem import Problem
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.submission import SubmittedGroup
from gym_extensions.scoring.reevaluation.cells import Cell, cells_of
from gym_extensions.scoring.reevaluation.comparison import TaskReturns, compare
from gym_extensions.scoring.reevaluation.seeds import new_seed, new_seeds
from gym_extensions.scoring.replay.policy_episodes import Environments
from gym_extensions.scoring.replay.policy_files import has_policies
from gym_extensions.scoring.replay.silence import no_log_file
from gym_extensions.scoring.scorecard.model import FreshCell, FreshScore

REEVALUATION_DIFFERS, POLICY_FAILS = "reevaluation-differs", "policy-fails"
HINTS = {
    REEVALUATION_DIFFERS: "Log the first evaluation of every policy, and store that policy.",
    POLICY_FAILS: "Store the policy that was evaluated.",
}
"""By rule."""


@dataclass(frozen=True)
class Reevaluation:
    """The result of an evaluation on new seeds.

    Args:
        digest: the digest of the submission, from which the seeds follow.
        salt: the salt, from which they follow too.
        scores: the returns by group id and protocol.
        p_value: of the test that the logged returns are not higher; None without policies.
        is_complete: whether the submission has the policies of all its logs.
        problems: why it is refused; empty otherwise.
    """

    digest: str = ""
    salt: str = ""
    scores: Mapping[str, Mapping[str, FreshScore]] = field(default_factory=dict)
    p_value: float | None = None
    is_complete: bool = False
    problems: tuple[Problem, ...] = ()

    @property
    def cells(self) -> int:
        """Number of cells that were evaluated."""
        return sum(len(score.cells) for scores in self.scores.values() for score in scores.values())


def reevaluate(submission: Path, salt: str, groups: Mapping[str, TaskGroup] = GROUPS) -> Reevaluation:
    """Evaluates the policies behind the cells R[T][j], R[j][j] and S[j] of every run on 20 new seeds each.

    The seeds follow from the digest of the submission and the salt. Policies are evaluated in numpy; nothing
    of the submission is executed. The logged numbers remain those of the board.

    Args:
        submission: the submission's folder.
        salt: 64 hexadecimal digits that were fixed after the submission.
        groups: the groups that it may contain, by name.

    Raises:
        BenchError: the salt is not 64 hexadecimal digits, or another version of MuJoCo or Gymnasium is
            installed.
    """
    require_salt(salt)
    content = read(submission, groups)
    if content.problems:
        return Reevaluation(salt=salt, problems=content.problems)
    folder, digest = scan(submission, groups), submission_digest(submission)
    logs = [log for group in content.groups.values() for log in group.logs.values()]
    with_policies = [has_policies(log, folder) for log in logs]
    if not any(with_policies):
        return Reevaluation(digest, salt)
    require_published_engine()
    evaluation = _Evaluation(folder, digest, salt)
    with no_log_file():
        for group in content.groups.values():
            evaluation.add(group)
    comparison = compare(evaluation.tasks, np.random.default_rng(new_seed(digest, salt, "permutations")))
    scores = evaluation.scores()
    problems = tuple(evaluation.problems)
    if not problems and not comparison.agrees:
        cells = [
            cell for protocols in scores.values() for score in protocols.values() for cell in score.cells
        ]
        logged, fresh = (fmean(getattr(cell, name) for cell in cells) for name in ("logged", "fresh"))
        message = (
            f"The logged returns are higher than those of the policies on new seeds: mean {logged:.1f} in "
            f"the log and {fresh:.1f} on new seeds over {len(cells)} cells, p = {comparison.p_value:.2g}."
        )
        problems = (Problem(REEVALUATION_DIFFERS, folder.name, message, HINTS[REEVALUATION_DIFFERS]),)
    return Reevaluation(digest, salt, scores, comparison.p_value, all(with_policies), problems)


class _Evaluation:
    """Collects the returns of the cells of all groups."""

    def __init__(self, folder: Folder, digest: str, salt: str) -> None:
        self._folder, self._digest, self._salt = folder, digest, salt
        self._runs: dict[tuple[str, str, int], int] = {}
        self._cells: dict[tuple[str, str], list[FreshCell]] = defaultdict(list)
        self.tasks: list[TaskReturns] = []
        self.problems: list[Problem] = []

    def add(self, submitted: SubmittedGroup) -> None:
        """Evaluates the cells of a group, task by task."""
        cells = list(cells_of(submitted, self._folder))
        for index in range(len(submitted.group.tasks)):
            self._add_task(submitted.group, index, [cell for cell in cells if cell.task_index == index])

    def _add_task(self, group: TaskGroup, index: int, cells: Sequence[Cell]) -> None:
        if not cells:
            return
        task, rows = group.tasks[index], []
        environments = Environments(task, index, new_seeds(self._digest, self._salt, group.id, task.id))
        try:
            for cell in cells:
                names = (group.id, cell.protocol, cell.run, cell.stage, task.id)
                rng = np.random.default_rng(new_seed(self._digest, self._salt, *names))
                policy = Policy.from_bytes(self._folder.read(cell.policy))
                rows.append([episode.return_ for episode in environments.episodes(policy, rng)])
                means = float(np.mean(cell.logged)), fmean(rows[-1])
                fresh_cell = FreshCell(cell.run, cell.stage, task.id, *means)
                self._cells[group.id, cell.protocol].append(fresh_cell)
        except BenchError as error:
            problem = Problem(POLICY_FAILS, cell.policy, error.message, HINTS[POLICY_FAILS])
            self.problems.append(problem)
            return
        finally:
            environments.close()
        runs = [self._run_index(group.id, cell) for cell in cells]
        self.tasks.append(TaskReturns(runs, np.stack([cell.logged for cell in cells]), np.array(rows)))

    def _run_index(self, group_id: str, cell: Cell) -> int:
        return self._runs.setdefault((group_id, cell.protocol, cell.run), len(self._runs))

    def scores(self) -> dict[str, dict[str, FreshScore]]:
        """The returns by group id and protocol."""
        scores: dict[str, dict[str, FreshScore]] = {}
        for (group_id, protocol), cells in self._cells.items():
            ordered = tuple(sorted(cells, key=lambda cell: (cell.run, cell.stage)))
            logged, fresh = (fmean(getattr(cell, name) for cell in ordered) for name in ("logged", "fresh"))
            scores.setdefault(group_id, {})[protocol] = FreshScore(logged, fresh, ordered)
        return scores
