"""Hostile folders end with the names of rules, within 5 s of processor time and 500 MB of memory."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from ..conftest import write_submission
from . import archives, folders, logs, manifests, policies, traces
from .case import Case
from .judge import CPU_SECONDS, MEBIBYTE, MEMORY, Judge

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no limits and no fork")

CASES = (*manifests.CASES, *logs.CASES, *archives.CASES, *traces.CASES, *policies.CASES, *folders.CASES)
MAX_OUTPUT = 100_000
"""Characters of the problems of a folder."""
LARGEST = ("60,000 unexpected files", "60,000 empty traces", "20,000 sections")
"""The cases that take longest are marked ``slow``; quick ones have thousands of the same."""


@pytest.fixture(scope="module")
def judge() -> Iterator[Judge]:
    with Judge() as judge:
        yield judge


@pytest.fixture(scope="module")
def valid(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small valid submission whose log commits to traces."""
    folder = tmp_path_factory.mktemp("valid")
    return write_submission(folder, runs=(0,), protocols=("single",), traces=True)


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(case, id=case.title, marks=pytest.mark.slow if case.title in LARGEST else ())
        for case in CASES
    ],
)
def test_a_hostile_folder(case: Case, judge: Judge, valid: Path, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(valid, tmp_path / case.name))
    case.change(folder)
    judgement = judge(folder, case.command)
    assert judgement.failure == ""
    assert judgement.rules == tuple(sorted(case.rules))
    assert judgement.cpu_seconds < CPU_SECONDS
    assert judgement.memory < MEMORY / MEBIBYTE
    assert judgement.output < MAX_OUTPUT or case.command == "pages"
