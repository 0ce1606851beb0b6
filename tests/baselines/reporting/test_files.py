"""The log file, events.csv and TensorBoard have what the events say."""

from __future__ import annotations

import csv
import re

import pytest

from gym_extensions.baselines.training.events import BatchTrained, TaskEvaluated

from ..conftest import SHORT_GROUP, Watched

JOBS = (f"{SHORT_GROUP} sequential-run0", f"{SHORT_GROUP} joint-run0")


def test_the_log_file_has_a_line_per_event_with_its_time(watched: Watched) -> None:
    lines = (watched.folder / ".progress/train.log").read_text().splitlines()
    assert len(lines) == len(watched.events)
    assert [line for line in lines if not re.match(r"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d \w", line)] == []
    assert lines[-1].endswith(f"{JOBS[1]}: finished")
    assert sum("steps per second, time left 0:" in line for line in lines) == 4 + 4 + 8


def test_the_csv_file_has_a_row_per_batch_and_evaluation(watched: Watched) -> None:
    with (watched.folder / ".progress/events.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    expected = [
        ("batch", event.job, event.stage, event.step, event.job_step, event.mean_return)
        if isinstance(event, BatchTrained)
        else ("evaluation", event.job, event.stage, event.step, event.job_step, event.mean_return)
        for event in watched.events
        if isinstance(event, BatchTrained | TaskEvaluated)
    ]
    assert [
        (
            *(row["event"], row["job"], int(row["stage"]), int(row["step"]), int(row["job_step"])),
            float(row["mean_return"]) if row["mean_return"] else None,
        )
        for row in rows
    ] == expected


def test_tensorboard_reads_the_scalars_of_each_job(watched: Watched) -> None:
    loader = pytest.importorskip("tensorboard.backend.event_processing.event_file_loader")
    folder = watched.folder / ".progress/tensorboard"
    for job in JOBS:
        (path,) = folder.joinpath(*job.split()).glob("events.out.tfevents.*")
        scalars = [
            (value.tag, event.step, value.tensor.float_val[0])
            for event in loader.EventFileLoader(str(path)).Load()
            for value in event.summary.value
        ]
        batches = [event for event in watched.events if isinstance(event, BatchTrained) and event.job == job]
        returns = [(step, value) for tag, step, value in scalars if tag == "train/mean_return"]
        assert returns == [(event.job_step, pytest.approx(event.mean_return)) for event in batches]
        tags = {tag for tag, _, _ in scalars}
        assert tags == {
            *("train/mean_return", "train/steps_per_second"),
            *("evaluation/Pusher-v0", "evaluation/PusherMovingGoal-v0"),
        }


def test_the_training_curve_is_on_disk_while_the_stage_trains(watched: Watched) -> None:
    assert watched.points_on_disk[:4] == [1, 2, 3, 4]
    assert len(watched.points_on_disk) == 16
