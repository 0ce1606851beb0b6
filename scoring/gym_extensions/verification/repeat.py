"""Whether the outcomes of stored policies are those of the log, to the last bit."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from gym_extensions.catalog.protocol import EVALUATION_EPISODES, evaluation_seed
from gym_extensions.envs.rollout import Outcome
from gym_extensions.rollouts.onnx_policy import RUNTIME
from gym_extensions.rollouts.run import Versions
from gym_extensions.rollouts.tables import Log
from gym_extensions.verification.episodes import Cell, Played
from gym_extensions.versions import blas_kernels, version, version_or_none

SUCCESSES = {1: True, 0: False, -1: None}
TOLERANCE = 1e-3
"""Relative difference of returns up to which an episode of an ONNX network counts as repeated."""


@dataclass(frozen=True)
class Repetition:
    """How many of a run's episodes were repeated, and where the first other one is and how large it is."""

    repeated: int
    episodes: int
    difference: str = ""


def logged_cells(log: Log, run: int) -> dict[tuple[int, int], list[Outcome]]:
    """The logged outcomes of a run by stage and index of the task, sorted as in the log."""
    cells: dict[tuple[int, int], list[Outcome]] = {}
    for row in np.flatnonzero(log.run == run).tolist():
        outcome = Outcome(
            int(log.length[row]),
            float(log.return_[row]),
            bool(log.terminated[row]),
            SUCCESSES[int(log.success[row])],
        )
        cells.setdefault((int(log.stage[row]), int(log.position[row])), []).append(outcome)
    return cells


def prescribed_cell(log: Log, stage: int, task: int) -> Cell:
    """A cell with the prescribed seeds."""
    group = log.group
    ids = range(EVALUATION_EPISODES)
    seeds = tuple(evaluation_seed(group.id, group.task_ids[task], each) for each in ids)
    return Cell(stage, task, seeds)


def repetition(log: Log, run: int, cells: tuple[Cell, ...], result: Played) -> Repetition:
    """Compares the outcomes of a run with its log.

    Args:
        log: the logs of the run's group and protocol.
        run: the run.
        cells: the cells that were repeated.
        result: their outcomes, or why there are none.
    """
    logged = logged_cells(log, run)
    is_same = _is_close if result.runtime else Outcome.__eq__
    total = sum(len(logged[cell.stage, cell.task]) for cell in cells)
    if result.problem:
        return Repetition(0, total, result.problem)
    repeated, difference = 0, ""
    for cell, outcomes in zip(cells, result.outcomes, strict=True):
        for episode, (old, new) in enumerate(zip(logged[cell.stage, cell.task], outcomes, strict=True)):
            if is_same(old, new):
                repeated += 1
            elif not difference:
                where = f"stage {cell.stage}, {log.group.tasks[cell.task].name}, episode {episode}"
                difference = f"{where}: {_described(old)} in the log, {_described(new)} here"
                difference += f" (difference {new.return_ - old.return_:.3g})"
    return Repetition(repeated, total, difference)


def _is_close(old: Outcome, new: Outcome) -> bool:
    """Whether two episodes of an ONNX network agree: all but the return is equal, and that nearly."""
    bound = TOLERANCE * max(1.0, abs(old.return_))
    return old._replace(return_=new.return_) == new and abs(old.return_ - new.return_) <= bound


def _described(outcome: Outcome) -> str:
    success = "" if outcome.success is None else f", success {str(outcome.success).lower()}"
    end = "terminated" if outcome.terminated else "truncated"
    return f"return {outcome.return_!r}, {end} after {outcome.length} steps{success}"


def this_machine() -> dict[str, str]:
    """What the last bits of actions depend on, of this process, by the names of a run's versions.

    The engine is the published one everywhere. Other kernels of the BLAS, another numpy or processor give
    other last bits, which grow within an episode.
    """
    name = f"{platform.system()}-{platform.machine()}"
    return {"blas": blas_kernels(), "numpy": version("numpy"), "platform": name}


def other_machine(
    made: Versions, here: Mapping[str, str], packages: Mapping[str, str] = MappingProxyType({})
) -> str:
    """How the machine of a run and this one differ, so that honest episodes may; empty if they do not.

    ``packages`` are those of the run, which has onnxruntime among them if its policies are networks.
    """
    pairs = {name: (getattr(made, name), value) for name, value in here.items()}
    if RUNTIME in packages:
        pairs[RUNTIME] = (packages[RUNTIME], version_or_none(RUNTIME) or "")
    differing = {name: pair for name, pair in pairs.items() if pair[0] != pair[1]}
    return ", ".join(f"{name} {stated or 'unknown'} / {value}" for name, (stated, value) in differing.items())
