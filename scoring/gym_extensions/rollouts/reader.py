"""Reads a submission's folder and reports all its problems at once."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.rollouts import manifest as toml
from gym_extensions.rollouts import rules
from gym_extensions.rollouts.episodes import CURVE_COLUMNS, EPISODE_COLUMNS
from gym_extensions.rollouts.folder import Folder, scan
from gym_extensions.rollouts.identical_runs import merge_identical_runs
from gym_extensions.rollouts.layout import CURVES, MANIFEST, MAX_UNPACKED_POLICY_BYTES, POLICIES, max_bytes
from gym_extensions.rollouts.manifest import Manifest
from gym_extensions.rollouts.policies import Policy
from gym_extensions.rollouts.problem import Problem, summarize
from gym_extensions.rollouts.reading import evaluation_log, training_curves
from gym_extensions.rollouts.reading.csv_lines import Text, columns
from gym_extensions.rollouts.reading.evaluation_log import Cells, Log, Runs, has_prescribed_keys
from gym_extensions.rollouts.reading.salvage import fully_parsed_rows, key_parsed_rows, readable_rows
from gym_extensions.rollouts.reading.training_curves import Curves
from gym_extensions.rollouts.rules.consistency import ManifestInFolder
from gym_extensions.rollouts.rules.folder import UnreadableFile
from gym_extensions.rollouts.rules.npz import ArrayFile
from gym_extensions.rollouts.rules.policies import GroupPolicies, PolicyFile, PolicySummary
from gym_extensions.rollouts.rules.rule import Scope
from gym_extensions.rollouts.rules.runs import GroupLogs
from gym_extensions.rollouts.safe_npz import read as read_arrays
from gym_extensions.rollouts.submission import Submission, SubmittedGroup

PARSE_ERRORS = (ValueError, KeyError, OverflowError)
"""Raised for a cell of the wrong kind."""


def read(path: Path, groups: Mapping[str, TaskGroup] = GROUPS) -> Submission:
    """The submission in a folder. With problems, it holds all of them and what could be read.

    At most ``PROBLEMS_LISTED`` problems are listed per rule; the rest are counted.

    Args:
        path: the submission's folder.
        groups: the groups that it may contain, by name.
    """
    return _Reader(scan(path, groups)).submission()


class _Reader:
    """Reads one folder part by part and collects the problems of each."""

    def __init__(self, folder: Folder) -> None:
        self.folder = folder
        self.tables: dict[str, Any] = {}
        self.problems: list[Problem] = []

    def submission(self) -> Submission:
        self._passes("folder", self.folder)
        manifest = self._manifest()
        paths = {item.path for item in self.folder.items}
        groups = {group.id: self._group(group) for name, group in self.folder.groups.items() if name in paths}
        if not self.problems and not toml.declared_trainable(self.tables):
            groups = {group_id: merge_identical_runs(group) for group_id, group in groups.items()}
        problems = summarize(self.problems, self.folder.name)
        return Submission(self.folder.name, manifest, groups, problems)

    def _manifest(self) -> Manifest | None:
        data = self._bytes(MANIFEST)
        if data is None or not self._passes("manifest bytes", data):
            return None
        self.tables = toml.parse(data)
        manifest = toml.manifest(self.tables) if self._passes("manifest", self.tables) else None
        self._passes("manifest in folder", ManifestInFolder(self.folder, self.tables))
        return manifest

    def _group(self, group: TaskGroup) -> SubmittedGroup:
        logs: dict[str, Log] = {}
        measured: dict[str, Log] = {}
        named_runs: Runs = {}
        known_runs = self._unknown_runs(group)
        for protocol in PROTOCOLS:
            before = len(self.problems)
            keys, values = self._log(group, protocol)
            named_runs[protocol] = keys.runs if keys and not keys.unread else None
            if values is not None:
                measured[protocol] = values
            if keys is not None and len(self.problems) == before:
                logs[protocol], known_runs[protocol] = keys, keys.runs
        is_trainable = toml.declared_trainable(self.tables)
        self._passes("group", GroupLogs(group.name, measured, named_runs, is_trainable))
        curves = self._curves(group, known_runs)
        self._arrays(group, known_runs)
        return SubmittedGroup(group, logs, curves)

    def _unknown_runs(self, group: TaskGroup) -> Runs:
        """The logs that curves and traces may belong to: all, if the group's folder has a problem."""
        has_problem = any(problem.where.startswith(f"{group.name}/") for problem in self.problems)
        logs = [name for name in PROTOCOLS if has_problem or f"{group.name}/{name}.csv" in self.folder.files]
        return dict.fromkeys(logs or PROTOCOLS)

    def _log(self, group: TaskGroup, protocol: str) -> tuple[Log | None, Log | None]:
        """The rows of a log whose keys can be parsed, and those that can be parsed fully."""
        cells = self._cells(f"{group.name}/{protocol}.csv", EPISODE_COLUMNS)
        if cells is None:
            return None, None
        try:
            keys: Log | None = evaluation_log.log(cells, protocol, group)
            values = keys
        except PARSE_ERRORS:
            if self._passes("cells", cells):
                raise
            keys, values = (
                evaluation_log.log(part, protocol, group) if part else None
                for part in (key_parsed_rows(cells), fully_parsed_rows(cells))
            )
        if keys is not None and not has_prescribed_keys(keys):
            self._passes("keys", keys)
        if values is not None:
            self._passes("log", values)
        return keys, values

    def _curves(self, group: TaskGroup, runs: Runs) -> Curves | None:
        cells = self._cells(f"{group.name}/{CURVES}", CURVE_COLUMNS)
        if cells is None:
            return None
        budget = toml.declared_budget(self.tables)
        try:
            curves: Curves | None = training_curves.curves(cells, group, budget, runs)
        except PARSE_ERRORS:
            if self._passes("cells", cells):
                raise
            parsed = fully_parsed_rows(cells)
            curves = training_curves.curves(parsed, group, budget, runs) if parsed else None
        if curves is not None:
            self._passes("curves", curves)
        return curves

    def _arrays(self, group: TaskGroup, runs: Runs) -> None:
        policies: dict[str, PolicySummary] = {}
        for path in self.folder.files:
            is_array_file = path.startswith(f"{group.name}/") and path.endswith(".npz")
            if not is_array_file or (data := self._bytes(path)) is None:
                continue
            if self._passes("arrays", ArrayFile(path, data, group, runs)) and f"/{POLICIES}/" in path:
                arrays = read_arrays(data, MAX_UNPACKED_POLICY_BYTES)
                if self._passes("policy", PolicyFile(path, arrays)) and arrays is not None:
                    policies[path] = PolicySummary.of(Policy.from_arrays(arrays))
        folder = f"{group.name}/{POLICIES}/"
        names = frozenset(path.removeprefix(folder) for path in self.folder.files if path.startswith(folder))
        observes_task = toml.declared_task_in_evaluation(self.tables)
        evaluation = toml.declared_evaluation(self.tables)
        self._passes("policies", GroupPolicies(group, names, policies, runs, observes_task, evaluation))

    def _cells(self, path: str, header: tuple[str, ...]) -> Cells | None:
        """The cells of a CSV file: of all rows, or of those that can be read."""
        data = self._bytes(path)
        if data is None:
            return None
        text = Text(path, header, data)
        return Cells(path, columns(text)) if self._passes("text", text) else readable_rows(text)

    def _bytes(self, path: str) -> bytes | None:
        """The bytes of a file; None if there is none, it is too large, or it cannot be read (a problem)."""
        file = self.folder.files.get(path)
        if file is None or file.size > max_bytes(path):
            return None
        try:
            return self.folder.read(path)
        except OSError as error:
            self._passes("unreadable", UnreadableFile(path, error.strerror or type(error).__name__))
            return None

    def _passes(self, scope: Scope, subject: Any) -> bool:
        """Checks the rules of a scope, collects their problems, and returns whether there are none."""
        problems = rules.problems(scope, subject)
        self.problems += problems
        return not problems
