"""The published fingerprints of all tasks, read from ``fingerprints.json`` without a simulator."""

import functools
import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gym_extensions.errors import BenchError, did_you_mean

PATH = Path(__file__).with_name("fingerprints.json")
FORMAT = 1


@functools.cache
def table() -> dict[str, Any]:
    """The committed file of fingerprints, with format, versions of the engine and one row per task id."""
    return json.loads(PATH.read_text(encoding="utf-8"))


def published(task_id: str) -> str:
    """Returns the published fingerprint of a task, 16 hexadecimal digits.

    Raises ``BenchError`` if the task has no published fingerprint; the hint names the closest id.
    """
    rows = table()["tasks"]
    if task_id not in rows:
        hint = (
            f"{did_you_mean(task_id, rows)} To publish new tasks: python -m tools.environments.fingerprints"
        )
        raise BenchError("no-fingerprint", f"No fingerprint is published for {task_id!r}.", hint=hint)
    return rows[task_id]["fingerprint"]


def digest(row: Mapping[str, object]) -> str:
    """The short digest of the canonical JSON of a row without its ``fingerprint``."""
    content = {key: value for key, value in row.items() if key != "fingerprint"}
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]
