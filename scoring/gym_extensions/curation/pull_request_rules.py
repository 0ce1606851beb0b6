"""What a pull request changes, from git's plumbing, and the rules that its changes keep to.

The docstring of a rule is its published text.
"""

import os
import re
import time
import unicodedata
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from gym_extensions.baselines import algorithms
from gym_extensions.catalog.protocol import IN_ORDER, PROTOCOLS
from gym_extensions.curation.gate_report import Kind
from gym_extensions.errors import BenchError
from gym_extensions.submissions import layout, manifest
from gym_extensions.submissions.characters import skeleton
from gym_extensions.submissions.problem import Finding, Rule, count, rule as registered
from gym_extensions.verification import git

RUN_FILE = re.compile(
    rf"submissions/[^/]+/([^/]+/(?:{'|'.join(PROTOCOLS)})/run\d+)\.(?:csv|json|npz|stage[^/]+\.onnx)"
)
"""The path of a file of a run; its group is the run's name in review.toml."""
LEARNED_IN_ORDER = re.compile(
    rf"submissions/[^/]+/(?:{layout.TRAINED}/\d+/)?[^/]+/({'|'.join(IN_ORDER)})/run\d+"
    r"\.(csv|npz|stage[1-9]\d*\.onnx)"
)
CODE = re.compile(rf"submissions/([^/]+)/{layout.AGENT}/")
DAYS_BETWEEN = 30
"""Between two versions of the code of a submission."""
COMPONENT = re.compile(r"[A-Za-z0-9_][A-Za-z0-9._-]*")
MAX_PATH = 200
"""Characters of a path."""


class ChangedFile(NamedTuple):
    """A changed file: git's letter (``A`` added, ``M`` modified, ``D`` deleted, ``T`` of another type, ``R``
    renamed), the new file mode, the path, and the old path of a renamed file.
    """

    status: str
    mode: str
    path: str
    source: str = ""


