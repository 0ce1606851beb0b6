"""The salt of an audit sample: it follows from the submission and from a value that is known only later."""

from __future__ import annotations

import hashlib
import re
from pathlib import PurePosixPath

from gym_extensions.curation.git import Repository
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.layout import POLICIES, TRACES

VALUE = re.compile(r"[0-9a-f]{40,128}")


def derive_salt(digest: str, value: str) -> str:
    """The SHA-256 of the digest of a submission followed by a value, both as hexadecimal text.

    Args:
        digest: the submission's digest without its traces.
        value: a number that nobody knew before the submission was fixed: the commit that merged it, or a
            round of a public random beacon. 40 to 128 lower-case hexadecimal digits.

    Raises:
        BenchError: the value is malformed.
    """
    if not VALUE.fullmatch(value):
        hint = "Pass the id of the merge commit, or a beacon's randomness: 40 to 128 digits 0-9 and a-f."
        raise BenchError("malformed-value", f"The value {value[:80]!r} is malformed.", "--value", hint)
    return hashlib.sha256(f"{digest}{value}".encode()).hexdigest()


def fixing_commit(repository: Repository, commit: str, folder: str) -> str:
    """The commit that fixed a submission: the last one that changed a file of it other than a trace.

    It is taken from the first-parent history: for a merged pull request it is the merge commit, which its
    author did not know.

    Args:
        repository: the repository, by its top folder.
        commit: where the history begins.
        folder: the path of the submission in the repository.

    Returns:
        the id of the commit; empty if the history has no such folder.
    """
    return _changes(repository, commit, folder, "--max-count=1")


def salted_commits(repository: Repository, commit: str, folder: str) -> list[str]:
    """The commits that fixed a submission with the logs and policies that it has now, newest first.

    Each has a salt of its own. The first of them changed the logs or policies, the others only other files.

    Args:
        repository: the repository, by its top folder.
        commit: where the history begins.
        folder: the path of the submission in the repository.
    """
    path = PurePosixPath(folder).as_posix()
    audited = (f":(glob){path}/*/*.csv", f":(glob){path}/*/{POLICIES}/**")
    arguments = ("--first-parent", "--max-count=1", commit, "--", *audited)
    first = repository.run("rev-list", *arguments).decode().strip()
    later = _changes(repository, f"{first}..{commit}", folder).split() if first else []
    return [*later, first] if first else []


def is_audited(path: str) -> bool:
    """Whether a file of a submission is a log or a policy."""
    return path.endswith(".csv") or f"/{POLICIES}/" in path


def _changes(repository: Repository, commits: str, folder: str, *options: str) -> str:
    """The first-parent commits that changed a file of a submission other than a trace, one id per line."""
    path = PurePosixPath(folder).as_posix()
    traces = f":(exclude,glob){path}/*/{TRACES}/**"
    return (
        repository.run("rev-list", "--first-parent", *options, commits, "--", path, traces).decode().strip()
    )
