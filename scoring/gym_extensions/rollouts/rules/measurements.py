"""Rules about the measured cells of a log, which are lengths, returns, terminations and fingerprints."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.bodies import UNBOUNDED
from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.registry import TASKS
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.problem import Finding, row_findings
from gym_extensions.rollouts.reading.evaluation_log import KINDS, Cells, Log
from gym_extensions.rollouts.rules.rule import rule

MAX_CELL_QUOTE = 40


def _rows(mask: NDArray[np.bool_]) -> list[int]:
    return [int(index) for index in np.flatnonzero(mask)]


@rule("cells")
def bad_cell(cells: Cells) -> Iterator[Finding]:
    """Every cell is of its column's kind: an integer, a number, or true or false."""
    for name, column in cells.columns.items():
        if name in KINDS:
            is_valid, kind = KINDS[name]
            rows = [index for index, cell in enumerate(column) if not is_valid(cell)]

            def message(index: int, name: str = name, kind: str = kind) -> str:
                return f"Column `{name}` is {cells.columns[name][index][:MAX_CELL_QUOTE]!r}; expected {kind}."

            yield from row_findings(cells.path, rows, message, f"Write {kind}.", cells.numbers)


@rule("log")
def not_finite(log: Log) -> Iterator[Finding]:
    """Every return is a finite number."""

    def message(index: int) -> str:
        return f"Column `return` is {log.return_[index]}; expected a finite number."

    hint = "Find the cause in the policy or in the sum of rewards; such an episode cannot be scored."
    yield from row_findings(log.path, _rows(~np.isfinite(log.return_)), message, hint, log.numbers)


@rule("log")
def impossible_length(log: Log) -> Iterator[Finding]:
    """The length of an episode is 1 to the task's time limit."""
    limit = log.max_steps

    def message(index: int) -> str:
        return f"Column `length` is {log.length[index]}; expected 1 to {limit[index]} steps."

    hint = "Count the steps from the reset to the end of the episode."
    rows = _rows((limit > 0) & ((log.length < 1) | (log.length > limit)))
    yield from row_findings(log.path, rows, message, hint, log.numbers)


@rule("log")
def unfinished_episode(log: Log) -> Iterator[Finding]:
    """An episode that the task does not terminate runs to the time limit."""
    limit = log.max_steps

    def message(index: int) -> str:
        return (
            f"The episode ends after {log.length[index]} of {limit[index]} steps, but `terminated` is false."
        )

    hint = "Evaluate every episode to its end; write true in `terminated` if the task ended it."
    rows = _rows(~log.terminated & (log.length >= 1) & (log.length < limit))
    yield from row_findings(log.path, rows, message, hint, log.numbers)


@rule("log")
def impossible_end(log: Log) -> Iterator[Finding]:
    """`terminated` is true only in tasks that can terminate; reaching the time limit is not termination."""
    never = np.array([*(not task.body.rewards.terminates for task in log.group.tasks), False])

    def message(index: int) -> str:
        return f"Column `terminated` is true, but {log.task[index]} never terminates."

    hint = "Write false in `terminated` if the time limit ended the episode."
    rows = _rows(log.terminated & never[log.position])
    yield from row_findings(log.path, rows, message, hint, log.numbers)


@rule("log")
def impossible_return(log: Log) -> Iterator[Finding]:
    """A return is within the bounds of the task's rewards over the episode's steps (catalog/bodies)."""
    bounds = [*(task.body.rewards for task in log.group.tasks), UNBOUNDED]
    low, high, end = (
        np.array([getattr(row, name) for row in bounds])[log.position] for name in ("low", "high", "end")
    )
    steps = np.maximum(log.length, 1)
    lower, upper = low * steps, high * steps + np.where(log.terminated, end, 0.0)
    is_comparable = np.isfinite(log.return_) & (log.length >= 1)

    def message(index: int) -> str:
        expected = f"{lower[index]:g} to {upper[index]:g} in {steps[index]} steps of this task"
        return f"Column `return` is {float(log.return_[index])!r}; expected {expected}."

    hint = "Write the undiscounted, unscaled sum of the rewards."
    rows = _rows(is_comparable & ((log.return_ < lower) | (log.return_ > upper)))
    yield from row_findings(log.path, rows, message, hint, log.numbers)


@rule("keys")
def foreign_fingerprint(log: Log) -> Iterator[Finding]:
    """The fingerprint of every row is the published one of its task. A custom task has one fingerprint."""
    pairs = list(zip(log.task, log.fingerprint, strict=True))
    fingerprints = {} if log.group.published else dict(reversed(pairs))
    for task in log.group.tasks:
        if TASKS.get(task.id) != task:
            continue
        try:
            fingerprints[task.id] = published(task.id)
        except BenchError as error:
            yield Finding(log.path, f"{task.id} has no published fingerprint: {error.message}", error.hint)
    wrong = {(task, digest) for task, digest in set(pairs) if fingerprints.get(task, digest) != digest}
    rows = [index for index, pair in enumerate(pairs) if pair in wrong] if wrong else []

    def message(index: int) -> str:
        task, digest = pairs[index]
        actual = repr(digest[:MAX_CELL_QUOTE])
        return f"Column `fingerprint` is {actual}; expected {fingerprints[task]!r} for {task}."

    hint = "Evaluate in this benchmark's environments, with the pinned versions of gymnasium and mujoco."
    yield from row_findings(log.path, rows, message, hint, log.numbers)
