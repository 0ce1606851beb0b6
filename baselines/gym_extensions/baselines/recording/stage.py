"""The stage of a protocol that a recorded policy belongs to."""

from __future__ import annotations

from gym_extensions.baselines.recording.curves import task_named
from gym_extensions.baselines.training.jobs import TrainingJob
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.errors import BenchError


def parse_stage(
    group: TaskGroup, protocol: str, run: int, stage: int | None, task: str | None
) -> tuple[TrainingJob, int]:
    """The job and the number of the stage that the arguments of ``record`` name.

    Raises:
        BenchError: the stage is missing, out of range or not an integer, the task is missing or unknown, or
            an argument belongs to another protocol.
    """
    if protocol == "sequential":
        _require_no_task(task, "Each stage is evaluated on every task; leave task out.")
        return TrainingJob(group, protocol, run), _sequential_stage(group, stage)
    if stage not in (None, 1):
        message = f"Stage {stage!r} is out of range: the protocol {protocol} has stage 1 only."
        raise BenchError("bad-stage", message, "stage", "Leave stage out.")
    if protocol == "joint":
        _require_no_task(task, "A joint policy is trained on every task; leave task out.")
        return TrainingJob(group, protocol, run), 1
    if task is None:
        hint = "Name the task that the policy was trained on."
        raise BenchError("bad-task", "The protocol single needs a task.", "task", hint)
    return TrainingJob(group, protocol, run, group.tasks.index(task_named(task, group.tasks))), 1


def _sequential_stage(group: TaskGroup, stage: object) -> int:
    last = len(group.tasks)
    if isinstance(stage, bool) or not isinstance(stage, int) or not 0 <= stage <= last:
        message = (
            "The protocol sequential needs a stage." if stage is None else f"Stage {stage!r} is out of range."
        )
        hint = f"Use the number of tasks of {group.name} that the policy was trained on, 0 to {last}."
        raise BenchError("bad-stage", message, "stage", hint)
    return stage


def _require_no_task(task: str | None, hint: str) -> None:
    if task is not None:
        raise BenchError("bad-task", f"Unexpected task {task!r}.", "task", hint)
