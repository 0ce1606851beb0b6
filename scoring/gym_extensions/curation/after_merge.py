"""Reviews after a merge: verification with seeds from the merge commit, and decisions."""

from __future__ import annotations

from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path

import msgspec

from gym_extensions.curation.git import Repository
from gym_extensions.curation.pull_request_rules import is_of_this_project
from gym_extensions.errors import BenchError
from gym_extensions.submissions.layout import DOCUMENT, LOG, MANIFEST, NETWORK, POLICIES
from gym_extensions.submissions.manifest import LONG, manifest_of, parse
from gym_extensions.submissions.reader import read
from gym_extensions.submissions.review import Action, Decision, read_review, review_of, write_review
from gym_extensions.verification.verify import add_verifications, runs_of, verified_before

TRAINED_AGAIN = ("smoke", "100k", "300k")
"""Budgets of which a job trains a run again: a run of the others takes hours."""
MAX_RECORD_BYTES = 2**20
SEEDS_HINT = "Commit it, or run gym-extensions verify --seeds HEX --write."
AGAIN = "Write it again with: gym-extensions maintain review SUBMISSION --record DIR"
OTHER_FILES = "It is about other files, or about files that already have a verdict."


def undecided_runs(submission: Path) -> dict[str, str]:
    """The digest of every run with policies about which no verification has decided, by the run's name.

    Raises ``BenchError`` if the submission has problems.
    """
    found = read(submission, merge_runs=False)
    if found.problems:
        first = found.problems[0]
        raise BenchError(first.rule, first.message, f"{found.name}: {first.where}", first.hint)
    runs = {name: run for name, run in runs_of(found).items() if run.document.policies is not None}
    decided = verified_before(found.review, runs)
    return {name: run.document.digest for name, run in runs.items() if name not in decided}


def runs_by_commit(submission: Path, runs: Iterable[str]) -> dict[str, list[str]]:
    """The names of runs by the commit that fixed their files, so that a bad run refuses no run of others."""
    found: dict[str, list[str]] = {}
    for name in runs:
        networks = [
            path.relative_to(submission).as_posix() for path in sorted(submission.glob(f"{name}.*{NETWORK}"))
        ]
        files = [*(f"{name}{suffix}" for suffix in (LOG, DOCUMENT, POLICIES)), *networks]
        found.setdefault(merge_commit(submission, files), []).append(name)
    return found


def merge_commit(parent: Path, files: Iterable[str]) -> str:
    """The commit that fixed files of a folder: the last one of HEAD's first-parent history that changed one.

    For a merged pull request it is the merge commit, which its author did not know.

    Raises:
        BenchError: the files are not committed as they are, or the clone lacks older commits.
    """
    repository = Repository(Repository(parent).top)
    folder = parent.resolve().relative_to(repository.top.resolve()).as_posix()
    paths = [f"{folder}/{file}" for file in files]
    changed = repository.run("status", "--porcelain", "--untracked-files=all", "-z", "--", folder)
    names = [part[3:] for part in changed.decode("utf-8", "surrogateescape").split("\0") if part]
    if uncommitted := sorted(set(names) & set(paths)):
        message = "It is not committed in its present form, so no commit determines its seeds."
        raise BenchError("not-committed", message, uncommitted[0], SEEDS_HINT)
    commit = repository.last_change(repository.commit("HEAD"), paths)
    if not commit:
        raise BenchError("not-committed", "No commit has its files.", folder, SEEDS_HINT)
    return commit


def decide(submission: Path, action: Action, by: str, reason: str) -> None:
    """Adds a decision of today, with a name and a reason, to the review of a submission."""
    for option, text in (("--by", by), ("--reason", reason)):
        if not text.strip() or len(text) > LONG:
            message = f"It is empty or has more than {LONG} characters."
            raise BenchError("no-reason", message, option, "Say who decides, and why.")
    review = read_review(submission)
    decision = Decision(action=action, by=by, date=datetime.now(UTC).date().isoformat(), reason=reason)
    write_review(submission, msgspec.structs.replace(review, decisions=[*review.decisions, decision]))


def is_trained_again(submission: Path) -> bool:
    """Whether a job trains a run of a submission again: this project's agent, budget up to 300k."""
    protocol = manifest_of(parse((submission / MANIFEST).read_bytes())).protocol
    return is_of_this_project(protocol) and protocol.budget in TRAINED_AGAIN


def take(submission: Path, file: Path) -> None:
    """Adds the verifications in a file, which another job wrote, to the review of a submission, all or none.

    Raises:
        BenchError: the file has anything but verifications of the submission's undecided runs as they are,
            each with seeds from the commit that fixed its runs.
    """
    try:
        data = file.read_bytes()
        found = review_of(data) if len(data) <= MAX_RECORD_BYTES else None
    except (OSError, ValueError, RecursionError) as error:
        raise BenchError("bad-record", f"It is not a verification: {error}.", str(file), AGAIN) from error
    if found is None or not found.verifications or found.decisions:
        raise BenchError("bad-record", "It has no verification, or decisions besides.", str(file), AGAIN)
    runs = undecided_runs(submission)
    for each in found.verifications:
        if not each.runs or not each.runs.items() <= runs.items():
            raise BenchError("bad-record", OTHER_FILES, str(file), AGAIN)
        if set(runs_by_commit(submission, each.runs)) != {each.value}:
            raise BenchError("bad-record", "Its seeds do not follow from the merge commit.", str(file), AGAIN)
        if each.retrained and not is_trained_again(submission):
            raise BenchError("bad-record", "Jobs retrain only reference agents up to 300k.", str(file), AGAIN)
        if not set(each.retrained) <= each.runs.keys():
            raise BenchError("bad-record", "It says that other runs were trained again.", str(file), AGAIN)
    add_verifications(submission, *found.verifications)