@dataclass(frozen=True)
class PullRequest:
    """The commits of a pull request: where it started, the branch that it is for, and its own last commit."""

    repository: git.Repository
    start: str
    base: str
    head: str

    @cached_property
    def changes(self) -> tuple[ChangedFile, ...]:
        """Its changed files, sorted by path. Files that moved with the same content are renames."""
        options = ("-r", "-z", "--raw", "--ignore-submodules=none", "-M100%")
        fields = iter(self.repository.run("diff-tree", *options, self.start, self.head).split(b"\0"))
        changes = []
        for meta in filter(None, fields):
            _, mode, _, _, status = meta.decode().split()
            paths = [os.fsdecode(next(fields)) for _ in range(2 if status[0] == "R" else 1)]
            changes.append(ChangedFile(status[0], mode, paths[-1], source=paths[0] if len(paths) > 1 else ""))
        return tuple(sorted(changes, key=lambda change: change.path))

    @cached_property
    def base_files(self) -> dict[str, git.TreeEntry]:
        """The files of submissions on the branch that it is for, by path."""
        return {file.path: file for file in self.repository.tree(self.base, "submissions")}

    @cached_property
    def head_files(self) -> dict[str, git.TreeEntry]:
        """The files of submissions in its last commit, by path."""
        return {file.path: file for file in self.repository.tree(self.head, "submissions")}

    @cached_property
    def base_titles(self) -> dict[str, str | None]:
        """The titles of submissions on the branch that it is for, by :meth:`titles_of`."""
        return self.titles_of(self.base_files.values())

    def titles_of(self, files: Iterable[git.TreeEntry]) -> dict[str, str | None]:
        """The title in every readable manifest by its path; None where a partial clone lacks the file."""
        found = dict[str, str | None]()
        for file in files:
            if file.path.split("/")[2:] != [layout.MANIFEST] or file.mode == git.SUBMODULE:
                continue
            try:
                (data,) = self.repository.blobs([file.object_id])
                if len(data) <= layout.max_bytes(layout.MANIFEST):
                    found[file.path] = manifest.manifest_of(manifest.parse(data)).title
            except BenchError as error:
                if error.code != "partial-clone":
                    raise
                found[file.path] = None
            except ValueError:  # also that of msgspec; a problem of the submission
                continue
        return found

    @cached_property
    def submissions(self) -> tuple[str, ...]:
        """The names of the submissions whose files it changes, sorted."""
        return tuple(sorted(_submissions(self.paths)))

    @cached_property
    def donated_runs(self) -> tuple[str, ...]:
        """The runs that it donates, by their names in review.toml; empty if it does anything else.

        It donates runs if it only adds files of runs that an existing submission of an agent of this project
        did not have.
        """
        adds_runs = all(change.status == "A" and RUN_FILE.fullmatch(change.path) for change in self.changes)
        if len(self.submissions) != 1 or not adds_runs:
            return ()
        data = self.repository.file(self.start, f"submissions/{self.submissions[0]}/{layout.MANIFEST}")
        try:
            protocol = manifest.manifest_of(manifest.parse(data or b"")).protocol
        except ValueError:  # also that of msgspec
            return ()
        if protocol.algorithm not in algorithms.names():
            return ()
        return self.changed_runs

    @property
    def changed_runs(self) -> tuple[str, ...]:
        """The runs of which it adds or changes a file, by their names in review.toml."""
        matches = (RUN_FILE.fullmatch(change.path) for change in self.changes)
        return tuple(sorted({match[1] for match in matches if match}))

    @property
    def kind(self) -> Kind:
        """What it changes; it changes data."""
        if not self.submissions:
            return "none"
        if self.donated_runs:
            return "donation"
        return "edit" if self.submissions[0] in _submissions(self.base_files) else "submission"

    @cached_property
    def paths(self) -> tuple[str, ...]:
        """Every path that it changes, old paths of renamed files included, sorted."""
        return tuple(sorted({path for item in self.changes for path in (item.path, item.source) if path}))

    def changes_code(self, submission: str) -> bool:
        """Whether it brings or changes the code of a submission: agent/, or the entry in the manifest."""
        folder, code = f"submissions/{submission}", self.repository.code
        return code(self.start, folder) != code(self.head, folder)

    def files_of(self, submission: str) -> tuple[git.TreeEntry, ...]:
        """The files of a submission with their sizes: in its last commit; of a donation, after its merge."""
        folder = f"submissions/{submission}"
        files = self.repository.tree(self.head, folder, sizes=True)
        if not self.donated_runs:
            return files
        donated = [file for file in files if file.path in self.paths]
        return (*self.repository.tree(self.base, folder, sizes=True), *donated)


def _submissions(paths: Iterable[str]) -> set[str]:
    parts = (path.split("/") for path in paths)
    return {names[1] for names in parts if names[0] == "submissions" and len(names) > 2}


def is_data(path: str) -> bool:
    """Whether a path is in the folder of submissions, in any letter case."""
    return path.split("/", maxsplit=1)[0].casefold() == "submissions"


RULES: dict[str, Rule] = {}
"""Every rule by name, in the order of their definition."""
rule = registered("pull request", RULES)


@rule
def code_and_data(pull_request: PullRequest) -> Iterator[Finding]:
    """A pull request changes either submissions or the project's code, never both."""
    code = [path for path in pull_request.paths if not is_data(path)]
    if code:
        message = f"It changes data and also {count(len(code), 'file')} outside of submissions."
        yield Finding(code[0], message, "Make two pull requests.")


@rule
def several_submissions(pull_request: PullRequest) -> Iterator[Finding]:
    """A pull request changes the folder of one submission."""
    submissions = pull_request.submissions
    if len(submissions) > 1:
        message = f"It changes {', '.join(submissions[:5])}{', …' if len(submissions) > 5 else ''}."
        yield Finding("submissions", message, "Make one pull request for each of them.")


@rule
def written_by_the_base(pull_request: PullRequest) -> Iterator[Finding]:
    """A pull request brings no review, poses, landscapes or diagnostics, nor anything in trained/: the base
    branch writes them."""
    for path in pull_request.paths:
        if {layout.REVIEW, *layout.WRITTEN}.intersection(path.split("/")[2:3]):
            hint = "Leave it as it is on the base. It is written after the merge, decisions by an owner."
            yield Finding(path, "It is written on the base branch only.", hint)


