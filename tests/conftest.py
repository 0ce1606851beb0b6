"""One BLAS thread for every test, and a submission made up by formula, that tests read, break and score.

The number of BLAS threads can change the last bit of a matrix product, so it is set before numpy is loaded.
"""

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"

import importlib.util
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from itertools import product
from pathlib import Path
from types import ModuleType
from typing import Any

import msgspec
import numpy as np
import pytest

from gym_extensions.catalog import protocol as prescribed
from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.groups import SUITES, TaskGroup, group
from gym_extensions.errors import BenchError
from gym_extensions.references import Expert, Floor, Reference, References
from gym_extensions.submissions import run as documents
from gym_extensions.submissions.layout import DOCUMENT, LOG, POLICIES, run_file, run_key
from gym_extensions.submissions.log import Episode, write_log
from gym_extensions.submissions.manifest import manifest_of, parse
from gym_extensions.submissions.policies import files
from gym_extensions.submissions.policies.mlp import Policy
from gym_extensions.submissions.reader import read
from gym_extensions.submissions.review import Review, Training, Verification, training_text, write_review


@contextmanager
def refused(code: str, *facts: str, where: str | None = None) -> Iterator[None]:
    """What is done inside raises a ``BenchError`` with this code, whose text has these facts."""
    with pytest.raises(BenchError) as error:
        yield
    assert error.value.code == code
    assert where is None or error.value.where == where
    for fact in facts:
        assert fact in str(error.value)


def module_of(path: Path) -> ModuleType:
    """A script, imported; its ``__main__`` block does not run."""
    spec = importlib.util.spec_from_file_location(f"script_{path.stem}", path)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses and pickle look it up
    spec.loader.exec_module(module)
    return module


def loaded(program: str, heavy: str) -> list[str]:
    """Those of the modules that a program loads, in a process of its own."""
    code = f"{program}\nimport sys\nprint(*sorted({set(heavy.split())} & set(sys.modules)), sep='\\n')"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return [line for line in done.stdout.splitlines() if line in heavy.split()]


def pytest_addoption(parser: pytest.Parser) -> None:
    """Adds ``--no-skips``: a skipped test is a failure, so that CI cannot lose a test unnoticed."""
    parser.addoption("--no-skips", action="store_true", help="a skipped test is a failure")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Skips tests marked ``committed`` in a clone without (all) committed submissions."""
    root = Path(__file__).resolve().parents[1]
    tracked = subprocess.run(
        ["git", "ls-files", "-t", "submissions"], cwd=root, capture_output=True, text=True, check=False
    )
    if "\nS " in f"\n{tracked.stdout}" or not any(root.glob("submissions/*/submission.toml")):
        reason = "reads submissions that this clone leaves out; to get them: git sparse-checkout disable"
        for item in items:
            if item.get_closest_marker("committed"):
                item.add_marker(pytest.mark.skip(reason=reason), append=False)


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    """Fails the session if ``--no-skips`` is given and a test or module was skipped; ``-ra`` lists them."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if session.config.getoption("--no-skips") and reporter is not None and reporter.stats.get("skipped"):
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


MANIFEST = """format = 1
title = "A submission"
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
"""
VERSIONS = documents.Versions(
    gym_extensions="1.0.0",
    gymnasium="1.4.0",
    mujoco="4.0.0",
    numpy="2.4.6",
    python="3.11.7",
    platform="Linux-x86_64",
    blas="openblas Haswell",
)
UNIFORM = Policy(action_offset=np.zeros(3), action_scale=np.ones(3), head="uniform")

GRAVITY = tuple(name.removesuffix("-v0") for name in SUITES["gravity"])
"""The names of the groups of a suite: those of four bodies."""
Write = Callable[..., Path]
"""The fixture ``make_submission``."""
Value = Callable[[str, int, int, int, int], float]
"""The return of an episode: a function of protocol, run, stage, task's position from 1, episode."""


