"""Computes what pins a task, and compares it with what is published."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

from gym_extensions.catalog import fingerprints
from gym_extensions.catalog.fingerprints import definition, digest
from gym_extensions.catalog.registry import TASKS
from gym_extensions.catalog.task import Task
from gym_extensions.envs import canary
from gym_extensions.envs.mujoco.compile import base_bytes

ENGINE = ("mujoco", "gymnasium")


@dataclass(frozen=True)
class Difference:
    """One number of a task, or of the engine, that is not as published."""

    task: str
    where: str
    published: Any
    found: Any

    def __str__(self) -> str:
        return f"{self.task}: {self.where} is {self.found!r}, published as {self.published!r}"


def engine() -> dict[str, str]:
    """The installed versions on which physics depends."""
    return {name: version(name) for name in ENGINE}


def row(task: Task) -> dict[str, Any]:
    """What pins a task: definition, sha256 of its base model, canary values, and the digest of these."""
    content = {
        "definition": definition(task),
        "model_sha256": hashlib.sha256(base_bytes(task)).hexdigest(),
        "canary": {"tolerance": canary.TOLERANCE, "episodes": canary.sing(task)},
    }
    return {"fingerprint": digest(content)} | content


def check(
    tasks: Iterable[Task] | None = None, published: Mapping[str, Any] | None = None
) -> list[Difference]:
    """Every way in which the tasks, all by default, differ from the published table; empty if none does.

    The digests are those of the published rows, so a value that moves within the tolerance, as on another
    CPU, moves no digest.
    """
    table = fingerprints.table() if published is None else published
    found = [
        Difference("engine", name, table["engine"].get(name), here)
        for name, here in engine().items()
        if table["engine"].get(name) != here
    ]
    for task in TASKS.values() if tasks is None else tasks:
        found.extend(_task_differences(task, table["tasks"].get(task.id)))
    if tasks is None:
        gone = sorted(set(table["tasks"]) - set(TASKS))
        found.extend(Difference(task_id, "task", "published", "not in the catalog") for task_id in gone)
    return found


def _task_differences(task: Task, published: Mapping[str, Any] | None) -> Iterator[Difference]:
    if published is None:
        yield Difference(task.id, "fingerprint", None, "not yet published")
        return
    if published["fingerprint"] != digest(published):
        yield Difference(task.id, "fingerprint", published["fingerprint"], digest(published))
    for where, before, now in compare("", {**published, "fingerprint": ""}, {**row(task), "fingerprint": ""}):
        yield Difference(task.id, where, before, now)


def compare(where: str, published: Any, found: Any) -> Iterator[tuple[str, Any, Any]]:
    """Each leaf at which two rows differ: where it is, the published and the found value.

    Numbers within ``canary.TOLERANCE`` of each other (relative above 1) are the same.
    """
    if isinstance(published, dict) and isinstance(found, dict):
        for key in sorted(published.keys() | found.keys()):
            path = f"{where}.{key}" if where else key
            yield from compare(path, published.get(key), found.get(key))
    elif isinstance(published, list) and isinstance(found, list) and len(published) == len(found):
        for index, (before, now) in enumerate(zip(published, found, strict=True)):
            yield from compare(f"{where}[{index}]", before, now)
    elif not _same(published, found):
        yield where, published, found


def _same(published: Any, found: Any) -> bool:
    numbers = all(type(value) in (int, float) for value in (published, found))
    if not numbers:
        return bool(published == found)
    return bool(abs(published - found) <= canary.TOLERANCE * max(1.0, abs(published)))


def renewed(replace: bool = False) -> tuple[dict[str, Any], list[str]]:
    """The table with a row for every task that has none, and the ids of the rows that are new.

    Rows that are published stay byte for byte; with ``replace`` those that no longer hold are made anew.
    """
    old = fingerprints.table() if fingerprints.PATH.exists() else {"tasks": {}}
    rows: dict[str, Any] = {}
    changed = []
    for task in TASKS.values():
        kept = old["tasks"].get(task.id)
        if kept is None or (replace and any(True for _ in _task_differences(task, kept))):
            kept = row(task)
            changed.append(task.id)
        rows[task.id] = kept
    return {"format": fingerprints.FORMAT, "engine": engine(), "tasks": rows}, changed


def text(table: Mapping[str, Any]) -> str:
    """The table as JSON, a line a task, so that a diff shows which tasks moved."""
    lines = ",\n".join(f"  {json.dumps(key)}: {json.dumps(value)}" for key, value in table["tasks"].items())
    head = f'"format": {table["format"]},\n "engine": {json.dumps(table["engine"])}'
    return f'{{{head},\n "tasks": {{\n{lines}\n }}}}\n'
