"""A recorded episode as a submission holds it: the log's row and its trace, read without trust."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.registry import TASKS
from gym_extensions.catalog.task import Task
from gym_extensions.rollouts.audit import audit_sample
from gym_extensions.rollouts.folder import Folder
from gym_extensions.rollouts.layout import trace_name
from gym_extensions.rollouts.problem import Problem, shown
from gym_extensions.rollouts.reading.evaluation_log import Log
from gym_extensions.rollouts.safe_npz import read

Array = NDArray[np.float64]
STATE = "state_"


@dataclass(frozen=True)
class Recorded:
    """One episode that is to be replayed.

    ``actions`` (L, …) float32; ``returns`` (S,) the claimed sum of rewards of each segment of K steps;
    ``states`` by name, (S − 1, …): the state one step before each segment but the first.
    """

    where: str
    task: Task
    seed: int
    length: int
    terminated: bool
    actions: NDArray[np.float32]
    returns: Array
    states: dict[str, Array]

    @property
    def segment_steps(self) -> int:
        """K."""
        return self.task.body.segments.steps


@dataclass(frozen=True)
class Row:
    """The log's row of an episode, and where its trace lies."""

    path: str
    task: Task
    seed: int
    length: int
    return_: float
    terminated: bool


def rows(log: Log, data: bytes) -> Iterator[Row]:
    """The rows that the log's own digest chooses for the audit sample."""
    tasks = {task.id: task for task in log.group.tasks}
    index = {key: position for position, key in enumerate(log.cell)}
    for one in audit_sample(log.protocol, data, log.runs, log.group.tasks):
        at = index[one.run, one.stage, one.task, one.episode]
        name = trace_name(log.protocol, one.run, one.stage, tasks[one.task].name, one.episode)
        yield Row(
            f"{log.group.name}/traces/{name}",
            TASKS[one.task],
            int(log.seed[at]),
            int(log.length[at]),
            float(log.return_[at]),
            bool(log.terminated[at]),
        )


def recorded(folder: Folder, row: Row) -> Recorded | Problem:
    """The episode with its trace, or what is wrong with the trace."""
    if not folder.has(row.path):
        hint = "Put the traces that docs/rollout-log.md asks for beside the log."
        return Problem("trace-missing", row.path, "The audit sample asks for this trace.", hint)
    try:
        arrays = read(folder.read(row.path))
    except OSError:
        arrays = None
    fault = "It cannot be read." if arrays is None else _fault(arrays, row)
    if arrays is None or fault:
        return Problem("trace-malformed", row.path, fault, "Record it as docs/rollout-log.md says.")
    states = {name.removeprefix(STATE): values for name, values in arrays.items() if name.startswith(STATE)}
    facts = (row.path, row.task, row.seed, row.length, row.terminated)
    return Recorded(*facts, arrays["actions"], arrays["segment_returns"], states)


def _sum(returns: list[float]) -> float:
    try:
        return math.fsum(returns)
    except OverflowError:
        return math.inf


def _fault(arrays: dict[str, NDArray[np.generic]], row: Row) -> str:
    """The first thing that is wrong with a trace's arrays, as a sentence, or nothing."""
    return next(_faults(arrays, row), "")


def _faults(arrays: dict[str, NDArray[np.generic]], row: Row) -> Iterator[str]:
    steps, tolerance = row.task.body.segments.steps, row.task.body.segments.tolerance
    count = -(-row.length // steps)
    expected: dict[str, tuple[type[np.generic], int]] = {
        "actions": (np.float32, row.length),
        "segment_returns": (np.float64, count),
    }
    missing = [name for name in (*expected, "segment_steps") if name not in arrays]
    if missing:
        yield f"It lacks {missing[0]!r}."
        return
    if arrays["segment_steps"].tolist() != steps:
        told = shown(arrays["segment_steps"].tolist())
        yield f"Its segments have {told} steps, those of {row.task.base} have {steps}."
    expected |= {name: (np.float64, count - 1) for name in arrays if name.startswith(STATE)}
    for name, (kind, entries) in expected.items():
        found = arrays[name]
        flat = name != "segment_returns" or found.ndim == 1
        if found.dtype != kind or found.shape[:1] != (entries,) or not flat:
            belongs = f"{entries} {'rows' if flat else 'numbers'} of {np.dtype(kind)} belong there"
            yield f"{shown(name)} is {found.dtype} of shape {shown(found.shape)}; {belongs}."
        elif not np.isfinite(found).all():
            yield f"{shown(name)} holds a value that is not finite."
    for name in sorted(set(arrays) - set(expected) - {"segment_steps"}):
        yield f"It holds an unknown array {shown(name)}."
    total = _sum(arrays["segment_returns"].tolist())
    if not abs(total - row.return_) <= tolerance * max(1.0, abs(row.return_)):
        yield f"Its segments' returns sum to {total!r}, the log's row says {row.return_!r}."
