"""A folder -> a Submission, and every problem in it at once."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.catalog.protocol import BUDGETS, PROTOCOLS
from gym_extensions.scoring import manifest as toml
from gym_extensions.scoring import rows
from gym_extensions.scoring.checks.across import GroupLogs
from gym_extensions.scoring.checks.agreement import Said
from gym_extensions.scoring.checks.arrays import Arrays
from gym_extensions.scoring.checks.files import largest
from gym_extensions.scoring.checks.rule import broken, rule
from gym_extensions.scoring.copies import without_copies
from gym_extensions.scoring.curves import Curves, curves
from gym_extensions.scoring.entry import GroupEntry, Submission
from gym_extensions.scoring.folder import MANIFEST, Folder, scan
from gym_extensions.scoring.log import CURVE_COLUMNS, EPISODE_COLUMNS
from gym_extensions.scoring.prescribed import prescribed_log
from gym_extensions.scoring.problems import Finding, Problem
from gym_extensions.scoring.rows import Log
from gym_extensions.scoring.text import Text, columns

T = TypeVar("T")


@dataclass(frozen=True)
class Unreadable:
    """A file that the operating system did not give."""

    path: str
    reason: str


@rule("unreadable")
def unreadable_file(file: Unreadable) -> Iterator[Finding]:
    """Every file of a submission can be read."""
    yield Finding(
        file.path, f"The file cannot be read: {file.reason}.", "Give it read permission, or copy it again."
    )


class _Reader:
    """Reads one folder step by step, collecting problems; a part with problems is not read further."""

    def __init__(self, folder: Folder) -> None:
        self.folder = folder
        self.problems: list[Problem] = []

    def passes(self, scope: str, subject: Any) -> bool:
        """Whether the rules of a scope find nothing; what they find is kept."""
        found = broken(scope, subject)
        self.problems += found
        return not found

    def contents(self, path: str) -> bytes | None:
        """The bytes of a file, or None with a problem where they cannot be read or are too many."""
        if self.folder.size(path) > largest(path):
            return None  # too_large has told it
        try:
            return self.folder.read(path)
        except OSError as error:
            self.passes("unreadable", Unreadable(path, error.strerror or type(error).__name__))
            return None

    def manifest(self) -> toml.Manifest | None:
        data = self.contents(MANIFEST) if self.folder.has(MANIFEST) else None
        if data is None or not self.passes("manifest-bytes", data):
            return None
        tables = toml.parse(data)
        found = toml.manifest(tables) if self.passes("manifest", tables) else None
        self.passes("said", Said(self.folder, tables))
        return found

    def cells(
        self, path: str, data: bytes, header: tuple[str, ...], build: Callable[[rows.Cells], T]
    ) -> T | None:
        """What ``build`` makes of a CSV file whose bytes and cells are as they must be."""
        if not self.passes("text", text := Text(path, header, data)):
            return None
        cells = rows.Cells(path, columns(text))
        try:
            return build(cells)
        except (ValueError, KeyError, OverflowError):
            if self.passes("cells", cells):
                raise
            return None

    def log(self, group: TaskGroup, protocol: str) -> Log | None:
        path = f"{group.name}/{protocol}.csv"
        if not self.folder.has(path):
            return None
        data = self.contents(path)
        log = None if data is None else prescribed_log(path, data, protocol, group)
        scopes = ["log"]
        if data is not None and log is None:
            log = self.cells(path, data, EPISODE_COLUMNS, lambda cells: rows.log(cells, protocol, group))
            scopes = ["keys", "log"]
        found = [] if log is None else [self.passes(scope, log) for scope in scopes]
        return log if found and all(found) else None

    def curves(self, group: TaskGroup, budget: str, runs: rows.Runs) -> Curves | None:
        path = f"{group.name}/curves.csv"
        if not self.folder.has(path) or (data := self.contents(path)) is None:
            return None
        found = self.cells(
            path, data, CURVE_COLUMNS, lambda cells: curves(cells, group, BUDGETS.get(budget), runs)
        )
        return found if found is not None and self.passes("curves", found) else None

    def arrays(self, group: TaskGroup, runs: rows.Runs) -> None:
        for entry in self.folder.files():
            mine = entry.path.startswith(f"{group.name}/") and entry.path.endswith(".npz")
            if mine and (data := self.contents(entry.path)) is not None:
                self.passes("arrays", Arrays(entry.path, data, group, runs))

    def group(self, group: TaskGroup, manifest: toml.Manifest | None) -> GroupEntry:
        odd = any(problem.where.startswith(f"{group.name}/") for problem in self.problems)
        logs = {protocol: log for protocol in PROTOCOLS if (log := self.log(group, protocol)) is not None}
        learns = manifest is None or manifest.memory.get("parameters_last", 1) > 0
        self.passes("group", GroupLogs(group.name, logs, learns))
        there = [name for name in PROTOCOLS if odd or self.folder.has(f"{group.name}/{name}.csv")]
        runs: rows.Runs = {name: logs[name].runs if name in logs else None for name in there or PROTOCOLS}
        curves = self.curves(group, manifest.budget if manifest else "", runs)
        self.arrays(group, runs)
        return GroupEntry(group, logs, curves)


def read(path: Path) -> Submission:
    """The submission in a folder; with problems, what could be read of it and all of them."""
    folder = scan(path)
    reader = _Reader(folder)
    reader.passes("folder", folder)
    manifest = reader.manifest()
    names = [name for name in GROUPS if any(entry.path == name for entry in folder.entries)]
    groups = {GROUPS[name].id: reader.group(GROUPS[name], manifest) for name in names}
    problems = tuple(reader.problems)
    if not problems and manifest is not None:
        groups = {name: without_copies(entry) for name, entry in groups.items()}
    return Submission(folder.name, manifest, groups, problems)
