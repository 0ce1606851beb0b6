"""What is reported and stored while a stage trains: the curve on disk, events, and evaluations."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from gym_extensions.baselines.training.events import BatchTrained, Listener, TaskEvaluated
from gym_extensions.baselines.training.jobs import Interim, Stage, TrainingJob
from gym_extensions.baselines.training.recorder import Batch
from gym_extensions.catalog.task import Task
from gym_extensions.rollouts.episodes import CurvePoint, EvaluationPoint, append_curves


class StageMonitor:
    """Receives the recorder's batches of one stage.

    Args:
        job: the job.
        stage: its stage.
        job_step: training steps of the stages before.
        curve: the file to which the points of the curve are appended.
        listen: receives the events.
        interim: when to evaluate during training; None evaluates at the end of the stage only.
        evaluate: the mean return of each of several tasks, over a number of episodes per task.
    """

    def __init__(
        self,
        job: TrainingJob,
        stage: Stage,
        job_step: int,
        *,
        curve: Path,
        listen: Listener,
        interim: Interim | None,
        evaluate: Callable[[Sequence[Task], int], Iterable[float]],
    ) -> None:
        self.curves, self.evaluations = list[CurvePoint](), list[EvaluationPoint]()
        self._job, self._stage, self._job_step, self._curve = job, stage, job_step, curve
        self._listen, self._interim, self._evaluate = listen, interim, evaluate
        self._next = interim.every if interim else stage.steps

    def __call__(self, batch: Batch) -> None:
        """Appends the points to the curve, sends the events and evaluates if it is time to."""
        job, stage = self._job, self._stage
        points = [
            CurvePoint(job.protocol, job.run, point.task, point.step, point.return_) for point in batch.points
        ]
        self.curves += points
        append_curves(self._curve, points)
        speed = batch.steps / max(batch.seconds, 1e-9)
        step, job_step = batch.step, self._job_step + batch.step
        self._listen(
            BatchTrained(
                job.title, stage.number, step, job_step, batch.mean_return, speed, seconds=batch.seconds
            )
        )
        if self._interim is not None and self._next <= step < stage.steps:
            self._next = self._interim.every * (1 + step // self._interim.every)
            self._evaluate_all(step, self._interim.episodes)

    def _evaluate_all(self, step: int, episodes: int) -> None:
        job, stage = self._job, self._stage
        start = time.perf_counter()
        mean_returns = self._evaluate(stage.evaluated, episodes)
        for task, mean_return in zip(stage.evaluated, mean_returns, strict=True):
            self.evaluations.append(
                EvaluationPoint(job.protocol, job.run, stage.number, task.id, step, episodes, mean_return)
            )
            seconds, start = time.perf_counter() - start, time.perf_counter()
            where = (job.title, stage.number, step, self._job_step + step)
            self._listen(TaskEvaluated(*where, task.id, episodes, mean_return, seconds, in_training=True))
