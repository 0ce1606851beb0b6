"""Rules about the key columns of a log that is not complete: each prescribed episode once, and no other."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from itertools import product

from gym_extensions.catalog.protocol import EVALUATION_EPISODES, FIRST_REFERENCE_RUN, evaluation_seed, stages
from gym_extensions.catalog.registry import TASKS
from gym_extensions.errors import did_you_mean
from gym_extensions.rollouts.problem import LONGEST_QUOTE, Finding, number, shown, told
from gym_extensions.rollouts.reading.evaluation_log import Log
from gym_extensions.rollouts.rules.rule import rule


@rule("keys")
def foreign_task(log: Log) -> Iterator[Finding]:
    """Every task of a log belongs to the group in whose folder it lies."""
    members = set(log.group.task_ids)
    rows = [index for index, name in enumerate(log.task) if name not in members]

    def say(index: int) -> str:
        name = log.task[index]
        return (
            f"There is no task {shown(name)}."
            if name not in TASKS
            else f"{name} is no task of {log.group.id}."
        )

    hint = did_you_mean(log.task[rows[0]][:LONGEST_QUOTE], members) if rows else ""
    yield from told(log.path, rows, say, hint, log.numbers)


@rule("keys")
def wrong_stage(log: Log) -> Iterator[Finding]:
    """Stages go from 0 to the number of tasks in sequential.csv, and are 1 in single.csv and joint.csv."""
    allowed = stages(log.protocol, len(log.group.tasks))
    rows = [index for index, stage in enumerate(log.stage.tolist()) if stage not in allowed]
    span = f"0 to {allowed[-1]}" if len(allowed) > 1 else "1"
    hint = "The stage is the number of tasks trained so far; it is 1 (trained) in single.csv and joint.csv."
    yield from told(
        log.path,
        rows,
        lambda index: f"The stage is {log.stage[index]}; {span} is allowed.",
        hint,
        log.numbers,
    )


@rule("keys")
def wrong_episode(log: Log) -> Iterator[Finding]:
    """Episodes of a cell are numbered from 0 to 19."""
    rows = [
        index for index, episode in enumerate(log.episode.tolist()) if not 0 <= episode < EVALUATION_EPISODES
    ]
    last = EVALUATION_EPISODES - 1
    hint = f"Evaluate {EVALUATION_EPISODES} episodes a cell, numbered from 0."
    yield from told(
        log.path,
        rows,
        lambda index: f"The episode is {log.episode[index]}; 0 to {last} exist.",
        hint,
        log.numbers,
    )


@rule("keys")
def wrong_seed(log: Log) -> Iterator[Finding]:
    """Every episode starts from the prescribed seed of its group, task and number."""
    members = set(log.group.task_ids)
    needed = {
        (task, episode): evaluation_seed(log.group.id, task, episode)
        for task, episode in product(sorted(members), range(EVALUATION_EPISODES))
    }
    keys = list(zip(log.task, log.episode.tolist(), strict=True))
    rows = [index for index, key in enumerate(keys) if needed.get(key, log.seed[index]) != log.seed[index]]
    hint = "Reset with gym_extensions.catalog.protocol.evaluation_seed(group id, task id, episode)."
    say = "The seed is {}; this episode has {}.".format
    yield from told(
        log.path, rows, lambda index: say(log.seed[index], needed[keys[index]]), hint, log.numbers
    )


@rule("log")
def reserved_run(log: Log) -> Iterator[Finding]:
    """A run is a training seed from 0 to 999: those from 1000 on are for the reference agents alone."""
    bad = {run for run in log.runs if not 0 <= run < FIRST_REFERENCE_RUN}
    rows = [index for index, run in enumerate(log.run.tolist()) if run in bad] if bad else []
    hint = f"Train with seeds from 0 to {FIRST_REFERENCE_RUN - 1}."
    yield from told(log.path, rows, lambda index: f"The run is {log.run[index]}.", hint, log.numbers)


@rule("keys")
def duplicate_episode(log: Log) -> Iterator[Finding]:
    """Each episode of a run, stage and task stands in one row."""
    seen: dict[tuple[int, int, str, int], int] = {}
    again: dict[int, int] = {}
    for index, cell in enumerate(log.cell):
        if seen.setdefault(cell, index) != index:
            again[index] = seen[cell]
    hint = "Keep the one row that was measured."
    yield from told(
        log.path,
        list(again),
        lambda index: f"Row {number(again[index], log.numbers)} is the same episode.",
        hint,
        log.numbers,
    )


@rule("keys")
def missing_cell(log: Log) -> Iterator[Finding]:
    """Every run has all its cells (stage and task), each with 20 episodes: a hole is never skipped."""
    there = Counter(
        (run, stage, task)
        for run, stage, task, episode in set(log.cell)
        if 0 <= episode < EVALUATION_EPISODES
    )
    cells = list(product(stages(log.protocol, len(log.group.tasks)), log.group.task_ids))
    holes = sum(EVALUATION_EPISODES - there[(run, *cell)] for run in log.runs for cell in cells)
    if holes <= log.unread:
        return  # all may stand in rows that were told as unreadable
    read = " that can be read" if log.unread else ""
    for run in log.runs:
        lacking = [cell for cell in cells if there[(run, *cell)] < EVALUATION_EPISODES]
        for stage, task in lacking[:3]:
            count = f"{there[run, stage, task]} of {EVALUATION_EPISODES} episodes{read}"
            found = f"Run {run}, stage {stage}, {task} has {count}."
            yield Finding(log.path, found, "Finish the evaluation of this run, or leave the whole run out.")
        if len(lacking) > 3:
            found = f"Run {run} lacks episodes in {len(lacking) - 3} more cells."
            yield Finding(log.path, found, "Finish the evaluation of this run, or leave the whole run out.")


@rule("keys")
def unsorted_rows(log: Log) -> Iterator[Finding]:
    """Rows are sorted by run, stage, task in training order and episode, so that a diff can be read."""
    place = {name: index for index, name in enumerate(log.group.task_ids)}
    keys = [(run, stage, place.get(task, len(place)), episode) for run, stage, task, episode in log.cell]
    index = next((index for index in range(1, len(keys)) if keys[index] < keys[index - 1]), None)
    if index is not None:
        found = "The row comes before the row above it."
        yield Finding(
            f"{log.path}, row {number(index, log.numbers)}",
            found,
            "Sort by run, stage, task in training order, episode.",
        )
