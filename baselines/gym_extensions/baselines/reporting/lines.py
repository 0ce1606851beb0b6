"""Events as lines of text."""

from __future__ import annotations

from gym_extensions.baselines.reporting.time_left import clock_time
from gym_extensions.baselines.training.events import (
    BatchTrained,
    Event,
    JobFailed,
    JobFinished,
    StageStarted,
    TrainingStarted,
)


def line(event: Event, seconds_left: float | None) -> str:
    """One line about an event.

    Args:
        event: the event.
        seconds_left: until all jobs are finished; None if unknown.
    """
    if isinstance(event, TrainingStarted):
        return _plan_line(event)
    if isinstance(event, JobFinished):
        return f"{event.job}: finished"
    if isinstance(event, JobFailed):
        return f"{event.job}: failed: {event.cause}"
    where = f"{event.job} stage {event.stage}"
    if isinstance(event, StageStarted):
        tasks = ", ".join(event.tasks) if event.tasks else "no task"
        return f"{where}: trains {event.steps:,} steps on {tasks}"
    if isinstance(event, BatchTrained):
        return f"{where}: {event.step:,} steps, {batch_text(event)}, time left {clock_time(seconds_left)}"
    during = f" after {event.step:,} steps" if event.in_training else ""
    return f"{where}{during}: {event.task} mean return {event.mean_return:.1f}"


def batch_text(event: BatchTrained) -> str:
    """The training return and speed of a batch."""
    mean_return = "no episode ended" if event.mean_return is None else f"mean return {event.mean_return:.1f}"
    return f"{mean_return}, {event.steps_per_second:,.0f} steps per second"


def _plan_line(event: TrainingStarted) -> str:
    if not event.jobs:
        return "Nothing to train: all runs are finished."
    stages = [stage for job in event.jobs for stage in job.stages]
    steps, episodes = sum(stage.steps for stage in stages), sum(stage.episodes for stage in stages)
    jobs = "1 job" if len(event.jobs) == 1 else f"{len(event.jobs)} jobs"
    return f"{jobs}: {steps:,} training steps, {episodes:,} evaluation episodes"