@rule
def stray_file(pull_request: PullRequest) -> Iterator[Finding]:
    """Every file belongs to a submission, also a policy that beats an expert (docs/experts.md)."""
    for path in pull_request.paths:
        names = path.split("/")
        if is_data(path) and not (names[0] == "submissions" and len(names) > 2):
            hint = "Move it into the folder of the submission, or leave it out."
            yield Finding(path, "The file belongs to no submission.", hint)


@rule
def outdated_submission(pull_request: PullRequest) -> Iterator[Finding]:
    """The submission has not changed on the base since the pull request started from it. (A pull request that
    only donates runs may be older.)"""
    for name in () if pull_request.donated_runs else pull_request.submissions:
        folder, tree = f"submissions/{name}", pull_request.repository.tree
        if tree(pull_request.start, folder) != tree(pull_request.base, folder):
            message = "The submission was changed on the base meanwhile."
            yield Finding(folder, message, "Rebase the branch on the base's branch.")


@rule
def own_merge(pull_request: PullRequest) -> Iterator[Finding]:
    """No merge commit of the pull request brings the submission's changes. (Seeds follow from the commit that
    merges them, and after a fast-forward it would be one that its author made.)"""
    run, span = pull_request.repository.run, f"{pull_request.base}..{pull_request.head}"
    manifests = (f"submissions/{name}/{layout.MANIFEST}" for name in pull_request.submissions)
    fixing = {*pull_request.paths, *manifests}
    merges = run("rev-list", "--first-parent", "--merges", span, "--", ":(top)submissions")
    for merge in merges.decode().split():
        changed = run("diff-tree", "-r", "-z", "--name-only", f"{merge}^1", merge)
        for path in sorted(fixing.intersection(map(os.fsdecode, changed.split(b"\0"))))[:1]:
            message = f"The merge commit {merge[:12]} changes it."
            yield Finding(path, message, "Rebase the branch on the base's branch.")


@rule
def donated_twice(pull_request: PullRequest) -> Iterator[Finding]:
    """A donated run is not on the base: a run is deterministic, and the first one stands."""
    if not pull_request.donated_runs:
        return
    theirs, ours = pull_request.base_files, pull_request.head_files
    for path in pull_request.paths:
        if path in theirs:
            how = "the same" if theirs[path].object_id == ours[path].object_id else "other"
            message = f"The run was donated meanwhile, with {how} content."
            differ = "If they differ, open an issue with both documents: one machine is wrong."
            yield Finding(path, message, f"Donate another run. {differ}")


@rule
def path_characters(pull_request: PullRequest) -> Iterator[Finding]:
    """Names have ASCII letters, digits, dots, dashes and underscores, start with no dot or dash, and are
    not reserved on some system (CON, NUL, …; a dot at the end). A path has at most 200 characters."""
    for change in pull_request.changes:
        names = change.path.split("/")
        is_plain = all(map(COMPONENT.fullmatch, names)) and len(change.path) <= MAX_PATH
        if not is_plain or any(map(layout.is_reserved, names)):
            message = "A name is reserved, has other characters, starts with a dot or dash, or is too long."
            hint = "Use letters, digits, dots, dashes and underscores, at most 200 in all."
            yield Finding(change.path[:MAX_PATH], message, hint)


@rule
def submission_name(pull_request: PullRequest) -> Iterator[Finding]:
    """The name of a submission has 1 to 64 such characters, of which the first is a letter or digit."""
    for name in pull_request.submissions:
        if not layout.NAME.fullmatch(name):
            yield Finding(f"submissions/{name}", "It is not a name of a submission.", layout.NAME_HINT)


@rule
def case_collision(pull_request: PullRequest) -> Iterator[Finding]:
    """No two paths differ only in letter case or Unicode spelling, among all submissions."""
    spellings: dict[str, str] = {}
    changed = {change.path for change in pull_request.changes}
    for path in (*pull_request.base_files, *pull_request.head_files):
        names = path.split("/")
        for depth in range(1, len(names) + 1):
            part = "/".join(names[:depth])
            first = spellings.setdefault(unicodedata.normalize("NFKC", part).casefold(), part)
            if first != part and path in changed:
                yield Finding(path, f"{part} and {first} differ only in letter case.", "Rename it.")
                break


