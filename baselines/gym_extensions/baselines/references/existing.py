"""The rows of a references file that is extended, and whether a file is provisional."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from gym_extensions.baselines.references.measure import ORACLE
from gym_extensions.catalog.protocol import FULL_ENTRY_RUNS
from gym_extensions.catalog.task import Task
from gym_extensions.envs.fingerprint import fingerprint_of
from gym_extensions.errors import BenchError

FORMAT = 1
REFERENCE_BUDGET = "300k"
"""The budget of the reference runs of a version that is not provisional."""


def existing_rows(path: Path, tasks: Iterable[Task]) -> dict[str, dict[str, Any]]:
    """The rows by task id of the file at ``path``; none if it does not exist.

    Raises:
        BenchError: the file does not hold references, or its floor of a task is of another definition.
    """
    if not path.exists():
        return {}
    try:
        document = json.loads(path.read_bytes())
        rows: dict[str, dict[str, Any]] = document["tasks"]
        if document["format"] != FORMAT:
            raise ValueError(document["format"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        hint = "Name another file with --out."
        raise BenchError(
            "malformed-references", "The file does not hold references.", str(path), hint
        ) from error
    for task in tasks:
        row = rows.get(task.id)
        if row is not None and row["floor"]["fingerprint"] != fingerprint_of(task):
            message = f"The floor of {task.id} was measured with another definition of the task."
            raise BenchError("foreign-fingerprint", message, str(path), "Start a new version with --out.")
    return rows


def is_provisional(rows: Iterable[Mapping[str, Any]]) -> bool:
    """Whether reference runs have another budget than the references', or are fewer than five per task."""
    reference_runs = [row["ceiling"] or row["attempts"] for row in rows if "ceiling" in row]
    trained = [each for each in reference_runs if each["agent"] != ORACLE]
    return any(each["budget"] != REFERENCE_BUDGET or len(each["runs"]) < FULL_ENTRY_RUNS for each in trained)
