"""Rules about the kinds, changes, sizes and contents of files."""

from __future__ import annotations

from collections.abc import Iterator

from gym_extensions.curation.challenges import MAX_BYTES as MAX_CHALLENGE_BYTES
from gym_extensions.curation.gate.changes import LEDGER, PullRequest, is_data, is_trace
from gym_extensions.curation.gate.rules.rule import rule
from gym_extensions.curation.ledger.chain import MAX_BYTES as MAX_LEDGER_BYTES
from gym_extensions.rollouts.layout import LOGS, MAX_FILES, MAX_SUBMISSION_BYTES, max_bytes
from gym_extensions.rollouts.problem import Finding

REGULAR = "100644"
LINK, SUBMODULE = "120000", "160000"


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
def copied_log(pull_request: PullRequest) -> Iterator[Finding]:
    """No log of a new entry equals one of another entry, byte for byte."""
    new = [name for name in pull_request.entries if name not in pull_request.base_entries]
    logs = {file.object_id: file.path for file in pull_request.base_files if _is_log(file.path)}
    for file in (file for name in new for file in pull_request.files_of(name)):
        if _is_log(file.path) and file.object_id in logs:
            message = f"It is the same as {logs[file.object_id]}."
            yield Finding(file.path, message, "Submit your own runs.")


def _is_log(path: str) -> bool:
    return path.rpartition("/")[2] in LOGS


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
