"""Chooses where jobs run: in this process, in worker processes, or on a Ray cluster."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Protocol

from gym_extensions.baselines.execution.failures import Failure
from gym_extensions.baselines.execution.ray_cluster import ray_cluster
from gym_extensions.baselines.execution.workers import ThisProcess, Workers
from gym_extensions.baselines.training.events import Listener
from gym_extensions.baselines.training.progress import FinishedStage
from gym_extensions.baselines.training.runner import PendingJob


class JobExecutor(Protocol):
    """Runs training jobs; ``slots`` is the number that run at the same time."""

    @property
    def slots(self) -> int: ...

    def run(
        self, pending: Sequence[PendingJob], listen: Listener
    ) -> Iterator[tuple[int, list[FinishedStage] | Failure]]:
        """Yields each index with the job's stages or its failure, in the order of finishing."""


@contextmanager
def open_executor(ray: str | None, processes: int) -> Iterator[JobExecutor]:
    """The executor of one call of ``train``.

    Args:
        ray: the address of a Ray cluster, or None.
        processes: number of worker processes without Ray; 0 is this process.
    """
    if ray is not None:
        with ray_cluster(ray) as cluster:
            yield cluster
    else:
        yield Workers(processes) if processes else ThisProcess()
