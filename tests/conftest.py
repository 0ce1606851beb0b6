"""One BLAS thread for every test, and a submission made up by formula, that tests read, break and score.

The number of BLAS threads can change the last bit of a matrix product, so it is set before numpy is loaded.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"

import hashlib
import shutil
from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from gym_extensions.catalog.budgets import BUDGETS
from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.groups import TaskGroup, group
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, FULL_ENTRY_RUNS, PROTOCOLS, evaluation_seed
from gym_extensions.rollouts.auditing.digests import DIGITS, merkle_root
from gym_extensions.rollouts.auditing.sample import audit_sample
from gym_extensions.rollouts.episodes import CurvePoint, Episode, write_curves, write_episodes
from gym_extensions.rollouts.layout import trace_name
from gym_extensions.rollouts.safe_npz import npz_bytes
from gym_extensions.scoring.references import Reference, References

from .scheduler import Scheduler, worker_group

if TYPE_CHECKING:
    from xdist.remote import Producer


def pytest_addoption(parser: pytest.Parser) -> None:
    """Adds ``--no-skips``: a skipped test is a failure, so that CI cannot lose a test unnoticed."""
    parser.addoption("--no-skips", action="store_true", help="a skipped test is a failure")


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Producer) -> Scheduler:
    """Distributes the tests by group and file if ``-n`` is given."""
    return Scheduler(config, log)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Puts the groups first: they are long, and at the end of a run one worker would wait for the other."""
    items.sort(key=lambda item: worker_group(item.nodeid) is None)


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    """Fails the session if ``--no-skips`` is given and a test or module was skipped; ``-ra`` lists them."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if session.config.getoption("--no-skips") and reporter is not None and reporter.stats.get("skipped"):
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


MANIFEST = """format = 1
title = "An entry"
authors = ["A. Nonymous"]
description = "Made up by a formula."

[code]
url = ""
commit = ""

[protocol]
budget = "smoke"
algorithm = "formula"
evaluation = "sampled"

[hyperparameters]
step = 0.01

[observes]
task_in_training = false
task_in_evaluation = false
boundaries = false

[tuning]
steps = 0
tasks = []

[memory]
stored_steps = 2000
parameters_first = 100
parameters_last = 100

[versions]
gym_extensions = "1.0.0"
gymnasium = "1.4.0"
mujoco = "4.0.0"
numpy = "2.4.6"
python = "3.11.7"
platform = "Linux-x86_64"
"""

Value = Callable[[str, int, int, int, int], float]
"""The return of an episode: a function of protocol, run, stage, task's position from 1, episode."""


