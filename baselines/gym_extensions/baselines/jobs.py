"""Units side by side in processes of their own, each with one thread; or one by one in this process."""

from __future__ import annotations

import multiprocessing
import os
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import dataclass
from multiprocessing.queues import Queue
from pathlib import Path
from queue import Empty

from gym_extensions.baselines import algorithms
from gym_extensions.baselines.agent import Factory
from gym_extensions.baselines.progress import Finished
from gym_extensions.baselines.protocol import Listener, News, Settings, run_unit
from gym_extensions.baselines.units import Unit

ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
LISTEN_SECONDS = 0.2


@dataclass(frozen=True)
class Job:
    """A unit and what it takes to run it."""

    unit: Unit
    agent: str | Factory
    settings: Settings
    out: Path

    def run(self, listen: Listener) -> list[Finished]:
        """Every stage of the unit, finished."""
        make = algorithms.factory(self.agent) if isinstance(self.agent, str) else self.agent
        return run_unit(self.unit, make, self.settings, self.out, listen)


def run_all(waiting: Sequence[Job], jobs: int, listen: Listener) -> Iterator[tuple[Unit, list[Finished]]]:
    """Each unit with its finished stages, as they finish; the first failure ends it all."""
    if not jobs:
        for job in waiting:
            yield job.unit, job.run(listen)
        return
    # A process reads these when its libraries load.
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    context = multiprocessing.get_context("spawn")
    news: Queue[News] = context.Queue()
    with ProcessPoolExecutor(jobs, mp_context=context, initializer=_prepare, initargs=(news,)) as pool:
        futures = {pool.submit(_run, job): job.unit for job in waiting}
        try:
            yield from _as_they_finish(futures, news, listen)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for process in multiprocessing.active_children():
                process.terminate()
            raise


def _as_they_finish(
    futures: dict[Future[list[Finished]], Unit], news: Queue[News], listen: Listener
) -> Iterator[tuple[Unit, list[Finished]]]:
    running = set(futures)
    while running:
        done, running = wait(running, timeout=LISTEN_SECONDS, return_when=FIRST_COMPLETED)
        while True:
            try:
                listen(news.get_nowait())
            except Empty:
                break
        for future in done:
            yield futures[future], future.result()


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


def _run(job: Job) -> list[Finished]:
    queue = _news
    return job.run(lambda _: None if queue is None else queue.put(_))
