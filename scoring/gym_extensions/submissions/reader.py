"""Reads a submission's folder and reports all its problems at once."""

import hashlib
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.catalog.protocol import BUDGETS, PROTOCOLS
from gym_extensions.errors import BenchError
from gym_extensions.submissions import layout, problem, rules
from gym_extensions.submissions.layout import DOCUMENT, LOG, POLICIES, Folder, run_file, scan
from gym_extensions.submissions.log import TableError, log_frame, log_of
from gym_extensions.submissions.manifest import manifest_of, parse
from gym_extensions.submissions.policies import files
from gym_extensions.submissions.review import Review, about, code_digest, review_of, training_of
from gym_extensions.submissions.rules.policies import RunPolicies
from gym_extensions.submissions.rules.run_document import SubmittedRun
from gym_extensions.submissions.run import RunDocument, run_of
from gym_extensions.submissions.submission import Submission, SubmittedGroup, Trained

if TYPE_CHECKING:
    import pandas as pd

Parsed = TypeVar("Parsed")
NOT_OF_TRAINED = ("gaps-in-runs", "identical-runs")
"""Rules that need not hold for runs that are trained here: they finish in any order, and failed ones are
those of an agent that always does the same."""


def read(
    path: Path,
    groups: Mapping[str, TaskGroup] = GROUPS,
    *,
    policies: bool = False,
    only: Collection[str] | None = None,
) -> Submission:
    """The submission in a folder. With problems, it holds all of them and what could be read.

    At most ``PROBLEMS_LISTED`` problems are listed per rule; the rest are counted.

    Args:
        path: the submission's folder.
        groups: the groups that it may contain, by name.
        policies: whether the policies are read and checked, too. Without, their presence is, and the digest
            of those that are ONNX networks.
        only: the names of the groups whose runs are read; None for all.
    """
    wanted = groups if only is None else {name: group for name, group in groups.items() if name in only}
    return _Reader(scan(path, groups)).submission(wanted, policies)


