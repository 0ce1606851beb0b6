"""Judges a submission's folder in a process of its own, with limits; run as a module, it is that process."""

from __future__ import annotations

import importlib
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import asdict
from pathlib import Path

import msgspec

from gym_extensions.curation.evidence import prove
from gym_extensions.curation.gate.judgement import Judgement, judgement_of
from gym_extensions.curation.gate.limits import DEFAULT, Limits, apply_limits
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.problem import Problem
from gym_extensions.scoring.pipeline.score import fault

MODULE = "gym_extensions.curation.gate.judge"
SIMULATOR = "gym_extensions.scoring.replay.verify"
KEPT_VARIABLES = ("PATH", "HOME", "TMPDIR", "NUMBA_CACHE_DIR", "LD_LIBRARY_PATH")
"""Environment variables that the process gets. Tokens are not among them."""


def judge(folder: Path, salt: str = "", limits: Limits = DEFAULT) -> Judgement:
    """Scores and replays a submission in a process with limits.

    Args:
        folder: the submission.
        salt: selects the audit sample, or empty.
        limits: what the process may use. A process that reaches a limit is a problem of the submission
            (``limit-reached``).
    """
    environment = {name: os.environ[name] for name in KEPT_VARIABLES if name in os.environ}
    environment |= {"OPENBLAS_NUM_THREADS": "1", "PYTHONUTF8": "1"}
    request = json.dumps({"folder": str(folder), "salt": salt, "limits": asdict(limits)})
    with tempfile.TemporaryFile() as output:
        try:
            process = subprocess.run(
                [sys.executable, "-I", "-m", MODULE],
                input=request.encode(),
                stdout=output,
                stderr=subprocess.PIPE,
                env=environment,
                cwd=folder.parent,
                timeout=limits.wall_seconds,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return _stopped(folder.name, f"It was not finished after {limits.wall_seconds} seconds.")
        output.seek(0)
        answer = output.read()
    if process.returncode:
        lines = process.stderr.decode(errors="replace").strip().splitlines()
        last = lines[-1][:200] if lines else "without a message"
        return _stopped(folder.name, f"The process ended with status {process.returncode}: {last}.")
    return Judgement.from_json(answer)


def _stopped(name: str, message: str) -> Judgement:
    hint = "A submission must be checked within the limits on memory and time of docs/pull-requests.md."
    return Judgement(problems=(Problem("limit-reached", name, message, hint),))


def main() -> None:
    """Reads a request from standard input, limits this process, judges, and prints the result."""
    request = msgspec.json.decode(sys.stdin.buffer.read())
    importlib.import_module(SIMULATOR)  # libraries may start programs while they are imported
    apply_limits(Limits(**request["limits"]))
    folder = Path(request["folder"])
    try:
        result = judgement_of(prove(folder, request["salt"]))
    except BenchError as error:
        result = Judgement(problems=(Problem(error.code, folder.name, error.message, error.hint),))
    except (MemoryError, OSError):  # a limit
        raise
    except Exception as error:  # noqa: BLE001 - a mistake of the scorer is not one of the submission
        result = Judgement(problems=(fault(folder, error),))
    sys.stdout.buffer.write(result.to_json().encode())


if __name__ == "__main__":
    main()
