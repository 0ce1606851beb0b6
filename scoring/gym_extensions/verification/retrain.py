"""Trains one drawn run of a submission again, and compares it with the log. For agents of this project alone.

A stranger's agent is code of a stranger: a maintainer trains it by hand in a container.
"""

import hashlib
import os
import shutil
import tempfile
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from msgspec.structs import asdict, replace as replaced
from threadpoolctl import threadpool_info, threadpool_limits

from gym_extensions.baselines import Parallel, algorithms, train
from gym_extensions.baselines.submission import commit_of, run_versions
from gym_extensions.envs.rollout import Outcome
from gym_extensions.errors import BenchError, working
from gym_extensions.metrics.statistics import holm, subtract, summary, zero_mean_p
from gym_extensions.submissions.layout import MANIFEST
from gym_extensions.submissions.log import log_of, read_log
from gym_extensions.submissions.run import RunDocument
from gym_extensions.submissions.submission import Submission
from gym_extensions.verification.logged_run import LoggedRun, differing, logged_runs
from gym_extensions.verification.verify import Report
from gym_extensions.versions import blas_kernels, processor, version_or_none

Cells = dict[tuple[int, int], list[Outcome]]


class Reproduction(NamedTuple):
    """Whether a run that was trained again has the same episodes, else how many of its cells differ by more
    than evaluation noise."""

    is_same: bool
    differing: int
    cells: int


def retrained(submission: Submission, report: Report) -> Report:
    """The report after one drawn run was trained again.

    A run is reproduced if its episodes are the same; if it was made elsewhere, with other versions or on
    another machine, also if all means agree. Means that differ though it was made on a machine like this one
    refute the submission. Anything else neither raises nor lowers the level.
    """
    record = report.verification
    if record is None or not record.passed:
        return report
    name = drawn_run(record.runs, record.value)
    run = logged_runs(submission)[name]
    with working(f"training {name} of {submission.name} again"):
        result, elsewhere = train_again(run), made_elsewhere(run.document)
    if result.is_same or (elsewhere and not result.differing):
        kind = "the same episodes" if result.is_same else f"all {result.cells} means within noise"
        record = replaced(record, retrained=[name])
        return replace(report, verification=record, retraining=f"{name}: {kind}")
    if not result.differing:
        text = f"{name}: NOT the same episodes, on a machine and versions that should give the same bytes"
        text += f"; all {result.cells} means are within noise; not reproduced"
        return replace(report, retraining=text)
    text = f"{name}: {result.differing} of {result.cells} means differ after training again"
    if elsewhere:
        return replace(report, retraining=f"{text}; made elsewhere ({elsewhere}), which refutes nothing")
    record = replaced(record, passed=False, difference=text)
    return replace(report, verification=record, retraining=text)


def drawn_run(names: Iterable[str], value: str) -> str:
    """The run whose SHA-256 of ``<value>/<name>`` is lowest."""
    return min(names, key=lambda name: hashlib.sha256(f"{value}/{name}".encode()).digest())


def reference_agent(submission: Submission) -> str:
    """The agent of this project that trained a submission, after its libraries were loaded.

    Raises ``BenchError`` if there is none, the training was not recorded, or the extra of the agent is
    missing.
    """
    assert submission.manifest is not None, "it has no problems"
    name, where = submission.manifest.protocol.algorithm, str(submission.path / MANIFEST)
    if submission.manifest.reported:
        hint = "Verify without --retrain."
        raise BenchError("not-reproducible", "A printed table has no training to repeat.", where, hint)
    if name not in algorithms.names():
        hint = "Train the submission's own agent by hand."
        raise BenchError("not-reproducible", f"The algorithm {name!r} is not a reference agent.", where, hint)
    if not all(each.steps_counted for each in submission.documents.values()):
        message = "It has policies that were trained elsewhere, so its training cannot be repeated."
        raise BenchError("not-reproducible", message, str(submission.path), "Verify without --retrain.")
    algorithms.factory(name)
    return name


def train_again(run: LoggedRun) -> Reproduction:
    """Trains a run again in a temporary folder and compares it with the log.

    The last bits of large matrix products depend on the number of threads, which no document states: workers
    (``train --jobs``) have one, a process alone has all. The second is tried if the first differs.

    Raises:
        BenchError: the agent is none of this project, is another one today, or has other settings.
    """
    reference_agent(run.submission)  # loads its libraries before their threads are limited
    all_threads = max((each["num_threads"] for each in threadpool_info()), default=1)
    results = []
    for threads in dict.fromkeys((1, all_threads)):
        with tempfile.TemporaryDirectory(prefix="gym-extensions-") as scratch, threadpool_limits(threads):
            rows = read_log(retrain(run, Path(scratch) / "again"))
        log = log_of({run.document.run: rows}, run.log.protocol, run.log.group)
        result = compare_cells(run.logged, replace(run, log=log).logged)
        if result.is_same:
            return result
        results.append(result)
    return min(results, key=lambda result: result.differing)


def retrain(run: LoggedRun, out: Path) -> Path:
    """Trains a run again into the new submission ``out``, and returns the path of its log.

    Evaluations during training are not repeated: they change no result, because these agents can be saved.

    Raises ``BenchError`` if the agent is another one today, or has other settings.
    """
    agent, manifest = reference_agent(run.submission), run.submission.manifest
    assert manifest is not None, "it has no problems"
    what = run.log.group, run.log.protocol, manifest.protocol.budget, run.document.run
    num_envs: Any = manifest.hyperparameters.get("num_envs")
    path = run.submission.path / MANIFEST
    out.mkdir()
    shutil.copyfile(path, out / MANIFEST)  # with it in place, another agent or setting is refused
    try:
        (made,) = train(agent, *what, out=out, jobs=Parallel(num_envs=num_envs), progress=False)
    except BenchError as error:
        if error.code != "mixed-submission":
            raise
        hint = "Check out the commit of the run."
        raise BenchError("not-reproducible", error.message, str(path), hint) from error
    return made


def compare_cells(logged: Cells, again: Cells) -> Reproduction:
    """Compares the episodes of a run.

    The mean returns of a cell, over its 20 episodes in each, agree unless Welch's t test with Holm's
    procedure rejects the cell at the family-wise error rate .05 over all cells of the run. A cell without
    variance in both agrees only if the means are equal; one that is missing does not agree.
    """
    if logged == again:
        return Reproduction(True, 0, len(logged))
    p_values = []
    for cell in sorted({*logged, *again}):
        if cell in logged and cell in again:
            old, new = (summary([each.return_ for each in part[cell]]) for part in (logged, again))
            p_values.append(zero_mean_p(subtract(old, new)))
        else:
            p_values.append(0.0)
    return Reproduction(False, int(holm(np.array(p_values)).sum()), len(p_values))


def made_elsewhere(document: RunDocument) -> str:
    """What differs between the training of a run and this process; empty if the bytes must be the same.

    Training depends on more than the actions of stored policies do: on the code of the agent and its
    packages, on the processor's mathematical functions, and on the number of threads.
    """
    here, made = run_versions([blas_kernels()]), document.machine
    pairs: dict[str, tuple[object, object]] = {
        **{name: (getattr(document.versions, name), now) for name, now in asdict(here).items()},
        "processor": (made and made.processor, processor()),
        "cores": (made and made.cores, os.cpu_count() or 1),
        **{name: (stated, version_or_none(name)) for name, stated in document.packages.items()},
    }
    if ".dev" in here.gym_extensions:  # the number of an unreleased version stands for many commits
        pairs["commit"] = document.commit, commit_of(Path.cwd()) or "unknown"
    return differing(pairs)
