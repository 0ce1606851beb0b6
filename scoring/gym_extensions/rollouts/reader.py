"""A folder -> a Submission, and every problem in it at once."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.rollouts import manifest as toml
from gym_extensions.rollouts.episodes import CURVE_COLUMNS, EPISODE_COLUMNS
from gym_extensions.rollouts.folder import Folder, scan
from gym_extensions.rollouts.identical_runs import without_copies
from gym_extensions.rollouts.layout import MANIFEST, largest
from gym_extensions.rollouts.problem import Problem
from gym_extensions.rollouts.reading import evaluation_log as rows
from gym_extensions.rollouts.reading.csv_lines import Text, columns
from gym_extensions.rollouts.reading.evaluation_log import Log
from gym_extensions.rollouts.reading.fast_path import prescribed_log
from gym_extensions.rollouts.reading.salvage import every_cell, keys_alone, legible
from gym_extensions.rollouts.reading.training_curves import Curves, curves
from gym_extensions.rollouts.rules.consistency import Said
from gym_extensions.rollouts.rules.npz import Arrays
from gym_extensions.rollouts.rules.readable import Unreadable
from gym_extensions.rollouts.rules.rule import broken
from gym_extensions.rollouts.rules.runs import GroupLogs
from gym_extensions.rollouts.submission import GroupEntry, Submission

UNREAD = (ValueError, KeyError, OverflowError)
"""What a cell of another kind than its column's raises."""


class _Reader:
    """Reads one folder step by step, collecting problems; each part as far as it can be read."""

    def __init__(self, folder: Folder) -> None:
        self.folder = folder
        self.tables: dict[str, Any] = {}
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
        self.tables = toml.parse(data)
        found = toml.manifest(self.tables) if self.passes("manifest", self.tables) else None
        self.passes("said", Said(self.folder, self.tables))
        return found

    def cells(self, path: str, data: bytes, header: tuple[str, ...]) -> rows.Cells | None:
        """The cells of a CSV file: of all rows, or of those that can be read."""
        text = Text(path, header, data)
        return rows.Cells(path, columns(text)) if self.passes("text", text) else legible(text)

    def log(self, group: TaskGroup, protocol: str) -> tuple[Log | None, Log | None]:
        """The log as far as its keys can be read, and as far as every cell can be."""
        path = f"{group.name}/{protocol}.csv"
        if not self.folder.has(path) or (data := self.contents(path)) is None:
            return None, None
        if (log := prescribed_log(path, data, protocol, group)) is not None:
            self.passes("log", log)
            return log, log
        if (cells := self.cells(path, data, EPISODE_COLUMNS)) is None:
            return None, None
        try:
            keys: Log | None = rows.log(cells, protocol, group)
            values = keys
        except UNREAD:
            if self.passes("cells", cells):
                raise
            keys, values = (
                rows.log(part, protocol, group) if part else None
                for part in (keys_alone(cells), every_cell(cells))
            )
        for scope, part in (("keys", keys), ("log", values)):
            if part is not None:
                self.passes(scope, part)
        return keys, values

    def curves(self, group: TaskGroup, runs: rows.Runs) -> Curves | None:
        path = f"{group.name}/curves.csv"
        if not self.folder.has(path) or (data := self.contents(path)) is None:
            return None
        cells = self.cells(path, data, CURVE_COLUMNS)
        known = group, toml.budget_said(self.tables), runs
        try:
            found = curves(cells, *known) if cells else None
        except UNREAD:
            if cells is None or self.passes("cells", cells):
                raise
            every = every_cell(cells)
            found = curves(every, *known) if every else None
        if found is not None:
            self.passes("curves", found)
        return found

    def arrays(self, group: TaskGroup, runs: rows.Runs) -> None:
        for entry in self.folder.files():
            mine = entry.path.startswith(f"{group.name}/") and entry.path.endswith(".npz")
            if mine and (data := self.contents(entry.path)) is not None:
                self.passes("arrays", Arrays(entry.path, data, group, runs))

    def group(self, group: TaskGroup) -> GroupEntry:
        odd = any(problem.where.startswith(f"{group.name}/") for problem in self.problems)
        logs: dict[str, Log] = {}
        readable: dict[str, Log] = {}
        named: rows.Runs = {}
        there = [name for name in PROTOCOLS if odd or self.folder.has(f"{group.name}/{name}.csv")]
        runs: rows.Runs = dict.fromkeys(there or PROTOCOLS)
        for protocol in PROTOCOLS:
            before = len(self.problems)
            keys, values = self.log(group, protocol)
            if values is not None:
                readable[protocol] = values
            named[protocol] = keys.runs if keys and not keys.unread else None
            if keys is not None and len(self.problems) == before:
                logs[protocol], runs[protocol] = keys, keys.runs
        self.passes("group", GroupLogs(group.name, readable, named, toml.learns_said(self.tables)))
        curves = self.curves(group, runs)
        self.arrays(group, runs)
        return GroupEntry(group, logs, curves)


def read(path: Path) -> Submission:
    """The submission in a folder; with problems, what could be read of it and all of them."""
    folder = scan(path)
    reader = _Reader(folder)
    reader.passes("folder", folder)
    manifest = reader.manifest()
    names = [name for name in GROUPS if any(entry.path == name for entry in folder.entries)]
    groups = {GROUPS[name].id: reader.group(GROUPS[name]) for name in names}
    problems = tuple(reader.problems)
    if not problems and not toml.learns_said(reader.tables):  # a learning agent's copies are problems
        groups = {name: without_copies(entry) for name, entry in groups.items()}
    return Submission(folder.name, manifest, groups, problems)
