"""A submission in the hands of its author: logs, all traces, and what commits the logs to the traces."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gym_extensions.baselines.submission.root import logs_of
from gym_extensions.baselines.training.evaluation import Rollout
from gym_extensions.catalog.groups import group
from gym_extensions.catalog.registry import TASKS
from gym_extensions.rollouts.auditing.digests import merkle_root, trace_digest
from gym_extensions.rollouts.auditing.sample import audit_sample
from gym_extensions.rollouts.layout import MANIFEST, POLICIES, SALT_FILE, TRACES, policy_names, trace_name
from gym_extensions.rollouts.policies import Policy
from gym_extensions.rollouts.safe_npz import npz_bytes, read
from gym_extensions.rollouts.traces import trace_arrays

from .workshop import put

Row = dict[str, str]
Arrays = dict[str, np.ndarray[Any, Any]]
SUCCESS = {"true": True, "false": False, "": None}


class Forger:
    """Changes the logs, traces, policies and manifest of a submission of one group.

    Args:
        folder: the submission, with the traces of all episodes in ``.progress``.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.group = group(logs_of(folder)[0].parent.name)

    def log(self, protocol: str) -> Path:
        """The path of a log."""
        return self.folder / self.group.name / f"{protocol}.csv"

    def rows(self, protocol: str = "single") -> list[Row]:
        """The rows of a log."""
        with self.log(protocol).open(newline="") as file:
            return list(csv.DictReader(file))

    def write(self, rows: Sequence[Row], protocol: str = "single") -> None:
        """Writes a log."""
        lines = [",".join(rows[0]), *(",".join(row.values()) for row in rows), ""]
        self.log(protocol).write_text("\n".join(lines), newline="\n")

    def change(self, edit: Callable[[Row], object], protocol: str = "single") -> None:
        """Changes every row of a log, and nothing else."""
        rows = self.rows(protocol)
        for row in rows:
            edit(row)
        self.write(rows, protocol)

    def stored(self, row: Row, protocol: str = "single") -> Path:
        """The path of the trace of an episode among those of all episodes."""
        key = int(row["run"]), int(row["stage"]), TASKS[row["task"]].name, int(row["episode"])
        return self.folder / ".progress" / self.group.name / TRACES / trace_name(protocol, *key)

    def arrays(self, row: Row, protocol: str = "single") -> Arrays:
        """The arrays of the trace of an episode."""
        arrays = read(self.stored(row, protocol).read_bytes())
        assert arrays is not None
        return {name: values.copy() for name, values in arrays.items()}

    def bind(self, row: Row, arrays: Mapping[str, Any] | None = None, protocol: str = "single") -> None:
        """Makes the row commit to its trace, or to another one, which is stored."""
        if arrays is not None:
            put(self.stored(row, protocol), npz_bytes(dict(arrays)))
        outcome = int(row["length"]), float(row["return"]), row["terminated"] == "true"
        content = self.arrays(row, protocol) if arrays is None else arrays
        row["trace"] = trace_digest(content, *outcome, SUCCESS[row["success"]])

    def put_rollout(self, row: Row, rollout: Rollout, protocol: str = "single") -> None:
        """Makes a row that of another episode, with its trace."""
        assert rollout.trace is not None
        row |= {"length": str(rollout.length), "return": repr(rollout.return_)}
        row |= {"terminated": str(rollout.terminated).lower()}
        row["success"] = "" if rollout.success is None else str(rollout.success).lower()
        self.bind(row, trace_arrays(rollout.trace), protocol)

    def lose(self, row: Row, return_: float, protocol: str = "single") -> None:
        """Invents the return of an episode: the row commits to a trace that does not exist."""
        row["return"] = repr(return_)
        row["trace"] = merkle_root([row["trace"]])[: len(row["trace"])]
        self.stored(row, protocol).unlink(missing_ok=True)

    def put_policy(self, policy: Policy, runs: Iterable[int], protocol: str = "single") -> None:
        """Makes a policy that of all stages and tasks of the runs."""
        for name in policy_names(protocol, list(runs), self.group):
            put(self.folder / self.group.name / POLICIES / name, policy.to_bytes())

    def declare(self, key: str, value: str) -> None:
        """Gives a key of the manifest another value, as TOML."""
        path = self.folder / MANIFEST
        text, count = re.subn(rf"(?m)^{key} = .*$", lambda _: f"{key} = {value}", path.read_text())
        assert count == 1, key
        path.write_text(text, newline="\n")

    def commit(self) -> Path:
        """Commits the manifest to the traces of all logs, and writes the sample without a salt."""
        digests = [
            row["trace"] for log in logs_of(self.folder) if log.stem in LOGS for row in self.rows(log.stem)
        ]
        self.declare("root", f'"{merkle_root(digests)}"')
        self.write_sample()
        return self.folder

    def write_sample(self, salt: str = "") -> None:
        """Writes the stored traces of the audit sample of a salt, as far as they exist, and no others."""
        target = self.folder / self.group.name / TRACES
        target.mkdir(exist_ok=True)
        for path in target.iterdir():
            path.unlink()
        for log in logs_of(self.folder):
            if log.stem in LOGS:
                runs = sorted({int(row["run"]) for row in self.rows(log.stem)})
                for item in audit_sample(log.stem, log.read_bytes(), runs, self.group.tasks, salt):
                    name = trace_name(log.stem, item.run, item.stage, TASKS[item.task].name, item.episode)
                    source = self.folder / ".progress" / self.group.name / TRACES / name
                    if source.exists():
                        put(target / name, source.read_bytes())
        if salt:
            put(target / SALT_FILE, f"{salt}\n".encode())


LOGS = ("sequential", "single", "joint")


def cells(rows: Sequence[Row]) -> list[list[Row]]:
    """The rows by cell; each cell has 20, in order."""
    return [list(rows[start : start + 20]) for start in range(0, len(rows), 20)]


def largest(cell: Sequence[Row]) -> float:
    """The largest return of a cell."""
    return max(float(row["return"]) for row in cell)
