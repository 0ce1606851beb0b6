"""Draws the run of a submission that is trained again, from a salt that its author did not know."""

from __future__ import annotations

import csv
import hashlib
from pathlib import Path
from typing import NamedTuple

from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.auditing.salt import require_salt


class LoggedRun(NamedTuple):
    """A run of a submission."""

    group: str
    protocol: str
    run: int


def logged_runs(folder: Path) -> list[LoggedRun]:
    """All runs of a submission, sorted."""
    return sorted(
        LoggedRun(log.parent.name, protocol, run)
        for protocol in PROTOCOLS
        for log in folder.glob(f"*/{protocol}.csv")
        for run in runs_of(log)
    )


def runs_of(log: Path) -> list[int]:
    """The runs in an evaluation log, sorted."""
    with log.open(newline="", encoding="utf-8") as file:
        return sorted({int(row["run"]) for row in csv.DictReader(file)})


def draw_run(folder: Path, salt: str) -> LoggedRun:
    """The run whose SHA-256 of ``<salt>/<group>/<protocol>/<run>`` is lowest.

    Args:
        folder: the submission.
        salt: 64 hexadecimal digits that exist only after the submission is fixed, such as those of
            ``gym-extensions ledger salt``.

    Raises:
        BenchError: the salt is malformed, or the submission has no log.
    """
    require_salt(salt, "--salt")
    runs = logged_runs(folder)
    if not runs:
        hint = "Name the folder of a submission, such as submissions/random."
        raise BenchError("no-log", "The folder has no log.", str(folder), hint)
    return min(runs, key=lambda run: hashlib.sha256("/".join((salt, *map(str, run))).encode()).digest())
