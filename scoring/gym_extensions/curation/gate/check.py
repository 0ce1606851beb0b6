"""Checks a pull request: what kind it is, which rules it breaks, and what its submission proves."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from gym_extensions.atomic import write_bytes
from gym_extensions.curation.challenges import challenge
from gym_extensions.curation.digest import digest_of, tree_digest, tree_hashes
from gym_extensions.curation.gate.changes import LEDGER, SUBMISSIONS, PullRequest, is_data
from gym_extensions.curation.gate.judge import judge
from gym_extensions.curation.gate.limits import DEFAULT, Limits
from gym_extensions.curation.gate.report import MAX_PROBLEMS, OWNER, GateReport, Kind, Label, cut, cut_problem
from gym_extensions.curation.gate.rules import broken_rules
from gym_extensions.curation.git import Repository
from gym_extensions.curation.ledger.chain import parse, states
from gym_extensions.curation.ledger.history import require_appended
from gym_extensions.curation.ledger.rebuild import extract
from gym_extensions.curation.salt import derive_salt, fixing_commit, is_audited, salted_commits
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.auditing.submission_digest import digest_without_traces
from gym_extensions.rollouts.layout import NAME
from gym_extensions.rollouts.problem import Problem
from gym_extensions.scoring.repetition.record import FOLDER, path_of

CODEOWNERS = ".github/CODEOWNERS"
REVIEWED: tuple[Kind, ...] = ("edit", "ledger", "challenge")
"""Kinds that need the agreement of an owner or a maintainer."""
KIND_LABELS: dict[Kind, Label] = {
    "submission": "submission",
    "edit": "edits-entry",
    "ledger": "ledger",
    "challenge": "challenge",
}


@dataclass(frozen=True)
class Request:
    """What to check: a repository, two branches or commits, and what is known from outside of git.

    ``value`` is what the salt is derived from. If it is empty and the pull request changes only traces of an
    entry, it is the commit of the base that fixed the entry; otherwise the sample has no salt. ``number`` is
    that of the pull request.
    """

    repository: Repository
    base: str
    head: str = "HEAD"
    value: str = ""
    number: int | None = None
    limits: Limits = DEFAULT


def check_pull_request(request: Request) -> GateReport:
    """The report on a pull request. Its files are read from git and never checked out or executed.

    Raises:
        BenchError: a branch does not exist, the value is malformed, or the folder is not in git.
    """
    if request.value:
        derive_salt("", request.value)
    repository = Repository(request.repository.top)
    base, head = repository.commit(request.base), repository.commit(request.head)
    report = GateReport(pull_request=request.number, base=base, head=head, kind="none", verdict="refused")
    try:
        pull_request = _open(repository, base, head)
        if not any(map(is_data, pull_request.paths)):
            return replace(report, kind="code", verdict="not-judged")
        report = _with_entry(report, pull_request)
        problems = broken_rules(pull_request)
    except BenchError as error:
        return _closed(report, [Problem(error.code, error.where, error.message, error.hint)])
    if not problems and report.kind in ("submission", "edit"):
        return _judged(report, pull_request, request)
    if not problems:
        check = _ledger_problems if report.kind == "ledger" else _challenge_problems
        problems = check(pull_request)
    return _closed(report, problems)


def _open(repository: Repository, base: str, head: str) -> PullRequest:
    """The pull request from one commit to another. Raises BenchError if it is none."""
    starts = repository.merge_bases(base, head)
    if not starts:
        message = "The two commits have no common ancestor."
        raise BenchError("unrelated-history", message, hint="Start from the base's branch.")
    if len(starts) > 1:
        # A merge uses all of them, so that the difference to one of them is not what the merge changes.
        message = f"The two commits have {len(starts)} common ancestors."
        raise BenchError("crossed-history", message, hint="Rebase the branch on the base's branch.")
    pull_request = PullRequest(repository, starts[0], base, head)
    if not pull_request.changes:
        raise BenchError("no-change", "It changes nothing.", head, "Commit the submission on a branch.")
    return pull_request


def _with_entry(report: GateReport, pull_request: PullRequest) -> GateReport:
    """The report with the kind of the pull request, and with the name and the owners of its entry."""
    if not pull_request.entries:
        return replace(report, kind="ledger" if LEDGER in pull_request.paths else "challenge")
    entry = pull_request.entries[0]
    kind: Kind = "edit" if entry in pull_request.base_entries else "submission"
    name = entry if NAME.fullmatch(entry) else ""
    return replace(report, kind=kind, entry=name, owners=_owners(pull_request, entry))


def _owners(pull_request: PullRequest, entry: str) -> tuple[str, ...]:
    data = pull_request.repository.file(pull_request.base, CODEOWNERS) or b""
    rows = [line.split() for line in data.decode(errors="replace").splitlines()]
    owners = [row[1:] for row in rows if row and row[0] == f"/{SUBMISSIONS}/{entry}/"]
    return tuple(name for name in (owners[-1] if owners else []) if re.fullmatch(OWNER, name))


def _closed(report: GateReport, problems: list[Problem]) -> GateReport:
    """The report with its problems, verdict and labels."""
    kind_label: list[Label] = [KIND_LABELS[report.kind]] if report.kind in KIND_LABELS else []
    level_label: list[Label] = ["refused"] if problems else []
    if not problems and report.level:
        level_label = ["replayed" if report.replayed else "validated"]
    return replace(
        report,
        verdict="refused" if problems else "review" if report.kind in REVIEWED else "passed",
        problems=tuple(map(cut_problem, problems[:MAX_PROBLEMS])),
        more_problems=max(0, len(problems) - MAX_PROBLEMS),
        labels=tuple(sorted((*kind_label, *level_label))),
    )


def _ledger_problems(pull_request: PullRequest) -> list[Problem]:
    """The ledger of the base is continued, its chain is whole, and new lines are about files that exist."""
    repository = pull_request.repository
    old = repository.file(pull_request.base, LEDGER) or b""
    new = repository.file(pull_request.head, LEDGER) or b""
    try:
        require_appended(old, new, LEDGER, "the base")
        before, after = states(parse(old, LEDGER)), states(parse(new, LEDGER))
    except BenchError as error:
        return [Problem(error.code, error.where, error.message, error.hint)]
    problems = []
    for name, state in after.items():
        if state.active and before.get(name) != state:
            files = pull_request.files_of(name)
            digest = tree_digest(repository, files, f"{SUBMISSIONS}/{name}/")
            if not files or digest != state.last.digest:
                message = "The new line has another digest than the files."
                problems.append(Problem("ledger-entry", name, message, "Write it with `ledger add`."))
    return problems


def _challenge_problems(pull_request: PullRequest) -> list[Problem]:
    problems = []
    for change in pull_request.changes:
        content = pull_request.repository.file(pull_request.head, change.path) or b""
        try:
            challenge(change.path, content)
        except BenchError as error:
            problems.append(Problem(error.code, error.where, error.message, error.hint))
            continue
        entry = change.path.split("/")[1]
        if entry not in pull_request.base_entries:
            message, hint = f"The base has no entry {entry!r}.", "Name the folder of an entry."
            problems.append(Problem("unknown-entry", change.path, message, hint))
    return problems


def _fixed_value(pull_request: PullRequest, prefix: str, hashes: Mapping[str, str]) -> str:
    """The commit of the base that fixed an entry of which only traces change; empty for other changes."""
    repository, base = pull_request.repository, pull_request.base
    files = [file for file in pull_request.base_files if file.path.startswith(prefix)]
    merged = digest_without_traces(tree_hashes(repository, files, prefix))
    is_fixed = bool(files) and merged == digest_without_traces(hashes)
    return fixing_commit(repository, base, prefix.rstrip("/")) if is_fixed else ""


def _salt_notes(pull_request: PullRequest, prefix: str, value: str) -> tuple[str, ...]:
    """A note if the same logs had a salt before: an author could edit other files until one suits."""
    folder = prefix.rstrip("/")
    count = len(salted_commits(pull_request.repository, pull_request.base, folder))
    if value and count > 1:
        return (f"This is salt {count} of the same logs: other files were changed after the first.",)
    if count and not value and not any(map(is_audited, pull_request.paths)):
        return ("The logs stay, and their salt becomes another one.",)
    return ()


def _judged(report: GateReport, pull_request: PullRequest, request: Request) -> GateReport:
    """The report with what the files of the entry prove, in a process with limits."""
    entry, repository = report.entry, pull_request.repository
    prefix = f"{SUBMISSIONS}/{entry}/"
    files = pull_request.files_of(entry)
    hashes = tree_hashes(repository, files, prefix)
    value = request.value or _fixed_value(pull_request, prefix, hashes)
    salt = derive_salt(digest_without_traces(hashes), value) if value else ""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / SUBMISSIONS / entry
        extract(repository, files, prefix, folder)
        record = repository.file(pull_request.base, path_of(FOLDER, entry).as_posix())
        if record is not None:
            write_bytes(path_of(Path(scratch) / FOLDER, entry), record)
        judgement = judge(folder, salt, request.limits)
    salt_notes = _salt_notes(pull_request, prefix, value) if report.kind == "edit" else ()
    judged = replace(
        report,
        digest=digest_of(hashes),
        value=value,
        salt=salt,
        level=judgement.level,
        replayed=judgement.replayed,
        episodes=judgement.episodes,
        scores=judgement.scores,
        notes=tuple(map(cut, [*salt_notes, *judgement.notes][:MAX_PROBLEMS])),
    )
    return _closed(judged, list(judgement.problems))
