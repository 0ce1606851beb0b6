"""The rules of a pull request with data, one function each, whose docstring is the published text."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Iterator

from gym_extensions.curation.challenges import MAX_BYTES as MAX_CHALLENGE_BYTES
from gym_extensions.curation.gate.changes import LEDGER, PullRequest, is_data, is_trace
from gym_extensions.curation.ledger.chain import MAX_BYTES as MAX_LEDGER_BYTES
from gym_extensions.rollouts.layout import MAX_FILES, MAX_SUBMISSION_BYTES, NAME, max_bytes
from gym_extensions.rollouts.problem import Finding, Problem

Rule = Callable[[PullRequest], Iterator[Finding]]

REGULAR = "100644"
LINK, SUBMODULE = "120000", "160000"
COMPONENT = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")
MAX_PATH = 200
"""Characters of a path."""
RESERVED = frozenset(
    ["CON", "PRN", "AUX", "NUL", *(f"{name}{digit}" for name in ("COM", "LPT") for digit in range(10))]
)
"""Names that Windows reserves for devices, with any ending."""

RULES: dict[str, Rule] = {}
"""Every rule by name, in the order of their definition."""


def rule(function: Rule) -> Rule:
    """Registers a rule; its name is the function's with dashes."""
    RULES[function.__name__.replace("_", "-")] = function
    return function


def broken_rules(pull_request: PullRequest) -> list[Problem]:
    """The problems of a pull request that changes data."""
    return [
        Problem(name, finding.where, finding.message, finding.hint)
        for name, function in RULES.items()
        for finding in function(pull_request)
    ]


@rule
def code_and_data(pull_request: PullRequest) -> Iterator[Finding]:
    """A pull request changes either submissions or the project's code, never both."""
    code = [path for path in pull_request.paths if not is_data(path)]
    if code:
        message = f"It changes data and also {len(code)} files outside of submissions."
        yield Finding(code[0], message, "Make two pull requests.")


@rule
def several_entries(pull_request: PullRequest) -> Iterator[Finding]:
    """A pull request changes the folder of one entry, or the ledger, or challenges."""
    parts = [*pull_request.entries, *(["the ledger"] if LEDGER in pull_request.paths else [])]
    parts += ["challenges"] if any(path.startswith("challenges/") for path in pull_request.paths) else []
    if len(parts) > 1:
        message = f"It changes {', '.join(parts[:5])}{', …' if len(parts) > 5 else ''}."
        hint = "Make one pull request for each. Maintainers append to the ledger after a merge."
        yield Finding("submissions", message, hint)


@rule
def stray_file(pull_request: PullRequest) -> Iterator[Finding]:
    """The folder of submissions contains only folders of entries and the ledger, named in lower case."""
    for path in pull_request.paths:
        names = path.split("/")
        inside = names[0] == "challenges" or path == LEDGER or (names[0] == "submissions" and len(names) > 2)
        if is_data(path) and not inside:
            yield Finding(path, "The file belongs to no entry.", "Move it into the folder of the entry.")


@rule
def symbolic_link(pull_request: PullRequest) -> Iterator[Finding]:
    """No file is a symbolic link."""
    for change in pull_request.changes:
        if change.mode == LINK:
            yield Finding(change.path, "It is a symbolic link.", "Replace it by the file.")


@rule
def submodule(pull_request: PullRequest) -> Iterator[Finding]:
    """No folder is a submodule."""
    for change in pull_request.changes:
        if change.mode == SUBMODULE:
            yield Finding(change.path, "It is a submodule.", "Add the files themselves.")


@rule
def file_mode(pull_request: PullRequest) -> Iterator[Finding]:
    """Files have the mode 100644: they are not executable."""
    for change in pull_request.changes:
        if change.status != "D" and change.mode not in (REGULAR, LINK, SUBMODULE):
            message = f"Its mode is {change.mode} instead of {REGULAR}."
            yield Finding(change.path, message, f"Run `git update-index --chmod=-x {change.path}`.")


@rule
def renamed_file(pull_request: PullRequest) -> Iterator[Finding]:
    """No file is renamed. (Traces of an entry may be replaced.)"""
    for change in pull_request.changes:
        if change.source and not (is_trace(change.path) and is_trace(change.source)):
            yield Finding(change.path, f"It was renamed from {change.source}.", "Keep the old name.")


