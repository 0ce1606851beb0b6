"""Rules about what a log says was measured: cells, lengths, returns, fingerprints."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gym_extensions.catalog.bodies import UNBOUNDED
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.problem import Finding, told
from gym_extensions.rollouts.reading.evaluation_log import KINDS, Cells, Log
from gym_extensions.rollouts.rules.rule import rule


@rule("cells")
def bad_cell(cells: Cells) -> Iterator[Finding]:
    """Every cell is of its column's kind: whole numbers, numbers with a point, true or false."""
    for name, column in cells.columns.items():
        if name in KINDS:
            good, kind = KINDS[name]
            wrong = [index for index, cell in enumerate(column) if not good(cell)]

            def say(index: int, name: str = name, column: list[str] = column) -> str:
                return f"The {name} is {column[index][:40]!r}."

            yield from told(cells.path, wrong, say, f"Write {kind}.", cells.numbers)


def _where(mask: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> list[int]:
    return [int(index) for index in np.flatnonzero(mask)]


@rule("log")
def not_finite(log: Log) -> Iterator[Finding]:
    """Every return is a finite number: an episode whose return is NaN or infinite was not measured."""
    rows = _where(~np.isfinite(log.return_))
    hint = "Find what the policy or the sum did there; the row cannot be scored."
    yield from told(log.path, rows, lambda index: f"The return is {log.return_[index]}.", hint, log.numbers)


@rule("log")
def impossible_length(log: Log) -> Iterator[Finding]:
    """An episode has from one step to the task's time limit."""
    limit = log.max_steps
    rows = _where((limit > 0) & ((log.length < 1) | (log.length > limit)))
    say = "The length is {}; the task's episodes have 1 to {} steps.".format
    hint = "Count the steps from the reset to the end of the episode."
    yield from told(log.path, rows, lambda index: say(log.length[index], limit[index]), hint, log.numbers)


@rule("log")
def unfinished_episode(log: Log) -> Iterator[Finding]:
    """An episode that the task did not end runs to the time limit."""
    limit = log.max_steps
    rows = _where(~log.terminated & (log.length >= 1) & (log.length < limit))
    say = "The episode stops after {} of {} steps and terminated is false.".format
    hint = "Evaluate every episode to its end; write terminated = true where the task ended it."
    yield from told(log.path, rows, lambda index: say(log.length[index], limit[index]), hint, log.numbers)


@rule("log")
def impossible_end(log: Log) -> Iterator[Finding]:
    """terminated is true only in tasks that can end an episode; the time limit does not count as an end."""
    never = np.array([*(not task.body.rewards.terminates for task in log.group.tasks), False])
    rows = _where(log.terminated & never[log.position])
    hint = "Write terminated = false where the time limit ended the episode."
    yield from told(
        log.path, rows, lambda index: f"{log.task[index]} never ends an episode by itself.", hint, log.numbers
    )


@rule("log")
def impossible_return(log: Log) -> Iterator[Finding]:
    """A return lies within what the task can give in that many steps (scoring/bounds.py)."""
    bounds = [*(task.body.rewards for task in log.group.tasks), UNBOUNDED]
    low, high, end = (
        np.array([getattr(row, name) for row in bounds])[log.position] for name in ("low", "high", "end")
    )
    steps = np.maximum(log.length, 1)
    least, most = low * steps, high * steps + np.where(log.terminated, end, 0.0)
    judged = np.isfinite(log.return_) & (log.length >= 1)
    rows = _where(judged & ((log.return_ < least) | (log.return_ > most)))

    def say(index: int) -> str:
        span = f"{steps[index]} steps of this task give from {least[index]:g} to {most[index]:g}"
        return f"The return is {float(log.return_[index])!r}; {span}."

    yield from told(log.path, rows, say, "Write the undiscounted, unscaled sum of the rewards.", log.numbers)


@rule("keys")
def foreign_fingerprint(log: Log) -> Iterator[Finding]:
    """The fingerprint of every row is the published one of its task: other physics is another benchmark."""
    published: dict[str, str] = {}
    for name in log.group.task_ids:
        try:
            published[name] = fingerprint_of(name)
        except BenchError as unpublished:
            yield Finding(
                log.path, f"{name} has no published fingerprint: {unpublished.message}", unpublished.hint
            )
    pairs = set(zip(log.task, log.fingerprint, strict=True))
    wrong = {pair for pair in pairs if pair[0] in published and published[pair[0]] != pair[1]}
    if not wrong:
        return
    rows = [index for index, pair in enumerate(zip(log.task, log.fingerprint, strict=True)) if pair in wrong]

    def say(index: int) -> str:
        task = log.task[index]
        return f"The fingerprint is {log.fingerprint[index][:40]!r}; {task} has {published[task]!r}."

    hint = "Evaluate in this benchmark's environments, with the pinned versions of gymnasium and mujoco."
    yield from told(log.path, rows, say, hint, log.numbers)


def fingerprint_of(task_id: str) -> str:
    """The published fingerprint of a task."""
    from gym_extensions.catalog.fingerprints import published

    return str(published(task_id))
