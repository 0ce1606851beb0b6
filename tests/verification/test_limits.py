"""The process that judges a submission has limits on memory, time and files, and no network."""

import os
import shlex
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from gym_extensions.errors import BenchError
from gym_extensions.verification.limits import Limits, answers

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows lacks these limits")

PROGRAM = """
import sys
from gym_extensions.verification.limits import Limits, apply_limits
apply_limits(Limits(memory=512 * 2**20, file_size=1000, cpu_seconds=1))
{statement}
"""


def limited(statement: str) -> subprocess.CompletedProcess[str]:
    program = PROGRAM.format(statement=statement)
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)


@pytest.mark.parametrize(
    ("statement", "error"),
    [
        ("import socket; socket.socket()", "PermissionError: socket.__new__ is not allowed"),
        ("import subprocess; subprocess.run(['true'])", "PermissionError: subprocess.Popen is not allowed"),
        ("import os; os.system('true')", "PermissionError: os.system is not allowed"),
        ("import os; os.fork()", "PermissionError: os.fork is not allowed"),
    ],
)
def test_what_is_not_allowed_raises(statement: str, error: str) -> None:
    result = limited(statement)
    assert result.returncode == 1
    assert error in result.stderr


def test_a_file_beyond_the_limit_is_refused(tmp_path: Path) -> None:
    path = str(tmp_path / "file")
    statement = f"with open({path!r}, 'wb') as file: file.write(b'x' * 2000)"
    assert "OSError: [Errno 27]" in limited(statement).stderr
    assert (tmp_path / "file").stat().st_size <= 1000


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux limits the memory of a process")
def test_memory_beyond_the_limit_is_refused() -> None:
    assert "MemoryError" in limited("bytearray(2**30)").stderr


def test_processor_time_beyond_the_limit_ends_the_process() -> None:
    assert limited("while True: pass").returncode < 0


def crash(call: dict[str, str]) -> Iterator[str]:
    """A job that ends in several ways."""
    yield os.environ.get("GH_TOKEN", "no token")
    if call["end"] == "mistake":
        raise BenchError("a-code", "A message.", "here", "A hint.")
    if call["end"] == "fault":
        raise ValueError
    if call["end"] == "limit":
        raise MemoryError
    if call["end"] == "sleep":
        time.sleep(60)
    while call["end"] == "spin":
        pass


@pytest.mark.parametrize(
    ("end", "code"), [("mistake", "a-code"), ("fault", "fault-of-the-verifier"), ("limit", "limit-reached")]
)
@pytest.mark.usefixtures("with_tests")
def test_a_mistake_of_the_verifier_is_not_called_a_limit(end: str, code: str) -> None:
    with pytest.raises(BenchError) as error:
        list(answers(crash, {"end": end}, Limits()))
    assert error.value.code == code


@pytest.mark.usefixtures("with_tests")
def test_the_process_gets_no_token_of_its_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GH_TOKEN", "secret")
    assert list(answers(crash, {"end": ""}, Limits())) == ["no token"]


@pytest.mark.parametrize(
    ("end", "limits"), [("sleep", Limits(wall_seconds=2)), ("spin", Limits(cpu_seconds=1))]
)
@pytest.mark.usefixtures("with_tests")
def test_a_process_that_takes_too_long_is_ended(end: str, limits: Limits) -> None:
    with pytest.raises(BenchError) as error:
        list(answers(crash, {"end": end}, limits))
    assert error.value.code == "too-slow"


@pytest.fixture
def with_tests(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Lets the process import this file."""
    program = (
        f"import sys; sys.path.insert(0, {str(Path(__file__).parents[2])!r}); "
        "from gym_extensions.verification.limits import main; main()"
    )
    wrapper = tmp_path / "python"
    wrapper.write_text(f"#!/bin/sh\nexec {sys.executable} -I -c {shlex.quote(program)}\n")
    wrapper.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(wrapper))
