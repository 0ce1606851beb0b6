"""Writes events as TensorBoard scalars. It needs the extra ``log``."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from gym_extensions.baselines.training.events import (
    BatchTrained,
    Event,
    JobFailed,
    JobFinished,
    TaskEvaluated,
)
from gym_extensions.errors import BenchError

FOLDER = "tensorboard"
LOG_HINT = "Install it with: pip install 'gym-extensions[log]'"


def require_tensorboard() -> None:
    """Raises ``BenchError`` if the package tensorboard is missing."""
    try:
        import tensorboard.summary.writer.event_file_writer  # noqa: F401
    except ModuleNotFoundError as missing:
        message = f"The log 'tensorboard' needs {missing.name}."
        raise BenchError("missing-extra", message, "log", LOG_HINT) from missing


class TensorBoard:
    """One folder of scalars per job, ``tensorboard/<group>/<job>``, over the training steps of the job.

    The scalars are ``train/mean_return``, ``train/steps_per_second`` and, per task,
    ``evaluation/<task name>``.
    """

    def __init__(self, folder: Path, now: Callable[[], float] = time.time) -> None:
        require_tensorboard()
        self._folder, self._now = folder / FOLDER, now
        self._writers: dict[str, Any] = {}

    def __call__(self, event: Event) -> None:
        """Adds the scalars of a batch or an evaluated task."""
        if isinstance(event, BatchTrained):
            scalars = {"train/steps_per_second": event.steps_per_second}
            if event.mean_return is not None:
                scalars["train/mean_return"] = event.mean_return
            self._add(event.job, event.job_step, scalars)
        elif isinstance(event, TaskEvaluated):
            name = event.task.rpartition("/")[2]
            self._add(event.job, event.job_step, {f"evaluation/{name}": event.mean_return})
        elif isinstance(event, JobFinished | JobFailed) and event.job in self._writers:
            self._writers.pop(event.job).close()

    def close(self) -> None:
        """Writes what is not yet written."""
        for writer in self._writers.values():
            writer.close()
        self._writers.clear()

    def _add(self, job: str, step: int, scalars: dict[str, float]) -> None:
        from tensorboard.compat.proto import event_pb2, summary_pb2
        from tensorboard.summary.writer.event_file_writer import EventFileWriter

        if job not in self._writers:
            self._writers[job] = EventFileWriter(str(self._folder.joinpath(*job.split())), flush_secs=10)
        values = [summary_pb2.Summary.Value(tag=tag, simple_value=value) for tag, value in scalars.items()]
        summary = summary_pb2.Summary(value=values)
        self._writers[job].add_event(event_pb2.Event(wall_time=self._now(), step=step, summary=summary))
