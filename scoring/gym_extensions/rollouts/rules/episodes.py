"""Rules about the keys of a log, which has every prescribed episode once and no other.

They are checked only where the keys differ from the prescribed ones.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from itertools import product

from gym_extensions.catalog.protocol import EVALUATION_EPISODES, FIRST_REFERENCE_RUN, evaluation_seed, stages
from gym_extensions.catalog.registry import TASKS
from gym_extensions.errors import did_you_mean
from gym_extensions.rollouts.problem import MAX_QUOTE, Finding, quote, row_findings, row_number
from gym_extensions.rollouts.reading.evaluation_log import Log
from gym_extensions.rollouts.rules.rule import rule

CELLS_LISTED = 3
"""Incomplete cells listed per run; the rest are counted."""


@rule("keys")
def foreign_task(log: Log) -> Iterator[Finding]:
    """Every task of a log belongs to the group of its folder."""
    members = set(log.group.task_ids)
    rows = [index for index, name in enumerate(log.task) if name not in members]

    def message(index: int) -> str:
        name = log.task[index]
        return f"{name} is not a task of {log.group.id}." if name in TASKS else f"Unknown task {quote(name)}."

    hint = did_you_mean(log.task[rows[0]][:MAX_QUOTE], members) if rows else ""
    yield from row_findings(log.path, rows, message, hint, log.numbers)


@rule("keys")
def wrong_stage(log: Log) -> Iterator[Finding]:
    """Stages are 0 to the number of tasks in sequential.csv, and 1 in single.csv and joint.csv."""
    allowed = stages(log.protocol, len(log.group.tasks))
    rows = [index for index, stage in enumerate(log.stage.tolist()) if stage not in allowed]
    expected = f"0 to {allowed[-1]}" if len(allowed) > 1 else "1"

    def message(index: int) -> str:
        return f"Column `stage` is {log.stage[index]}; expected {expected}."

    hint = "The stage is the number of tasks trained so far; it is 1 (trained) in single.csv and joint.csv."
    yield from row_findings(log.path, rows, message, hint, log.numbers)


@rule("keys")
def wrong_episode(log: Log) -> Iterator[Finding]:
    """Episodes of a cell are numbered 0 to 19."""
    episodes = range(EVALUATION_EPISODES)
    rows = [index for index, episode in enumerate(log.episode.tolist()) if episode not in episodes]

    def message(index: int) -> str:
        return f"Column `episode` is {log.episode[index]}; expected 0 to {episodes[-1]}."

    hint = f"Evaluate {EVALUATION_EPISODES} episodes per cell, numbered from 0."
    yield from row_findings(log.path, rows, message, hint, log.numbers)


@rule("keys")
def wrong_seed(log: Log) -> Iterator[Finding]:
    """Every episode starts from the seed prescribed for its group, task and number."""
    members = set(log.group.task_ids)
    prescribed = {
        (task, episode): evaluation_seed(log.group.id, task, episode)
        for task, episode in product(sorted(members), range(EVALUATION_EPISODES))
    }
    keys = list(zip(log.task, log.episode.tolist(), strict=True))
    seeds = log.seed.tolist()
    rows = [index for index, key in enumerate(keys) if prescribed.get(key, seeds[index]) != seeds[index]]

    def message(index: int) -> str:
        return f"Column `seed` is {seeds[index]}; expected {prescribed[keys[index]]} for this episode."

    hint = "Reset with gym_extensions.catalog.protocol.evaluation_seed(group id, task id, episode)."
    yield from row_findings(log.path, rows, message, hint, log.numbers)


@rule("log")
def reserved_run(log: Log) -> Iterator[Finding]:
    """A run is a training seed from 0 to 999; seeds from 1000 are reserved for the reference agents."""
    allowed = range(FIRST_REFERENCE_RUN)
    reserved = {run for run in log.runs if run not in allowed}
    rows = [index for index, run in enumerate(log.run.tolist()) if run in reserved] if reserved else []

    def message(index: int) -> str:
        return f"Column `run` is {log.run[index]}; expected 0 to {allowed[-1]}."

    hint = f"Train with seeds from 0 to {allowed[-1]}."
    yield from row_findings(log.path, rows, message, hint, log.numbers)


@rule("keys")
def duplicate_episode(log: Log) -> Iterator[Finding]:
    """Each episode of a run, stage and task has one row."""
    first: dict[tuple[int, int, str, int], int] = {}
    duplicates: dict[int, int] = {}
    for index, key in enumerate(log.episode_keys):
        if first.setdefault(key, index) != index:
            duplicates[index] = first[key]

    def message(index: int) -> str:
        return f"Row {row_number(duplicates[index], log.numbers)} is the same episode."

    hint = "Keep only the row that was measured."
    yield from row_findings(log.path, list(duplicates), message, hint, log.numbers)


@rule("keys")
def missing_cell(log: Log) -> Iterator[Finding]:
    """Every run has all its cells (stage and task), each with 20 episodes."""
    counts = Counter(
        (run, stage, task)
        for run, stage, task, episode in set(log.episode_keys)
        if 0 <= episode < EVALUATION_EPISODES
    )
    cells = list(product(stages(log.protocol, len(log.group.tasks)), log.group.task_ids))
    missing = sum(EVALUATION_EPISODES - counts[(run, *cell)] for run in log.runs for cell in cells)
    if missing <= log.unread:
        return  # all of them may be in rows that are reported as unreadable
    readable = " readable" if log.unread else ""
    hint = "Finish the evaluation of this run, or leave out the whole run."
    for run in log.runs:
        incomplete = [cell for cell in cells if counts[(run, *cell)] < EVALUATION_EPISODES]
        for stage, task in incomplete[:CELLS_LISTED]:
            count = f"{counts[run, stage, task]} of {EVALUATION_EPISODES}{readable} episodes"
            yield Finding(log.path, f"Run {run}, stage {stage}, {task} has {count}.", hint)
        more = len(incomplete) - CELLS_LISTED
        if more > 0:
            message = f"Run {run} lacks episodes in {more} more cell{'s' if more > 1 else ''}."
            yield Finding(log.path, message, hint)


@rule("keys")
def unsorted_rows(log: Log) -> Iterator[Finding]:
    """Rows are sorted by run, stage, task in training order and episode."""
    order = {name: index for index, name in enumerate(log.group.task_ids)}
    keys = [
        (run, stage, order.get(task, len(order)), episode) for run, stage, task, episode in log.episode_keys
    ]
    index = next((index for index in range(1, len(keys)) if keys[index] < keys[index - 1]), None)
    if index is not None:
        where = f"{log.path}, row {row_number(index, log.numbers)}"
        hint = "Sort by run, stage, task in training order, episode."
        yield Finding(where, "The row should come before the row above it.", hint)
