"""The published fingerprints of all tasks, read from ``fingerprints.json`` without a simulator."""

from __future__ import annotations

import functools
import hashlib
import json
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

from gym_extensions.catalog.task import Task
from gym_extensions.errors import BenchError, did_you_mean

PATH = Path(__file__).with_name("fingerprints.json")
FORMAT = 1


@functools.cache
def table() -> dict[str, Any]:
    """The committed file of fingerprints, with format, versions of the engine and one row per task id."""
    content: dict[str, Any] = json.loads(PATH.read_text(encoding="utf-8"))
    return content


def published(task_id: str) -> str:
    """Returns the published fingerprint of a task, 16 hexadecimal digits.

    Raises:
        BenchError: the task has no published fingerprint; the hint names the closest id.
    """
    rows = table()["tasks"]
    if task_id not in rows:
        hint = f"{did_you_mean(task_id, rows)} To publish new tasks: gym-extensions envs fingerprint"
        raise BenchError("no-fingerprint", f"No fingerprint is published for {task_id!r}.", hint=hint)
    digest: str = rows[task_id]["fingerprint"]
    return digest


def digest(row: Mapping[str, Any]) -> str:
    """The short digest of the canonical JSON of a row without its ``fingerprint``."""
    content = {key: value for key, value in row.items() if key != "fingerprint"}
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def definition(task: Task) -> dict[str, Any]:
    """The task as plain data, with the kind and the values of every variation."""
    return {
        "name": task.name,
        "version": task.version,
        "base": task.base,
        "max_steps": task.max_steps,
        "variations": [_plain(variation) for variation in task.variations],
    }


def _plain(value: Any) -> Any:
    if is_dataclass(value):
        values = {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
        return {"kind": type(value).__name__} | values
    return [_plain(entry) for entry in value] if isinstance(value, tuple | list) else value
