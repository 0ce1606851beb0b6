"""Rules about what a pull request changes together."""

from __future__ import annotations

from collections.abc import Iterator

from gym_extensions.curation.gate.changes import LEDGER, PullRequest, is_data
from gym_extensions.curation.gate.rules.rule import rule
from gym_extensions.rollouts.problem import Finding


@rule
def code_and_data(pull_request: PullRequest) -> Iterator[Finding]:
    """A pull request changes either submissions or the project's code, never both."""
    code = [path for path in pull_request.paths if not is_data(path)]
    if code:
        files = f"{len(code)} file{'s' * (len(code) > 1)}"
        message = f"It changes data and also {files} outside of submissions."
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
def outdated_entry(pull_request: PullRequest) -> Iterator[Finding]:
    """The entry has not changed on the base since the pull request started from it."""
    for name in pull_request.entries:
        folder = f"submissions/{name}"
        repository = pull_request.repository
        if repository.tree(pull_request.start, folder) != repository.tree(pull_request.base, folder):
            yield Finding(folder, "The entry was changed on the base meanwhile.", "Merge the base first.")
