"""Running several things in worker processes or in this process."""

import importlib
import multiprocessing
import os
import threading
import time
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.baselines.training.progress import Event, JobFinished
from gym_extensions.baselines.workers import run

JOBS = '''
import os
import signal
import time
from dataclasses import dataclass

from gym_extensions.baselines.training.progress import JobFinished


class UnpickledError(Exception):
    def __init__(self, first, second):
        super().__init__(f"{first} and {second}")


@dataclass(frozen=True)
class Square:
    """Reports one event and returns a square with the process and its number of threads."""

    number: int

    def run(self, listen):
        if self.number < 0:
            raise UnpickledError("one", "two")
        listen(JobFinished(str(self.number)))
        return self.number**2, os.getpid(), os.environ["OPENBLAS_NUM_THREADS"]


@dataclass(frozen=True)
class Pause:
    """Reports an event before and after a pause."""

    seconds: float

    def run(self, listen):
        listen(JobFinished("before"))
        time.sleep(self.seconds)
        listen(JobFinished("after"))


@dataclass(frozen=True)
class Killed:
    """Is killed when it has sent a part of a message of 100 bytes."""

    def run(self, listen):
        (connection,) = (cell.cell_contents for cell in listen.__closure__)
        os.write(connection.fileno(), (100).to_bytes(4, "big") + b"a part")
        os.kill(os.getpid(), signal.SIGKILL)
'''


@pytest.fixture
def jobs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A module that worker processes can import."""
    (tmp_path / "jobs_of_tests.py").write_text(JOBS)
    monkeypatch.syspath_prepend(tmp_path)
    return importlib.import_module("jobs_of_tests")


@pytest.mark.parametrize("processes", [0, 2], ids=["this process", "workers"])
def test_every_result_and_event_arrives_and_an_exception_is_a_failure(processes: int, jobs: Any) -> None:
    events: list[Event] = []
    results: Any = dict(run([jobs.Square(number) for number in (-1, 2, 3)], events.append, processes))
    assert (results[1][0], results[2][0]) == (4, 9)
    assert sorted(event.job for event in events if isinstance(event, JobFinished)) == ["2", "3"]
    assert {results[index][1] == os.getpid() for index in (1, 2)} == {processes == 0}
    assert {results[index][2] for index in (1, 2)} == {"1"}
    assert results[0].cause == "UnpickledError: one and two"
    assert results[0].traceback.splitlines()[-1] == "jobs_of_tests.UnpickledError: one and two"


def test_what_a_worker_cannot_import_or_receive_fails_alone(jobs: Any, tmp_path: Path) -> None:
    (tmp_path / "jobs_of_tests.py").write_text("broken =")
    pending: list[Any] = [jobs.Square(2), threading.Lock()]
    results: Any = dict(run(pending, print, 1))
    assert "SyntaxError" in results[0].cause
    assert "pickle" in results[1].cause


@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGKILL")
def test_a_worker_that_is_killed_while_it_sends_fails_alone(jobs: Any) -> None:
    results: Any = dict(run([jobs.Killed(), jobs.Square(2)], print, 1))
    assert "SIGKILL" in results[0].cause
    assert results[1][0] == 4


def test_stopping_ends_the_workers_and_no_other_child_process(jobs: Any) -> None:
    def listen(event: Event) -> None:
        raise LookupError("no listener")

    own = multiprocessing.get_context("spawn").Process(target=time.sleep, args=(60,), daemon=True)
    own.start()
    with pytest.raises(LookupError, match="no listener"):
        list(run([jobs.Pause(60), jobs.Pause(60)], listen, 2))
    for process in multiprocessing.active_children():
        process.join(timeout=1 if process == own else 20)
    assert multiprocessing.active_children() == [own]
    own.terminate()
