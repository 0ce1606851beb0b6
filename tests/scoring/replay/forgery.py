"""Forges a trace as the author of a submission can: the log and the manifest commit to the forged one."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from gym_extensions.baselines.submission.root import traces_root
from gym_extensions.baselines.tracing.trace import trace
from gym_extensions.catalog.groups import group
from gym_extensions.rollouts.auditing.digests import trace_digest
from gym_extensions.rollouts.layout import trace_name
from gym_extensions.rollouts.safe_npz import read

Arrays = dict[str, np.ndarray[Any, Any]]


def rewrite(path: Path, edit: Callable[[Arrays], object]) -> None:
    """Changes the arrays of a trace."""
    with np.load(path, allow_pickle=False) as file:
        arrays = {name: file[name].copy() for name in file.files}
    edit(arrays)
    np.savez_compressed(path, **arrays)


def largest(log: Path) -> dict[str, str]:
    """The row with the largest return of the first cell of a log. Its trace is always in the sample."""
    with log.open(newline="") as file:
        rows = list(csv.DictReader(file))
    cell = [row for row in rows if all(row[key] == rows[0][key] for key in ("run", "stage", "task"))]
    return max(cell, key=lambda row: float(row["return"]))


def forge(folder: Path, log: Path, edit: Callable[[Arrays], object] = lambda _: None, **cells: str) -> str:
    """Changes the trace and the row of that episode, commits to it, and draws the sample again.

    Args:
        folder: a submission with the traces of all episodes in ``.progress``.
        log: one of its logs.
        edit: changes the arrays of the trace.
        cells: new cells of the row.

    Returns:
        The path of the trace in the submission.
    """
    row, protocol, group_name = largest(log), log.stem, log.parent.name
    names = {task.id: task.name for task in group(group_name).tasks}
    key = int(row["run"]), int(row["stage"]), names[row["task"]], int(row["episode"])
    name = trace_name(protocol, *key)
    path = folder / ".progress" / group_name / "traces" / name
    rewrite(path, edit)
    arrays = read(path.read_bytes())
    assert arrays is not None
    forged = row | cells
    success = {"true": True, "false": False, "": None}[forged["success"]]
    outcome = int(forged["length"]), float(forged["return"]), forged["terminated"] == "true", success
    forged["trace"] = trace_digest(arrays, *outcome)
    text, root = log.read_text(), traces_root(folder)
    honest_line, forged_line = (",".join(cells.values()) for cells in (row, forged))
    assert text.count(f"{honest_line}\n") == 1
    log.write_text(text.replace(honest_line, forged_line), newline="\n")
    manifest = folder / "submission.toml"
    manifest.write_text(manifest.read_text().replace(root, traces_root(folder)), newline="\n")
    trace(folder)
    return f"{group_name}/traces/{name}"