def formula(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
    """Returns that differ in every row and lie within what Hopper can give in 1000 steps."""
    return 100.0 * stage + 10.0 * position + run + episode / 8 + (0.5 if protocol == "single" else 0.0)


def write_submission(
    root: Path,
    *,
    name: str = "submission",
    groups: tuple[str, ...] = ("hopper-gravity",),
    runs: tuple[int, ...] = (0, 1),
    protocols: tuple[str, ...] = ("sequential", "single"),
    value: Value = formula,
    curves: int = 0,
    manifest: str = MANIFEST,
    policy: Policy | None = UNIFORM,
    verified: bool | None = None,
    parameters: int = 100,
) -> Path:
    """Writes a complete submission and gives its folder.

    Args:
        curves: number of points of each curve.
        policy: what runs publish for every stage and task, whatever the log says; None: nothing.
        verified: whether a review says so, which a rank needs; by default with five or more runs.
        parameters: number of parameters of the agent.
    """
    folder = root / name
    folder.mkdir(parents=True, exist_ok=True)
    digests, budget = {}, prescribed.BUDGETS[parse(manifest.encode())["protocol"]["budget"]]
    for group_name, protocol, run in product(groups, protocols, runs):
        members = group(group_name)
        steps = budget.steps_for(group_name)
        document = write_run(
            *(folder, members, protocol, run, episodes_of(members, protocol, run, value)),
            policies=dict.fromkeys(files.policy_keys(protocol, members), policy) if policy else {},
            order=documents.order_of(members, protocol, run),
            versions=VERSIONS,
            steps=steps * len(members.tasks),
            memory=documents.Memory(
                stored_steps=2000, parameters_first=parameters, parameters_last=parameters
            ),
            curves=curves_of(members, protocol, run, value, steps=steps, points=curves),
        )
        digests[run_key(group_name, protocol, run)] = document.digest
    (folder / "submission.toml").write_text(manifest, encoding="utf-8", newline="\n")
    if len(runs) >= prescribed.FULL_SUBMISSION_RUNS if verified is None else verified:
        settings = manifest_of(parse(manifest.encode())).digest
        write_review(folder, Review(verifications=[verification(digests, settings)]))
    return folder


def write_run(
    folder: Path,
    members: TaskGroup,
    protocol: str,
    run: int,
    episodes: list[Episode],
    *,
    policies: Mapping[files.Key, files.AnyPolicy],
    **facts: Any,
) -> documents.RunDocument:
    """Writes the log, the policies (if any) and the document of a run."""
    log, npz = (folder / run_file(members.name, protocol, run, suffix) for suffix in (LOG, POLICIES))
    write_log(log, episodes, members.task_ids)
    if policies:
        files.write_policies(npz, policies)
        arrays = files.run_arrays(policies)
        size = sum(map(len, files.policy_files(arrays).values()))
        facts["policies"] = documents.PolicyFile(sha256=files.content_sha256(arrays), size=size)
    document = documents.RunDocument(
        group=members.id,
        protocol=protocol,  # type: ignore[arg-type]
        run=run,
        fingerprints={task.id: published(task.id) for task in members.tasks},
        arithmetic=documents.ARITHMETIC,
        log=documents.file_sha256(log),
        **facts,
    )
    documents.write_run(log.with_suffix(DOCUMENT), document)
    return document


def episodes_of(members: TaskGroup, protocol: str, run: int, value: Value) -> list[Episode]:
    """The episodes of a run, whose returns follow from the formula."""
    return [
        Episode(
            stage=stage,
            task=task.id,
            episode=episode,
            seed=prescribed.evaluation_seed(members.id, task.id, episode),
            length=task.max_steps,
            return_=float(value(protocol, run, stage, position, episode)),
            terminated=False,
            success=None if task.body.success is None else False,
        )
        for stage, (position, task), episode in product(
            prescribed.stages(protocol, len(members.tasks)),
            enumerate(members.tasks, 1),
            range(prescribed.EVALUATION_EPISODES),
        )
    ]


def curves_of(
    members: TaskGroup, protocol: str, run: int, value: Value, *, steps: int, points: int
) -> list[documents.Curve]:
    """One curve per task, which all have the returns of the first task."""
    return [
        documents.Curve(
            stage=position if protocol in prescribed.IN_ORDER else 1,
            task=members.task_ids[index],
            steps=[steps * point // points for point in range(1, points + 1)],
            returns=[float(value(protocol, run, 1, 1, point)) for point in range(1, points + 1)],
        )
        for position, index in enumerate(prescribed.task_order(protocol, run, len(members.tasks)), 1)
        if points
    ]


def trained_here(folder: Path, version: int = 1, **changes: object) -> Path:
    """Makes of the sequential runs of a submission those that the project trained, and adds code."""
    (runs,) = folder.glob("*/sequential")
    target = folder / "trained" / str(version)
    shutil.copytree(runs, target / runs.parent.name / "sequential")
    shutil.copy(folder / "submission.toml", target / "submission.toml")
    (folder / "agent").mkdir(exist_ok=True)
    (folder / "agent/agent.py").write_text("make = None\n", encoding="utf-8")
    with (folder / "submission.toml").open("a", encoding="utf-8") as file:
        file.write('\n[agent]\nentry = "agent.py:make"\n')
    (submitted,) = read(target).groups.values()
    stated = {"date": "2026-01-02", "version": "1.0.0", "commit": "3f" * 20, "agent": read(folder).code}
    training = msgspec.convert(stated | {"runs": submitted.digests("sequential")} | changes, Training)
    (folder / f"trained/{version}.toml").write_text(training_text(training), encoding="utf-8")
    return target


def verification(digests: dict[str, str], settings: str, **changes: object) -> Verification:
    """A verification of these runs that passed."""
    facts: dict[str, object] = {
        "date": "2026-11-26",
        "version": "1.0.0",
        "value": "0" * 64,
        "settings": settings,
        "runs": digests,
        "cells": 9,
        "p_value": 0.5,
        "passed": True,
    }
    return Verification(**(facts | changes))  # type: ignore[arg-type]


@pytest.fixture
def make_submission(tmp_path: Path) -> Write:
    """Writes a submission below the test's folder: ``make_submission(name=…, runs=…, value=…)``."""

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
            protocols = ("sequential", "single")[group_name.startswith("nav-") :]  # 30 tasks take seconds
            made[group_name] = write_submission(place, groups=(group_name,), protocols=protocols, curves=12)
        return Path(shutil.copytree(made[group_name], root / "submission"))

    return copy


JOBS = ("curation.gate", "verification.episodes", "verification.limits")
"""The modules that have the function which gives jobs to processes with limits."""


def run_jobs_here(patch: pytest.MonkeyPatch) -> None:
    """Runs jobs on files of a submission in this process: starting one with limits takes a second."""

    for module in JOBS:
        patch.setattr(f"gym_extensions.{module}.answers", lambda job, call, _: job(call))


@pytest.fixture
def in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    run_jobs_here(monkeypatch)


@pytest.fixture(scope="session")
def references() -> References:
    """Synthetic references of the gravity groups: floor 0, expert 1000, so that p is R / 1000."""
    tasks = [task for name in GRAVITY for task in group(name).task_ids]
    return References("synthetic", dict.fromkeys(tasks, Reference(Floor(0.0), Expert(1000.0))), "0" * 64)


@pytest.fixture
def known(monkeypatch: pytest.MonkeyPatch, references: References) -> None:
    """Scores with the synthetic references."""
    monkeypatch.setattr("gym_extensions.references.load_references", lambda: references)
    monkeypatch.setattr("gym_extensions.scoring.pipeline.load_references", lambda: references)
