"""Trains one drawn run of an entry again, and compares it with the log. For agents of this project alone.

A stranger's agent is code of a stranger: a maintainer trains it by hand in a container.
"""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec
import numpy as np

from gym_extensions.baselines.train_agent import retrain
from gym_extensions.envs.rollout import Outcome
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.tables import log_of, read_log
from gym_extensions.scoring.statistics import holm, summary, two_sided_p, welch
from gym_extensions.verification.repeat import logged_cells, other_machine, this_machine
from gym_extensions.verification.verify import Report, Run, runs_of

ALPHA = 0.05
"""Family-wise error rate over the cells of a run."""
Cells = dict[tuple[int, int], list[Outcome]]


@dataclass(frozen=True)
class Comparison:
    """Whether a run that was trained again has the same episodes, or how many of its cells differ."""

    is_same: bool
    differing: int = 0
    cells: int = 0

    @property
    def agrees(self) -> bool:
        """Whether the episodes are the same, or all mean returns agree within evaluation noise."""
        return self.differing == 0


def drawn_run(names: Iterable[str], value: str) -> str:
    """The run whose SHA-256 of ``<value>/<name>`` is lowest."""
    return min(names, key=lambda name: hashlib.sha256(f"{value}/{name}".encode()).digest())


def compare_cells(logged: Cells, again: Cells) -> Comparison:
    """Compares the episodes of a run.

    The mean returns of a cell, over its 20 episodes in each, agree unless Welch's t test with Holm's
    procedure rejects the cell at the family-wise error rate .05 over all cells of the run. A cell without
    variance in both agrees only if the means are equal; one that is missing does not agree.
    """
    if logged == again:
        return Comparison(True, 0, len(logged))
    keys = sorted({*logged, *again})
    p_values = np.array([_p_value(logged.get(key, []), again.get(key, [])) for key in keys])
    return Comparison(False, int(holm(p_values, ALPHA).sum()), len(keys))


def _p_value(first: list[Outcome], second: list[Outcome]) -> float:
    if not first or not second:
        return 0.0
    t, df = welch([summary([each.return_ for each in part]) for part in (first, second)])
    return float(two_sided_p(t, df)[0])


def train_again(entry: Path, run: Run) -> Comparison:
    """Trains a run again in a temporary folder and compares it with the log.

    Raises:
        BenchError: the agent is none of this project, is another one today, or has other settings.
    """
    log = run.log
    with tempfile.TemporaryDirectory(prefix="gym-extensions-") as scratch:
        path = retrain(entry, log.group, log.protocol, run.number, Path(scratch) / "again", progress=False)
        again = log_of({run.number: read_log(path)}, log.protocol, log.group)
    return compare_cells(logged_cells(log, run.number), logged_cells(again, run.number))


def retrained(entry: Path, report: Report) -> Report:
    """The report after one drawn run was trained again.

    A run that agrees is reproduced. One that differs on a machine of the same kind refutes the entry; with
    other versions or kernels it is another run of the agent, which refutes nothing.
    """
    found = report.verification
    if found is None or not found.passed:
        return report
    name = drawn_run(found.runs, found.value)
    run = runs_of(read(entry, merge_runs=False))[name]
    result = train_again(entry, run)
    machine = other_machine(run.document.versions, this_machine())
    if result.agrees:
        kind = "the same episodes" if result.is_same else f"all {result.cells} means within noise"
        verification = msgspec.structs.replace(found, retrained=[name])
        return replace(report, verification=verification, retraining=f"{name}: {kind}")
    text = f"{name}: {result.differing} of {result.cells} means differ after training again"
    if machine:
        return replace(report, retraining=f"{text}; made elsewhere ({machine}), which refutes nothing")
    verification = msgspec.structs.replace(found, passed=False, difference=text)
    return replace(report, verification=verification, retraining=text)
