"""Pieces of work side by side in processes of one thread each; or one by one in this process."""

from __future__ import annotations

import multiprocessing
import os
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from multiprocessing.queues import Queue
from queue import Empty
from typing import Any, Protocol, TypeVar

from gym_extensions.baselines.training.runner import Listener, News

ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
"""Libraries read these when a process loads them."""
LISTEN_SECONDS = 0.2
LAST_NEWS_SECONDS = 0.5

Result_co = TypeVar("Result_co", covariant=True)
Result = TypeVar("Result")


class Work(Protocol[Result_co]):
    """What can be run anywhere: it pickles."""

    def run(self, listen: Listener) -> Result_co:
        """Does it all, telling how far it is."""


def run_all(waiting: Sequence[Work[Result]], jobs: int, listen: Listener) -> Iterator[tuple[int, Result]]:
    """The index and the result of each piece, as they finish; the first failure ends all.

    Args:
        waiting: the pieces, longest first where it matters.
        jobs: processes side by side; 0 runs the pieces in order in this process.
        listen: told how far each is.
    """
    if not jobs:
        for index, work in enumerate(waiting):
            yield index, work.run(listen)
        return
    if not waiting:
        return
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    context = multiprocessing.get_context("spawn")
    news: Queue[News] = context.Queue()
    pool = ProcessPoolExecutor(
        min(jobs, len(waiting)), mp_context=context, initializer=_prepare, initargs=(news,)
    )
    try:
        futures = {pool.submit(_run, work): index for index, work in enumerate(waiting)}
        yield from _as_they_finish(futures, news, listen)
        pool.shutdown()
    except BaseException:
        workers = multiprocessing.active_children()
        pool.shutdown(wait=False, cancel_futures=True)
        for process in workers:
            process.terminate()
        raise


def _as_they_finish(
    futures: dict[Future[Result], int], news: Queue[News], listen: Listener
) -> Iterator[tuple[int, Result]]:
    running = set(futures)
    while running:
        done, running = wait(running, timeout=LISTEN_SECONDS, return_when=FIRST_COMPLETED)
        # A worker hands its last news on in a thread of its own, a moment after its result.
        _tell(news, listen, 0.0 if running else LAST_NEWS_SECONDS)
        for future in done:
            yield futures[future], future.result()


def _tell(news: Queue[News], listen: Listener, patience: float) -> None:
    while True:
        try:
            listen(news.get(timeout=patience) if patience else news.get_nowait())
        except Empty:
            return


_news: Queue[News] | None = None


def _prepare(news: Queue[News]) -> None:
    global _news  # noqa: PLW0603  (a pool hands its initializer's arguments on in no other way)
    _news = news
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """Ends this process when the one that started it is gone, however that ended."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _run(work: Work[Any]) -> Any:
    queue = _news
    return work.run(lambda told: None if queue is None else queue.put(told))