@rule
def deleted_file(pull_request: PullRequest) -> Iterator[Finding]:
    """No file is deleted. (Traces may be replaced; an entry leaves the boards by a line of the ledger.)"""
    for change in pull_request.changes:
        if change.status == "D" and is_data(change.path) and not is_trace(change.path):
            hint = "Restore it. To withdraw an entry, ask a maintainer for a line in the ledger."
            yield Finding(change.path, "It was deleted.", hint)


@rule
def reserved_name(pull_request: PullRequest) -> Iterator[Finding]:
    """No file or folder has a name that some system reserves (CON, NUL, …) or ends in a dot or space."""
    for change in pull_request.changes:
        for name in change.path.split("/"):
            if name.split(".")[0].upper().rstrip() in RESERVED or name.endswith((".", " ")):
                yield Finding(change.path, f"The name {name!r} is reserved on some systems.", "Rename it.")


@rule
def path_characters(pull_request: PullRequest) -> Iterator[Finding]:
    """Names have ASCII letters, digits, dots, dashes and underscores, and start with a letter or digit. A
    path has at most 200 characters."""
    for change in pull_request.changes:
        if not all(map(COMPONENT.fullmatch, change.path.split("/"))) or len(change.path) > MAX_PATH:
            hint = "Use letters, digits, dots, dashes and underscores, at most 200 in all."
            yield Finding(change.path[:MAX_PATH], "The path has other characters or is too long.", hint)


@rule
def entry_name(pull_request: PullRequest) -> Iterator[Finding]:
    """The name of an entry is that of a submission's folder: 1 to 64 such characters."""
    for name in pull_request.entries:
        if not NAME.fullmatch(name):
            yield Finding(f"submissions/{name[:MAX_PATH]}", "It is not a name of an entry.", "Rename it.")


@rule
def outdated_entry(pull_request: PullRequest) -> Iterator[Finding]:
    """The entry has not changed on the base since the pull request started from it."""
    for name in pull_request.entries:
        folder = f"submissions/{name}"
        repository = pull_request.repository
        if repository.tree(pull_request.start, folder) != repository.tree(pull_request.base, folder):
            yield Finding(folder, "The entry was changed on the base meanwhile.", "Merge the base first.")


def _fold(path: str) -> str:
    return unicodedata.normalize("NFKC", path).casefold()


@rule
def case_collision(pull_request: PullRequest) -> Iterator[Finding]:
    """No two paths differ only in letter case or Unicode spelling, among all entries."""
    spellings: dict[str, str] = {}
    changed = {change.path for change in pull_request.changes}
    for entry in (*pull_request.base_files, *pull_request.head_files):
        names = entry.path.split("/")
        for depth in range(1, len(names) + 1):
            path = "/".join(names[:depth])
            first = spellings.setdefault(_fold(path), path)
            if first != path and entry.path in changed:
                yield Finding(entry.path, f"{path} and {first} differ only in letter case.", "Rename it.")
                break


@rule
def too_large(pull_request: PullRequest) -> Iterator[Finding]:
    """An entry keeps to the limits of docs/rollout-log.md on sizes and on the number of files."""
    for name in pull_request.entries:
        files = pull_request.files_of(name)
        total = sum(file.size or 0 for file in files)
        if len(files) > MAX_FILES or total > MAX_SUBMISSION_BYTES:
            message = f"It has {len(files)} files with {total} bytes."
            yield Finding(f"submissions/{name}", message, "Leave out what is not part of a submission.")
    changed = {change.path for change in pull_request.changes}
    for file in pull_request.head_files:
        limit = _max_bytes(file.path)
        if file.path in changed and (file.size or 0) > limit:
            message = f"It has {file.size} bytes; the limit is {limit}."
            yield Finding(file.path, message, "See the limits in docs/rollout-log.md.")


def _max_bytes(path: str) -> int:
    if path == LEDGER:
        return MAX_LEDGER_BYTES
    return MAX_CHALLENGE_BYTES if path.startswith("challenges/") else max_bytes(path)