class _Reader:
    """Reads one folder part by part and collects the problems of each."""

    def __init__(self, folder: Folder, ignored: tuple[str, ...] = ()) -> None:
        """``ignored`` names rules that need not hold."""
        self.folder, self.ignored = folder, ignored
        self.problems: list[problem.Problem] = []
        self.tables: dict[str, Any] = {}

    def submission(self, wanted: Mapping[str, TaskGroup], policies: bool) -> Submission:
        name = self.folder.name
        self._check("folder", self.folder)
        if not self.folder.is_within_limits:
            return Submission(name, None, {}, problem.summarize(self.problems, name), path=self.folder.root)
        tables = self._parsed("toml", layout.MANIFEST, self._bytes(layout.MANIFEST), parse)
        self.tables = tables or {}
        is_valid = tables is not None and self._check("manifest", self.folder, tables)
        manifest = manifest_of(self.tables) if is_valid else None
        data = self._bytes(layout.README)
        is_text = data is not None and self._check("readme", data)
        readme = data.decode("utf-8").replace("\r\n", "\n") if data and is_text else ""
        review = self._parsed("review", layout.REVIEW, self._bytes(layout.REVIEW), review_of) or Review()
        code = [path for path in self.folder.files if path.startswith(f"{layout.AGENT}/")]
        sources = {path: data for path in code if (data := self._bytes(path)) is not None}
        if code or "agent" in self.tables:
            self._check("agent", sources, self._section("agent"))
        paths = {item.path for item in self.folder.items}
        present = [group for folder, group in wanted.items() if folder in paths]
        groups = {group.id: self._group(group, policies) for group in present}
        trained = self._trained(wanted, policies)
        problems = problem.summarize(self.problems, name)
        entry = str(self._declared("agent", "entry") or "")
        digest, root = code_digest(sources, entry), self.folder.root
        found = Submission(name, manifest, groups, problems, readme, review, root, digest, trained)
        return replace(found, review=about(review, manifest.digest, found.documents)) if manifest else found

    def _trained(self, wanted: Mapping[str, TaskGroup], policies: bool) -> Trained | None:
        """What the base trained of the last version of the code; None without anything."""
        version = layout.latest_version(self.folder.files)
        path = f"{layout.TRAINED}/{version}"
        training = self._parsed("training", f"{path}.toml", self._bytes(f"{path}.toml"), training_of)
        if training is None:
            return None
        folder = scan(self.folder.root / path, self.folder.groups)
        runs = Submission(folder.name, None, {}, path=folder.root)
        if layout.MANIFEST in folder.files:  # else no run has finished yet
            runs = _Reader(folder, NOT_OF_TRAINED).submission(wanted, policies)
        self.problems += [replace(each, where=f"{path}/{each.where}") for each in runs.problems]
        return Trained(version, training, runs)

    def _check(self, scope: problem.Scope, *subject: object) -> bool:
        """Collects the problems of a scope's rules, and returns whether there are none."""
        found = [each for each in rules.problems(scope, *subject) if each.rule not in self.ignored]
        self.problems += found
        return not found

    def _broken(self, rule: str, where: str, reason: str) -> None:
        """Collects the problem of a file that cannot be read, or of its line, for a reason in a sentence."""
        self.problems.append(problem.Problem(rule, where, reason, rules.folder.BROKEN_FILES[rule][1]))

    def _bytes(self, path: str) -> bytes | None:
        """The bytes of a file; None if there is none, it is too large, or it cannot be read (a problem)."""
        file, limit = self.folder.files.get(path), layout.max_bytes(path)
        if file is None or file.size > limit:
            return None
        try:
            return layout.read_regular(self.folder.root / path, limit)
        except OSError as error:
            reason = f"The file cannot be read: {error.strerror or type(error).__name__}."
            self._broken("unreadable-file", path, reason)
            return None

    def _parsed(
        self, kind: str, path: str, data: bytes | None, parse: Callable[[bytes], Parsed]
    ) -> Parsed | None:
        """What a file's bytes hold; None if there are none or they are broken (a problem)."""
        if data is None:
            return None
        try:
            return parse(data)
        except TableError as error:
            self._broken(f"malformed-{kind}", f"{path}, line {error.line}", error.message)
        except (ValueError, RecursionError) as error:
            reason = str(error) or "It is nested too deeply"
            self._broken(f"malformed-{kind}", path, f"{reason[:300].rstrip('.')}.")
        return None

    def _section(self, name: str) -> dict[str, Any] | None:
        """A section of the manifest, which may be wrong elsewhere; None without it."""
        table = self.tables.get(name)
        return table if isinstance(table, dict) else None

    def _declared(self, section: str, key: str) -> Any:
        """The value of a key in the manifest, which may be wrong elsewhere; None without it."""
        return (self._section(section) or {}).get(key)

    def _group(self, group: TaskGroup, policies: bool) -> SubmittedGroup:
        before = len(self.problems)
        submitted: list[SubmittedRun] = []
        documents: dict[str, dict[int, RunDocument]] = {}
        frames: dict[str, dict[int, pd.DataFrame]] = {}
        for protocol in PROTOCOLS:
            for number in self.folder.runs.get((group.name, protocol), {}):
                run, frame = self._run(group, protocol, number, submitted)
                if run is not None:
                    submitted.append(run)
                    documents.setdefault(protocol, {})[number] = run.document
                if frame is not None:
                    frames.setdefault(protocol, {})[number] = frame
        logs = {protocol: log_of(parts, protocol, group) for protocol, parts in frames.items()}
        for log in logs.values():
            self._check("log", rules.log.compared_rows(log), log)
        self._policies(submitted, policies)
        return SubmittedGroup(group, {} if len(self.problems) > before else logs, documents)

    def _run(
        self, group: TaskGroup, protocol: str, run: int, earlier: Sequence[SubmittedRun]
    ) -> "tuple[SubmittedRun | None, pd.DataFrame | None]":
        """A run with its document, and the rows of its log; None for what is missing or broken."""
        log_path, path = (run_file(group.name, protocol, run, suffix) for suffix in (LOG, DOCUMENT))
        log = self._bytes(log_path)
        frame = self._parsed("log", log_path, log, log_frame)
        document = self._parsed("document", path, self._bytes(path), run_of)
        if document is None:
            return None, frame
        budget = self._declared("protocol", "budget")
        suffixes = self.folder.runs[group.name, protocol][run] - {LOG, DOCUMENT}
        paths = {suffix: run_file(group.name, protocol, run, suffix) for suffix in suffixes}
        submitted = SubmittedRun(
            *(group, protocol, run, document),
            log_sha256=hashlib.sha256(log).hexdigest() if log is not None else "",
            policies={suffix: self.folder.files[path].size for suffix, path in paths.items()},
            budget=BUDGETS.get(budget) if isinstance(budget, str) else None,
            fingerprints=(earlier[0].document if earlier else document).fingerprints,
        )
        self._check("document", submitted)
        return submitted, frame

    def _policies(self, runs: Sequence[SubmittedRun], whole: bool) -> None:
        """Checks the policies of a group; if not the whole, the form of .npz files, digests of networks."""
        first: files.AnyPolicy | None = None
        sketches: dict[str, dict[int, files.Sketches]] = {run.protocol: {} for run in runs}
        observes_task = self._declared("observes", "task_in_evaluation")
        evaluation = self._declared("protocol", "evaluation")
        for run in runs:
            if run.document.policies is None or run.document.policies.url:
                continue
            path = run.file(POLICIES)
            if POLICIES in run.policies and not whole:  # it is not unpacked
                data = self._bytes(path)
                if data is not None and (error := files.npz_error(data)):
                    self._broken("malformed-policies", path, f"It cannot be read: {error}.")
                continue
            if files.missing_networks(run.policies, run.group, run.protocol):
                continue  # a problem of the document
            try:
                arrays = files.read_arrays(self.folder.root, run.group, run.protocol, run.run)
            except BenchError as error:
                path = Path(error.where).relative_to(self.folder.root).as_posix()
                self._broken("malformed-policies", path, error.message)
                continue
            earlier = sketches[run.protocol]
            stored = RunPolicies(run, arrays, whole, first, earlier, observes_task, evaluation)
            self._check("policies", stored)
            earlier[run.run] = stored.sketches
            sized = (each for each in stored.policies.values() if each.num_inputs is not None)
            first = first or next(sized, None)
