"""The time left, from events with known durations."""

from __future__ import annotations

import pytest

from gym_extensions.baselines.reporting.time_left import TimeLeft, clock_time
from gym_extensions.baselines.training.events import (
    BatchTrained,
    Event,
    JobFinished,
    JobPlan,
    StagePlan,
    StageStarted,
    TaskEvaluated,
    TrainingStarted,
)

STAGES = (StagePlan(0, 0, 10), StagePlan(1, 100, 10), StagePlan(2, 100, 10))


def started(jobs: int, processes: int = 1) -> TrainingStarted:
    return TrainingStarted(tuple(JobPlan(f"job {i}", STAGES) for i in range(jobs)), processes)


def batch(job: str, stage: int, step: int, seconds: float) -> BatchTrained:
    return BatchTrained(job, stage, step, step, None, 1.0, seconds)


def evaluated(job: str, stage: int, step: int, seconds: float, *, in_training: bool = False) -> TaskEvaluated:
    return TaskEvaluated(job, stage, step, step, "task", 5, 0.0, seconds, in_training)


def seconds_after(*events: Event) -> float | None:
    time_left = TimeLeft()
    for event in events:
        time_left.update(event)
    return time_left.seconds()


def test_it_is_unknown_before_a_training_step_was_measured() -> None:
    assert seconds_after(started(1), evaluated("job 0", 0, 0, 1.0)) is None


def test_it_is_the_rest_of_the_steps_and_episodes_at_the_measured_speeds() -> None:
    events = (evaluated("job 0", 0, 0, 5.0), batch("job 0", 1, 50, 100.0))
    # 150 steps at 2 seconds and 20 episodes at 1 second.
    assert seconds_after(started(1), *events) == 150 * 2 + 20


def test_it_covers_all_jobs_and_divides_by_the_processes() -> None:
    first = (batch("job 0", 1, 100, 100.0), evaluated("job 0", 1, 100, 5.0))
    left = (100 + 5 + 10) + (200 + 30)
    assert seconds_after(started(2), *first) == left
    assert seconds_after(started(2, 2), *first) == left / 2
    assert seconds_after(started(2, 2), *first, JobFinished("job 0")) == 200 + 30


def test_stages_that_an_earlier_call_finished_are_not_left() -> None:
    events = (StageStarted("job 0", 2, ("task",), 100), batch("job 0", 2, 50, 50.0))
    assert seconds_after(started(1), *events) == 50


def test_an_agent_that_takes_no_steps_has_only_evaluations_left() -> None:
    events = (StageStarted("job 0", 1, ("task",), 100), evaluated("job 0", 1, 100, 5.0))
    assert seconds_after(started(1), *events) == 5 + 10


def test_nothing_is_left_at_the_end() -> None:
    assert seconds_after(started(1), batch("job 0", 2, 100, 1.0), JobFinished("job 0")) == 0


@pytest.mark.parametrize(
    ("seconds", "text"), [(None, "unknown"), (0.4, "0:00:00"), (61, "0:01:01"), (86399.9, "24:00:00")]
)
def test_a_time_is_written_in_hours_minutes_and_seconds(seconds: float | None, text: str) -> None:
    assert clock_time(seconds) == text
