"""Running several things in worker processes or in this process."""

from __future__ import annotations

import importlib
import os
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.baselines.training.events import Event, JobFinished
from gym_extensions.baselines.execution.workers import run_all

SQUARE = '''
import os
from dataclasses import dataclass

from gym_extensions.baselines.training.events import JobFinished


@dataclass(frozen=True)
class Square:
    """Reports one event and returns a square with the process and its number of threads."""

    number: int

    def run(self, listen):
        if self.number < 0:
            raise ValueError(self.number)
        listen(JobFinished(str(self.number)))
        return self.number**2, os.getpid(), os.environ["OPENBLAS_NUM_THREADS"]
'''


@pytest.fixture
def square(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A class in a module that worker processes can import."""
    (tmp_path / "squares.py").write_text(SQUARE)
    monkeypatch.syspath_prepend(tmp_path)
    return importlib.import_module("squares").Square


@pytest.mark.parametrize("processes", [0, 2])
def test_every_result_and_event_arrives(processes: int, square: Any) -> None:
    events: list[Event] = []
    results = dict(run_all([square(2), square(3), square(4)], processes, events.append))
    assert {index: result[0] for index, result in results.items()} == {0: 4, 1: 9, 2: 16}
    assert sorted(event.job for event in events if isinstance(event, JobFinished)) == ["2", "3", "4"]
    assert {pid == os.getpid() for _, pid, _ in results.values()} == {processes == 0}
    assert {threads for _, _, threads in results.values()} == {"1"}


@pytest.mark.parametrize("processes", [0, 2])
def test_an_exception_is_raised_in_the_calling_process(processes: int, square: Any) -> None:
    with pytest.raises(ValueError, match="-1"):
        list(run_all([square(-1), square(2)], processes, lambda _: None))


def test_nothing_to_run_yields_nothing() -> None:
    assert list(run_all([], 2, lambda _: None)) == []
