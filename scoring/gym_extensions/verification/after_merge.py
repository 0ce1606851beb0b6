"""What was merged: runs without a verdict, the commits that give their seeds, results of another job."""

from collections.abc import Iterable
from pathlib import Path

from gym_extensions.baselines import algorithms
from gym_extensions.errors import BenchError
from gym_extensions.submissions import review
from gym_extensions.submissions.layout import DOCUMENT, LOG, MANIFEST, NETWORK, POLICIES, read_regular
from gym_extensions.submissions.submission import Submission
from gym_extensions.verification.git import Repository
from gym_extensions.verification.verify import settings_of

TRAINED_AGAIN = ("smoke", "100k", "300k")
"""Budgets of which a job trains a run again: a run of the others takes hours."""


def is_trained_again(submission: Submission) -> bool:
    """Whether a job trains a run of a submission again: this project's agent, budget up to 300k."""
    assert submission.manifest is not None, "it has no problems"
    protocol = submission.manifest.protocol
    is_quick = protocol.algorithm in algorithms.names() and protocol.budget in TRAINED_AGAIN
    return is_quick and all(document.steps_counted for document in submission.documents.values())


def runs_without_verdict(submission: Submission, *, again: bool = False) -> dict[str, str]:
    """The digest of every run with policies about which no verification has decided, by the run's name.

    That its policies are too slow is a verdict, too; with ``again`` it is none.
    """
    published = {name: each for name, each in submission.documents.items() if each.policies is not None}
    digests = {name: document.digest for name, document in published.items()}
    verdicts = review.decided(submission.review, settings_of(submission), digests)
    if again:
        verdicts = {
            name: parts for name, parts in verdicts.items() if not all(part.undecided for part in parts)
        }
    return {name: digest for name, digest in digests.items() if name not in verdicts}


def merged_at(submission: Submission) -> int:
    """When the last of its runs without a verdict was merged, in seconds; 0 if it has none.

    Runs that no merge commit brought do not count: their seeds would follow from a commit of their author.
    """
    commits = runs_by_commit(submission.path, runs_without_verdict(submission))
    repository = Repository(submission.path)
    merges = (commit for commit in commits if not repository.not_merged(commit))
    times = (repository.run("show", "--no-patch", "--format=%ct", commit) for commit in merges)
    return max(map(int, times), default=0)


def runs_by_commit(submission: Path, runs: Iterable[str]) -> dict[str, list[str]]:
    """The names of runs by the commit that fixed their files, so that a bad run refuses no run of others.

    The files are those of the run and the manifest. Raises ``BenchError`` as :meth:`Repository.fixed` does.
    """
    repository, found = Repository(submission), dict[str, list[str]]()
    for name in runs:
        networks = [path.name.partition(".")[2] for path in sorted(submission.glob(f"{name}.*{NETWORK}"))]
        suffixes = (LOG, DOCUMENT, POLICIES, *(f".{network}" for network in networks))
        commit = repository.fixed(submission, [MANIFEST, *(f"{name}{suffix}" for suffix in suffixes)])
        found.setdefault(commit, []).append(name)
    return found


def take(submission: Submission, file: Path) -> None:
    """Adds the verifications in a file, which another job wrote, to the review of a submission, all or none.

    Raises:
        BenchError: the file has anything but verifications of the submission's runs without a verdict as
            they are, each with seeds from the commit that fixed its runs.
    """

    def refusal(message: str) -> BenchError:
        hint = "Write it again with: gym-extensions verify SUBMISSION --record DIR"
        return BenchError("bad-record", message, str(file), hint)

    try:
        found = review.review_of(read_regular(file, max_bytes=2**20))
    except (OSError, ValueError, RecursionError) as error:
        raise refusal(f"It is not a verification: {error}.") from error
    if not found.verifications or found.decisions:
        raise refusal("It has no verification, or decisions besides.")
    waiting, documents = runs_without_verdict(submission), submission.documents
    for part in found.verifications:
        has_waited = bool(part.runs) and part.runs.items() <= waiting.items()
        files = {name: documents[name].files for name in part.runs if name in documents}
        if not has_waited or (part.files, part.settings) != (files, settings_of(submission)):
            raise refusal("It is about other files, or about files that already have a verdict.")
        if set(runs_by_commit(submission.path, part.runs)) != {part.value}:
            raise refusal("Its seeds do not follow from the merge commit.")
        if part.retrained and not (is_trained_again(submission) and part.runs.keys() >= set(part.retrained)):
            raise refusal("It says that runs were trained again that no job trains.")
    review.add_to_review(submission.path, found.verifications)
