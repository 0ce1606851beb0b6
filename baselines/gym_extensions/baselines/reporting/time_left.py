"""Estimates the time left until all jobs are finished, from the speed measured so far."""

from __future__ import annotations

from dataclasses import dataclass, field

from gym_extensions.baselines.training.events import (
    BatchTrained,
    Event,
    JobFailed,
    JobFinished,
    JobPlan,
    StageStarted,
    TaskEvaluated,
    TrainingStarted,
)


@dataclass
class Work:
    """Amounts of work: training steps and evaluation episodes."""

    steps: int = 0
    episodes: int = 0


@dataclass
class JobProgress:
    """The position of a job: the stage that it is in, and the work done in that stage."""

    plan: JobPlan
    stage: int = -1
    done: Work = field(default_factory=Work)
    has_ended: bool = False

    def enter(self, stage: int) -> None:
        """Moves on to a stage. The stages before it are done, in this call or in an earlier one."""
        if stage != self.stage:
            self.stage, self.done = stage, Work()

    def left(self) -> Work:
        """The work of the job that is not done."""
        if self.has_ended:
            return Work()
        stages = [stage for stage in self.plan.stages if stage.number >= self.stage]
        steps = sum(stage.steps for stage in stages) - self.done.steps
        episodes = sum(stage.episodes for stage in stages) - self.done.episodes
        return Work(max(0, steps), max(0, episodes))

    @property
    def total_steps(self) -> int:
        """Training steps of all stages."""
        return sum(stage.steps for stage in self.plan.stages)


class TimeLeft:
    """Adds up events. Steps and episodes of all jobs are taken to be equally long."""

    def __init__(self) -> None:
        self.jobs: dict[str, JobProgress] = {}
        self._processes = 1
        self._done, self._training_seconds, self._evaluation_seconds = Work(), 0.0, 0.0

    def update(self, event: Event) -> None:
        """Takes an event into account."""
        if isinstance(event, TrainingStarted):
            self.jobs = {plan.title: JobProgress(plan) for plan in event.jobs}
            self._processes = max(1, event.processes)
            return
        job = self.jobs.get(event.job)
        if job is None:
            return
        if isinstance(event, JobFinished | JobFailed):
            job.has_ended = True
            return
        job.enter(event.stage)
        if isinstance(event, StageStarted):
            return
        self._done.steps += event.step - job.done.steps
        job.done.steps = event.step
        if isinstance(event, BatchTrained):
            self._training_seconds += event.seconds
        elif isinstance(event, TaskEvaluated):
            job.done.episodes += event.episodes
            self._done.episodes += event.episodes
            self._evaluation_seconds += event.seconds

    def steps_left(self) -> int:
        """Training steps of all jobs that are not done."""
        return sum(job.left().steps for job in self.jobs.values())

    def seconds(self) -> float | None:
        """Seconds until all jobs are finished; None before a kind of work that is left was measured."""
        left = [job.left() for job in self.jobs.values() if not job.has_ended]
        steps, episodes = (sum(work.steps for work in left), sum(work.episodes for work in left))
        if not self.jobs:
            return None
        if (steps and not self._done.steps) or (episodes and not (self._done.episodes or self._done.steps)):
            return None
        training = steps * self._training_seconds / max(1, self._done.steps)
        evaluation = episodes * self._evaluation_seconds / max(1, self._done.episodes)
        return (training + evaluation) / min(self._processes, max(1, len(left)))


def clock_time(seconds: float | None) -> str:
    """Hours, minutes and seconds, such as ``1:02:03``; ``unknown`` without a number."""
    if seconds is None:
        return "unknown"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02}:{rest:02}"
