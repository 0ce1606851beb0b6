"""Repeats the runs of a submission, one after another or in several processes."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from pathlib import Path

from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.errors import BenchError
from gym_extensions.scoring.repetition.digests import RunKey
from gym_extensions.scoring.repetition.repeat import Repeater, Repetition


def repeat(
    path: Path, done: Container[RunKey] = (), groups: Mapping[str, TaskGroup] = GROUPS, *, jobs: int = 1
) -> Iterator[Repetition]:
    """Repeats the episodes of all runs with policies, and yields the result of each run.

    Args:
        path: the submission's folder.
        done: runs to leave out.
        groups: the groups that it may contain, by name.
        jobs: number of processes. With more than one, runs are yielded in the order in which they end.

    Raises:
        BenchError: as :class:`Repeater`; or a worker process was ended.
    """
    repeater = Repeater(path, groups)
    keys = [key for key in repeater.keys if key not in done]
    if jobs > 1 and len(keys) > 1:
        yield from _in_processes(path, groups, keys, min(jobs, len(keys)))
        return
    try:
        yield from map(repeater, keys)
    finally:
        repeater.close()


def _in_processes(
    path: Path, groups: Mapping[str, TaskGroup], keys: list[RunKey], jobs: int
) -> Iterator[Repetition]:
    pool = ProcessPoolExecutor(jobs, get_context("spawn"), initializer=_Worker.start, initargs=(path, groups))
    try:
        for future in as_completed([pool.submit(_Worker.repeat, key) for key in keys]):
            yield future.result()
    except BrokenProcessPool:
        message = "A worker process was ended, perhaps because memory ran out."
        hint = "The runs before are recorded. Call the command again with fewer --jobs."
        raise BenchError("worker-died", message, path.name, hint) from None
    finally:
        pool.shutdown(cancel_futures=True)


class _Worker:
    """The repeater of a worker process."""

    repeater: Repeater

    @classmethod
    def start(cls, path: Path, groups: Mapping[str, TaskGroup]) -> None:
        cls.repeater = Repeater(path, groups)

    @classmethod
    def repeat(cls, key: RunKey) -> Repetition:
        return cls.repeater(key)
