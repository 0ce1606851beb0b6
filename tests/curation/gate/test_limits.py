"""The process that judges a submission has limits on memory, time and files, and no network."""

from __future__ import annotations

import os
import subprocess
import sys
from io import BytesIO, TextIOWrapper
from pathlib import Path

import pytest

from gym_extensions.curation.gate import judge as module
from gym_extensions.curation.gate.judge import judge
from gym_extensions.curation.gate.judgement import Judgement
from gym_extensions.curation.gate.limits import Limits

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows lacks these limits")

PROGRAM = """
import sys
from gym_extensions.curation.gate.limits import Limits, apply_limits
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


@pytest.mark.parametrize(
    ("error", "shown"),
    [
        (ValueError(), "fault-of-the-scorer: The scorer stopped with ValueError"),
        (MemoryError(), ""),
        (OSError(27, "File too large"), ""),
    ],
)
def test_a_mistake_of_the_scorer_is_not_called_a_limit(
    error: Exception, shown: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def prove(*_: object) -> None:
        raise error

    request = b'{"folder": "entry", "salt": "", "limits": {}}'
    monkeypatch.setattr(module, "prove", prove)
    monkeypatch.setattr(module, "apply_limits", lambda _: None)
    monkeypatch.setattr(sys, "stdin", TextIOWrapper(BytesIO(request)))
    if not shown:
        with pytest.raises(type(error)):
            module.main()
        return
    module.main()
    (problem,) = Judgement.from_json(capsys.readouterr().out).problems
    assert f"{problem.rule}: {problem.message}".startswith(shown)


def test_the_process_gets_no_token_of_its_environment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    environments: list[dict[str, str]] = []

    def run(*_: object, env: dict[str, str], **__: object) -> subprocess.CompletedProcess[bytes]:
        environments.append(env)
        return subprocess.CompletedProcess([], 1, b"", b"stopped")

    monkeypatch.setenv("GH_TOKEN", "secret")
    monkeypatch.setattr(module.subprocess, "run", run)  # type: ignore[attr-defined]
    (problem,) = judge(tmp_path / "entry", limits=Limits()).problems
    assert (problem.rule, problem.where) == ("limit-reached", "entry")
    assert problem.message == "The process ended with status 1: stopped."
    assert environments[0].keys() <= {*os.environ, "OPENBLAS_NUM_THREADS", "PYTHONUTF8"} - {"GH_TOKEN"}
