"""Runs jobs where no file system is shared: files go to the jobs, and come back when a job has finished."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from gym_extensions.baselines.execution.failures import Failure, failure_of
from gym_extensions.baselines.execution.job_files import Files, RemoteJob, store_files
from gym_extensions.baselines.training.events import Listener
from gym_extensions.baselines.training.progress import FinishedStage
from gym_extensions.baselines.training.runner import PendingJob

Submit = Callable[[Sequence[RemoteJob], Listener], Iterator[tuple[int, Files | Failure]]]
"""Runs jobs anywhere and yields each index with the job's files or its failure."""


@dataclass(frozen=True)
class Remote:
    """An executor of training jobs that share no file system with this process.

    Args:
        submit: runs the jobs.
        slots: number of jobs that run at the same time.
    """

    submit: Submit
    slots: int

    def run(
        self, pending: Sequence[PendingJob], listen: Listener
    ) -> Iterator[tuple[int, list[FinishedStage] | Failure]]:
        """Yields each index with the job's stages, whose files are in place, or its failure."""
        if not pending:
            return
        jobs = [RemoteJob.of(each) for each in pending]
        for index, outcome in self.submit(jobs, listen):
            result: list[FinishedStage] | Failure
            if isinstance(outcome, Failure):
                result = outcome
            else:
                try:
                    result = store_files(pending[index].out, pending[index].job, outcome)
                except OSError as error:
                    result = failure_of(error, in_this_process=True)
            yield index, result