@rule
def file_mode(pull_request: PullRequest) -> Iterator[Finding]:
    """Files are regular and not executable (mode 100644). Symbolic links and submodules are refused."""
    for change in pull_request.changes:
        if change.status != "D" and change.mode != "100644":
            kind = {"120000": "a symbolic link", git.SUBMODULE: "a submodule"}.get(change.mode, "executable")
            hint = "Add the files themselves, without permission to execute (`git update-index --chmod=-x`)."
            yield Finding(change.path, f"It is {kind}.", hint)


@rule
def deleted_file(pull_request: PullRequest) -> Iterator[Finding]:
    """No file is deleted or renamed, but files of agent/ if others of it remain. (A maintainer's decision
    withdraws a submission.)"""
    code, head = pull_request.repository.code, pull_request.head
    with_code = {name for name in pull_request.submissions if code(head, f"submissions/{name}")}
    for change in pull_request.changes:
        match = CODE.match(change.source or change.path)
        if match and match[1] in with_code:
            continue
        if change.source:
            yield Finding(change.path, f"It was renamed from {change.source}.", "Keep the old name.")
        elif change.status == "D" and is_data(change.path):
            hint = "Restore it. To withdraw a submission, ask a maintainer for a decision."
            yield Finding(change.path, "It was deleted.", hint)


@rule
def next_version(pull_request: PullRequest) -> Iterator[Finding]:
    """A new version of the code, agent/ or its entry, comes at least 30 days after the one before: each is
    trained, and the best of many would be luck."""
    repository = pull_request.repository
    for name in pull_request.submissions:
        folder = f"submissions/{name}"
        is_new = pull_request.changes_code(name)
        if is_new and (before := repository.code_commit(pull_request.base, folder)):
            seconds = time.time() - float(repository.run("show", "-s", "--format=%ct", before))
            if seconds < DAYS_BETWEEN * 86400:
                message = f"The version before was merged {count(int(seconds // 86400), 'day')} ago."
                hint = f"After {DAYS_BETWEEN} days, close and reopen the pull request."
                yield Finding(f"{folder}/{layout.AGENT}", message, hint)


@rule
def copied_run(pull_request: PullRequest) -> Iterator[Finding]:
    """No log of tasks that are learned one after another, and no policies of its runs, equal those of another
    one of the same protocol, byte for byte. (Training on one task alone, or on all together, gives the same
    bytes for methods that differ only between tasks.)"""
    theirs = {}
    for path, file in pull_request.base_files.items():
        if match := LEARNED_IN_ORDER.fullmatch(path):
            theirs[file.object_id, match[1]] = path
    for path in (change.path for change in pull_request.changes if change.path in pull_request.head_files):
        if match := LEARNED_IN_ORDER.fullmatch(path):
            original = theirs.get((pull_request.head_files[path].object_id, match[1]), path)
            if original != path:
                yield Finding(path, f"It is the same as {original}.", "Submit your own runs.")


@rule
def same_title(pull_request: PullRequest) -> Iterator[Finding]:
    """The title looks like that of no other submission, whatever its letter case and letters that look
    alike."""
    others = {
        skeleton(title): path
        for path, title in pull_request.base_titles.items()
        if title and path.split("/")[1] not in pull_request.submissions
    }
    own = (file for path, file in pull_request.head_files.items() if path in pull_request.paths)
    for path, title in pull_request.titles_of(own).items():
        if title and (other := others.get(skeleton(title))):
            yield Finding(path, f"The title looks like that of {other}.", "Choose another one.")


@rule
def too_large(pull_request: PullRequest) -> Iterator[Finding]:
    """A submission keeps to the limits of docs/rollout-log.md on sizes and on the number of files."""
    for name in pull_request.submissions:
        files = pull_request.files_of(name)
        total = sum(file.size or 0 for file in files)
        if len(files) > layout.MAX_FILES or total > layout.MAX_SUBMISSION_BYTES:
            message = f"It has {len(files)} files with {total} bytes; the limits are {layout.LIMITS}."
            yield Finding(f"submissions/{name}", message, "Leave out what is not part of a submission.")
        for file in files:
            if (file.size or 0) > (limit := layout.max_bytes(file.path.split("/", 2)[2])):
                hint = "See the limits in docs/rollout-log.md."
                yield Finding(file.path, f"It has {file.size} bytes; the limit is {limit}.", hint)
