"""Reads a submission's folder and reports all its problems at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from gym_extensions.catalog.budgets import Budget
from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.rollouts import declared, layout
from gym_extensions.rollouts.checked_folder import CheckedFolder
from gym_extensions.rollouts.episodes import (
    CURVE_COLUMNS,
    EPISODE_COLUMNS,
    EVALUATION_COLUMNS,
    UNBOUND_COLUMNS,
)
from gym_extensions.rollouts.folder import Folder, scan
from gym_extensions.rollouts.identical_runs import merge_identical_runs
from gym_extensions.rollouts.manifest import Manifest, manifest_of
from gym_extensions.rollouts.policies import Policy
from gym_extensions.rollouts.problem import summarize
from gym_extensions.rollouts.reading import evaluation_log, interim_evaluations, training_curves
from gym_extensions.rollouts.reading.evaluation_log import Cells, Log, Runs, has_prescribed_keys
from gym_extensions.rollouts.reading.interim_evaluations import Evaluations
from gym_extensions.rollouts.reading.salvage import fully_parsed_rows, key_parsed_rows
from gym_extensions.rollouts.reading.toml_text import parse
from gym_extensions.rollouts.reading.training_curves import Curves
from gym_extensions.rollouts.rules.consistency import CommittedTraces, ManifestInFolder
from gym_extensions.rollouts.rules.folder import SaltFile
from gym_extensions.rollouts.rules.npz import ArrayFile
from gym_extensions.rollouts.rules.policies import GroupPolicies, PolicyFile, PolicySummary
from gym_extensions.rollouts.rules.rule import Scope
from gym_extensions.rollouts.rules.runs import GroupLogs
from gym_extensions.rollouts.safe_npz import read as read_arrays
from gym_extensions.rollouts.submission import Submission, SubmittedGroup
from gym_extensions.rollouts.trace_reader import with_evidence

Rows = TypeVar("Rows", Curves, Evaluations)
Parse = Callable[[Cells, TaskGroup, Budget | None, Runs], Rows]
PARSE_ERRORS = (ValueError, KeyError, OverflowError)
"""Raised for a cell of the wrong kind."""


def read(path: Path, groups: Mapping[str, TaskGroup] = GROUPS, *, merge_runs: bool = True) -> Submission:
    """The submission in a folder. With problems, it holds all of them and what could be read.

    At most ``PROBLEMS_LISTED`` problems are listed per rule; the rest are counted.

    Args:
        path: the submission's folder.
        groups: the groups that it may contain, by name.
        merge_runs: whether identical runs of an agent without parameters count as one.
    """
    return _Reader(scan(path, groups)).submission(merge_runs)


class _Reader(CheckedFolder):
    """Reads one folder part by part and collects the problems of each."""

    def __init__(self, folder: Folder) -> None:
        super().__init__(folder)
        self.tables: dict[str, Any] = {}

    def submission(self, merge_runs: bool) -> Submission:
        self.passes("folder", self.folder)
        if not self.folder.size.is_within_limits:
            return Submission(self.folder.name, None, {}, summarize(self.problems, self.folder.name))
        manifest = self._manifest()
        readme = self._readme()
        paths = {item.path for item in self.folder.items}
        groups = {group.id: self._group(group) for name, group in self.folder.groups.items() if name in paths}
        if manifest is not None and not self.problems:
            by_name = sorted(groups.values(), key=lambda group: group.group.name)
            logs = (log for group in by_name for log in group.logs.values())
            root = manifest.traces.root if manifest.traces else None
            self.passes("traces", CommittedTraces(root, tuple(log.trace for log in logs)))
        if merge_runs and not self.problems and not declared.trainable_of(self.tables):
            groups = {group_id: merge_identical_runs(group) for group_id, group in groups.items()}
        if not self.problems:
            groups = {group_id: with_evidence(group, self.folder) for group_id, group in groups.items()}
        problems = summarize(self.problems, self.folder.name)
        return Submission(self.folder.name, manifest, groups, problems, readme)

    def _manifest(self) -> Manifest | None:
        data = self.bytes_of(layout.MANIFEST)
        if data is None or not self.passes("manifest bytes", data):
            return None
        self.tables = parse(data)
        manifest = manifest_of(self.tables) if self.passes("manifest", self.tables) else None
        self.passes("manifest in folder", ManifestInFolder(self.folder, self.tables))
        return manifest

    def _readme(self) -> str:
        data = self.bytes_of(layout.README)
        if data is None or not self.passes("readme", data):
            return ""
        return data.decode("utf-8").replace("\r\n", "\n")

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
        is_trainable = declared.trainable_of(self.tables)
        self.passes("group", GroupLogs(group.name, measured, named_runs, is_trainable))
        curves = self._curves(group, known_runs)
        evaluations = self._evaluations(group, known_runs)
        self._arrays(group, known_runs)
        path = f"{group.name}/{layout.TRACES}/{layout.SALT_FILE}"
        if (data := self.bytes_of(path)) is not None:
            self.passes("salt", SaltFile(path, data))
        return SubmittedGroup(group, logs, curves, evaluations=evaluations)

    def _unknown_runs(self, group: TaskGroup) -> Runs:
        """The logs that curves and traces may belong to: all, if the group's folder has a problem."""
        has_problem = any(problem.where.startswith(f"{group.name}/") for problem in self.problems)
        logs = [name for name in PROTOCOLS if has_problem or f"{group.name}/{name}.csv" in self.folder.files]
        return dict.fromkeys(logs or PROTOCOLS)

    def _log(self, group: TaskGroup, protocol: str) -> tuple[Log | None, Log | None]:
        """The rows of a log whose keys can be parsed, and those that can be parsed fully."""
        cells = self.cells_of(f"{group.name}/{protocol}.csv", EPISODE_COLUMNS, UNBOUND_COLUMNS)
        if cells is None:
            return None, None
        try:
            keys: Log | None = evaluation_log.log(cells, protocol, group)
            values = keys
        except PARSE_ERRORS:
            if self.passes("cells", cells):
                raise
            keys, values = (
                evaluation_log.log(part, protocol, group) if part else None
                for part in (key_parsed_rows(cells), fully_parsed_rows(cells))
            )
        if keys is not None and not self.passes("runs", keys):
            return None, None
        if keys is not None and not has_prescribed_keys(keys):
            self.passes("keys", keys)
        if values is not None:
            self.passes("log", values)
        return keys, values

    def _curves(self, group: TaskGroup, runs: Runs) -> Curves | None:
        path = f"{group.name}/{layout.CURVES}"
        return self._optional(path, CURVE_COLUMNS, training_curves.curves, "curves", (group, runs))

    def _evaluations(self, group: TaskGroup, runs: Runs) -> Evaluations | None:
        path, parse = f"{group.name}/{layout.EVALUATIONS}", interim_evaluations.evaluations
        return self._optional(path, EVALUATION_COLUMNS, parse, "evaluations", (group, runs))

    def _optional(
        self,
        path: str,
        header: tuple[str, ...],
        parse: Parse[Rows],
        scope: Scope,
        context: tuple[TaskGroup, Runs],
    ) -> Rows | None:
        """The rows of a file that a group may have, or those that can be parsed."""
        cells: Cells | None = self.cells_of(path, header)
        if cells is None:
            return None
        (group, runs), budget = context, declared.budget_of(self.tables)
        try:
            rows = parse(cells, group, budget, runs)
        except PARSE_ERRORS:
            if self.passes("cells", cells):
                raise
            cells = fully_parsed_rows(cells)
            if cells is None:
                return None
            rows = parse(cells, group, budget, runs)
        self.passes(scope, rows)
        return rows

    def _arrays(self, group: TaskGroup, runs: Runs) -> None:
        policies: dict[str, PolicySummary] = {}
        for path in self.folder.files:
            is_array_file = path.startswith(f"{group.name}/") and path.endswith(".npz")
            if not is_array_file or (data := self.bytes_of(path)) is None:
                continue
            if self.passes("arrays", ArrayFile(path, data, group, runs)) and f"/{layout.POLICIES}/" in path:
                arrays = read_arrays(data, layout.MAX_UNPACKED_POLICY_BYTES)
                if self.passes("policy", PolicyFile(path, arrays)) and arrays is not None:
                    policies[path] = PolicySummary.of(Policy.from_arrays(arrays))
        folder = f"{group.name}/{layout.POLICIES}/"
        names = frozenset(path.removeprefix(folder) for path in self.folder.files if path.startswith(folder))
        observes_task = declared.task_in_evaluation_of(self.tables)
        evaluation = declared.evaluation_of(self.tables)
        self.passes("policies", GroupPolicies(group, names, policies, runs, observes_task, evaluation))