def formula(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
    """Returns that differ in every row and lie within what Hopper can give in 1000 steps."""
    return 100.0 * stage + 10.0 * position + run + episode / 8 + (0.5 if protocol == "single" else 0.0)


def write_submission(
    root: Path,
    *,
    name: str = "entry",
    groups: tuple[str, ...] = ("hopper-gravity",),
    runs: tuple[int, ...] = (0, 1),
    protocols: tuple[str, ...] = ("sequential", "single"),
    value: Value = formula,
    curves: int = 0,
    manifest: str = MANIFEST,
    traces: bool | None = None,
) -> Path:
    """Writes a complete submission and gives its folder.

    ``curves`` is the number of points of each curve. ``traces`` commits to made-up traces and writes those of
    the audit sample, which a rank needs; by default with five or more runs.
    """
    folder = root / name
    folder.mkdir(parents=True, exist_ok=True)
    is_bound = len(runs) >= FULL_ENTRY_RUNS if traces is None else traces
    digests: list[str] = []
    for group_name in sorted(groups):
        members = group(group_name)
        for protocol in sorted(protocols, key=PROTOCOLS.index):
            stages = range(len(members.tasks) + 1) if protocol == "sequential" else (1,)
            rows = [
                Episode(
                    run=run,
                    stage=stage,
                    task=task.id,
                    episode=episode,
                    seed=evaluation_seed(members.id, task.id, episode),
                    length=task.max_steps,
                    return_=float(value(protocol, run, stage, position, episode)),
                    terminated=False,
                    success=None if task.body.success is None else False,
                    fingerprint=published(task.id),
                    trace=made_up_digest(protocol, run, stage, task.id, episode) if is_bound else "",
                )
                for run, stage, (position, task), episode in product(
                    runs, stages, enumerate(members.tasks, 1), range(EVALUATION_EPISODES)
                )
            ]
            log = folder / group_name / f"{protocol}.csv"
            write_episodes(log, rows, members.task_ids)
            if is_bound:
                digests += [row.trace for row in rows]
                write_sample(log, members, runs)
        if curves:
            steps = BUDGETS["smoke"].steps_for(group_name)
            points = [
                CurvePoint(
                    protocol, run, task, steps * point // curves, float(value(protocol, run, 1, 1, point))
                )
                for protocol, run, task, point in product(
                    protocols, runs, members.task_ids, range(1, curves + 1)
                )
            ]
            write_curves(folder / group_name / "curves.csv", points, members.task_ids)
    if is_bound:
        manifest += f'\n[traces]\nroot = "{merkle_root(digests)}"\n'
    (folder / "submission.toml").write_text(manifest, encoding="utf-8", newline="\n")
    return folder


def made_up_digest(*key: object) -> str:
    """A digest that no trace has."""
    return hashlib.sha256(repr(key).encode()).hexdigest()[:DIGITS]


def write_sample(log: Path, members: TaskGroup, runs: tuple[int, ...]) -> None:
    """Writes a file for every trace of a log's audit sample, all with the same content: links are quick."""
    folder = log.with_name("traces")
    folder.mkdir(exist_ok=True)
    names = {task.id: task.name for task in members.tasks}
    first: Path | None = None
    for row in audit_sample(log.stem, log.read_bytes(), runs, members.tasks):
        path = folder / trace_name(log.stem, row.run, row.stage, names[row.task], row.episode)
        path.unlink(missing_ok=True)
        if first is None:
            first = path
            path.write_bytes(npz_bytes({"actions": np.zeros((1, 1), np.float32)}))
        else:
            os.link(first, path)


@pytest.fixture
def submission(tmp_path: Path) -> Callable[..., Path]:
    """Writes a submission below the test's folder: ``submission(name=…, runs=…, value=…)``."""

    def write(**changes: object) -> Path:
        return write_submission(tmp_path, **changes)  # type: ignore[arg-type]

    return write


@pytest.fixture(scope="session")
def good(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, Path], Path]:
    """Copies the good submission of a group, with curves, to a place: quicker than writing it anew."""
    made: dict[str, Path] = {}

    def copy(group_name: str, root: Path) -> Path:
        if group_name not in made:
            place = tmp_path_factory.mktemp("good")
            made[group_name] = write_submission(place, groups=(group_name,), curves=12)
        return Path(shutil.copytree(made[group_name], root / "entry"))

    return copy


@pytest.fixture
def writer() -> Callable[..., Path]:
    """``write_submission`` itself, for folders elsewhere."""
    return write_submission


@pytest.fixture
def manifest_text() -> str:
    """The submission.toml of the made-up entry."""
    return MANIFEST


@pytest.fixture(scope="session")
def references() -> References:
    """Synthetic references of the gravity groups: floor 0, ceiling 1000, so that p is R / 1000."""
    tasks = {
        task: Reference(0.0, 1000.0, False)
        for body in ("hopper", "walker2d", "halfcheetah", "humanoid")
        for task in group(f"{body}-gravity").task_ids
    }
    return References("synthetic", True, tasks, "0" * 64)


@pytest.fixture
def known(monkeypatch: pytest.MonkeyPatch, references: References) -> None:
    """Scores with the synthetic references."""
    monkeypatch.setattr("gym_extensions.scoring.references.load_references", lambda: references)
    monkeypatch.setattr("gym_extensions.scoring.pipeline.score.load_references", lambda: references)
