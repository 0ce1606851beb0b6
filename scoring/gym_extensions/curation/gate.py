"""Checks a pull request: what kind it is, which rules it breaks, and a sample of its logged episodes."""

import json
import tempfile
import time
from collections.abc import Collection, Iterator, Mapping, Sequence, Set
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import msgspec

from gym_extensions.curation import gate_report as reports, pull_request_rules
from gym_extensions.errors import BenchError
from gym_extensions.files import write_bytes
from gym_extensions.metrics.formulas import METRICS
from gym_extensions.references import load_references
from gym_extensions.scoring.submission.scorer import score
from gym_extensions.submissions import layout, manifest, reader, review
from gym_extensions.submissions.problem import Problem, count, cut, escape, problems as problems_of
from gym_extensions.submissions.run import ARITHMETIC, RunDocument, run_of
from gym_extensions.submissions.submission import Submission
from gym_extensions.verification import git, new_seeds, train_here
from gym_extensions.verification.episodes import Cell, played
from gym_extensions.verification.limits import READING, answers
from gym_extensions.verification.logged_run import LoggedRun, logged_runs, repetition

SAMPLE = 20
"""Cells of 20 episodes that are repeated."""
SAMPLE_SECONDS = 240.0
"""No further cell is started after this time."""
JUDGED = ("level", "repeated", "episodes", "without_policies", "problems", "more_problems", "scores")
"""What the process that reads the files of a submission says for the report, besides notes."""


def check_pull_request(
    repository: git.Repository,
    base: str,
    head: str = "HEAD",
    number: int | None = None,
    *,
    try_code: bool = False,
) -> reports.GateReport:
    """The report on a pull request, by two branches or commits and its number on the code host.

    Its files are read from git and never checked out. Only with ``try_code`` is any executed: code that keeps
    to the rules is trained twice in a box; whether the bytes are the same is a note.

    Raises:
        BenchError: a branch does not exist, the folder is not in git, the clone cannot be read, or no box can
            be started.
    """
    repository = git.Repository(repository.top)
    base, head = repository.commit(base), repository.commit(head)
    report = reports.GateReport(pull_request=number, base=base, head=head, kind="none", verdict="refused")
    try:
        pull_request = opened(repository, base, head)
        if not any(map(pull_request_rules.is_data, pull_request.paths)):
            return replace(report, kind="code", verdict="not-judged")
        name = next(iter(pull_request.submissions), "")
        known = name if layout.NAME.fullmatch(name) else ""
        report = replace(report, kind=pull_request.kind, submission=known)
        report = _closed(report, problems_of("pull request", pull_request, rules=pull_request_rules.RULES))
        return report if report.problems else _judged(report, pull_request, try_code)
    except BenchError as error:
        if error.code in git.MACHINE_ERRORS:
            raise
        return _closed(report, [Problem(error.code, error.where, error.message, error.hint)])


def opened(repository: git.Repository, base: str, head: str) -> pull_request_rules.PullRequest:
    """The pull request from one commit to another. Raises BenchError if it is none."""
    starts = repository.run("merge-base", "--all", base, head, statuses=(0, 1)).decode().split()
    if not starts:
        repository.require_history()
        message = "The two commits have no common ancestor."
        raise BenchError("unrelated-history", message, hint="Start from the base's branch.")
    if len(starts) > 1:
        # A merge uses all of them, so that the difference to one of them is not what the merge changes.
        message = f"The two commits have {len(starts)} common ancestors."
        raise BenchError("crossed-history", message, hint="Rebase the branch on the base's branch.")
    pull_request = pull_request_rules.PullRequest(repository, starts[0], base, head)
    if not pull_request.changes:
        hint = "Commit the submission. If it is on main, name the base: --base origin/main."
        raise BenchError("no-change", "It changes nothing.", head, hint)
    return pull_request


def _closed(report: reports.GateReport, problems: Sequence[Problem]) -> reports.GateReport:
    """The report with its verdict, which follows from the problems."""
    return replace(
        report,
        verdict="refused" if problems else "review" if report.kind == "edit" else "passed",
        level=None if problems else report.level,
        problems=tuple(problems[: reports.MAX_PROBLEMS]),
        more_problems=max(0, len(problems) - reports.MAX_PROBLEMS),
    )


def _noted(report: reports.GateReport, notes: Sequence[str]) -> reports.GateReport:
    """The report with as many notes, and as much of each, as it may have."""
    return replace(report, notes=tuple(cut(escape(note)) for note in notes[: reports.MAX_PROBLEMS]))


def _judged(
    report: reports.GateReport, pull_request: pull_request_rules.PullRequest, try_code: bool
) -> reports.GateReport:
    """The report with what the files are worth, found out in a process with limits."""
    files = pull_request.files_of(report.submission)
    contents = pull_request.repository.blobs(file.object_id for file in files)
    with tempfile.TemporaryDirectory() as scratch:
        # The paths and sizes keep to the rules.
        for file, content in zip(files, contents, strict=True):
            write_bytes(Path(scratch, file.path.partition("/")[2]), content)
        folder = Path(scratch, report.submission)
        call = {"folder": str(folder), "report": msgspec.to_builtins(report)}
        call |= {"donated": pull_request.donated_runs, "changed": pull_request.changed_runs}
        (answer,) = answers(judge, call, READING)
        found = msgspec.convert(answer, reports.GateReport)
        trains = found.trains and pull_request.changes_code(report.submission)
        is_tried = try_code and trains and not found.problems
        tried = [train_here.repeats(folder)] if is_tried else []
    judged = {name: getattr(found, name) for name in JUDGED}
    verdict = "refused" if found.problems else report.verdict
    notes = [*changed_values(pull_request), *tried, *found.notes]
    if missing := sum(title is None for title in pull_request.base_titles.values()):
        notes.append(f"Not compared: the titles of {count(missing, 'submission')}, which this clone lacks.")
    return _noted(replace(report, **judged, verdict=verdict, trains=trains), notes)


def changed_values(pull_request: pull_request_rules.PullRequest) -> Iterator[str]:
    """What an edit changes in the manifest and in documents of runs: the names of the keys, in words."""
    sides = pull_request.base_files, pull_request.head_files
    described = (path for path in pull_request.paths if path.endswith((layout.MANIFEST, layout.DOCUMENT)))
    edited = [path for path in described if all(path in files for files in sides)]
    contents = (pull_request.repository.blobs([files[path].object_id for path in edited]) for files in sides)
    places = dict[tuple[bool, tuple[str, ...]], list[str]]()
    for path, *both in zip(edited, *contents, strict=True):
        (old, old_digest), (new, new_digest) = (_values(path, data) for data in both)
        changed = sorted(name for name in old.keys() | new.keys() if old.get(name) != new.get(name))
        lapses = old_digest != new_digest
        places.setdefault((lapses, tuple(changed)), []).append(path.split("/", 2)[2])
    for (lapses, names), paths in places.items():
        others = f" and {count(len(paths) - 1, 'other document')}" if len(paths) > 1 else ""
        again = " What was verified of it is claimed again." if lapses else ""
        yield f"Changed in {paths[0]}{others}: {', '.join(names) or 'the spelling'}.{again}"


def _values(path: str, data: bytes) -> tuple[dict[str, Any], str]:
    """The values of a manifest or document by ``key`` or ``section.key``, and the digest that a verification
    is about; nothing of a broken file."""
    try:
        if path.endswith(layout.MANIFEST):
            tables = manifest.parse(data)
            digest = manifest.manifest_of(tables).digest
        else:
            tables, digest = json.loads(data), run_of(data).digest
    except (ValueError, RecursionError):
        return {}, ""
    parts = ((name, part if isinstance(part, dict) else {"": part}) for name, part in tables.items())
    return {f"{name}.{key}".rstrip("."): value for name, part in parts for key, value in part.items()}, digest


def judge(call: Mapping[str, Any]) -> Iterator[Any]:
    """The job of the process with limits: the report after a submission was read and scored, and a sample of
    its episodes repeated.
    """
    report = msgspec.convert(call["report"], reports.GateReport)
    submission, donated = reader.read(Path(call["folder"]), policies=True), frozenset(call["donated"])
    card = score(submission, load_references())
    problems = card.problems or (
        *donation_problems(submission, donated),
        *arithmetic_problems(submission, call["changed"]),
    )
    if problems:
        report = _closed(report, problems)
    elif card.level == review.REPORTED:
        report = _noted(replace(report, level="reported"), card.notes)
    else:
        report, scores = repeated_sample(report, submission, donated), list[reports.GateScore]()
        for group, protocols in card.groups.items():
            for protocol, each in protocols.items():
                name = METRICS[protocol][0].name
                value, facts = each.metrics[name], (each.budget, len(each.runs), name)
                scores.append(reports.GateScore(group, protocol, *facts, value.mean, value.low, value.high))
        report = replace(report, trains=bool(submission.code), scores=tuple(scores))
        report = _noted(report, [*report.notes, *card.notes])
    yield msgspec.to_builtins(report)


def donation_problems(submission: Submission, donated: Set[str]) -> Iterator[Problem]:
    """What is wrong with donated runs, by their names, of a submission without other problems.

    A run publishes its policies, and was trained with versions of the packages, and about as many steps, as a
    run of the submission.
    """
    own = [document for name, document in submission.documents.items() if name not in donated]
    versions = [_agent_versions(document) for document in own]
    for name in sorted(donated):
        document = submission.documents[name]
        if document.policies is None:
            hint = "Train it with `gym-extensions train`, which writes them."
            yield Problem("no-policies", name, "A donated run needs its policies.", hint)
        key = document.group, document.protocol
        steps = [each.steps for each in own if (each.group, each.protocol) == key]
        stated, message = _agent_versions(document), ""
        if stated not in versions:
            words = ", ".join(f"{package} {version}" for package, version in stated.items())
            message = f"It was trained with {words}, and no run of the submission was."
        elif steps and not 0.95 < document.steps / max(1, *steps) < 1.05:
            message = f"It states {document.steps} training steps; other runs have up to {max(steps)}."
        if message:
            hint = "Train it with the versions and steps (within 5 %) that the submission's documents state."
            yield Problem("other-agent-version", name, message, hint)


def arithmetic_problems(submission: Submission, changed: Collection[str]) -> Iterator[Problem]:
    """New or changed runs, by their names, that were not logged in the present arithmetic."""
    for name, document in submission.documents.items():
        if name in changed and document.arithmetic != ARITHMETIC:
            message = f"Its document states the arithmetic {document.arithmetic}; it is {ARITHMETIC} now."
            hint = "Record it with an installed version of today (docs/rollout-log.md#arithmetic)."
            yield Problem("first-arithmetic", name, message, hint)


def _agent_versions(document: RunDocument) -> dict[str, str]:
    """The versions that determine what an agent of this project learns.

    Of this project it is the minor version: a patch release changes no agent.
    """
    used = document.versions
    minor = ".".join(used.gym_extensions.split(".")[:2])
    return {"gym_extensions": minor, "gymnasium": used.gymnasium, "mujoco": used.mujoco} | document.packages


def repeated_sample(
    report: reports.GateReport, submission: Submission, donated: Set[str]
) -> reports.GateReport:
    """The report after a sample of the logged episodes was repeated in this process; of a donation, of the
    donated runs.

    The cells are those whose SHA-256 with the digest of all files is lowest. An episode that differs is a
    problem, unless honest ones may differ on this machine (:meth:`LoggedRun.other_machine`).
    """
    known = logged_runs(submission)
    without = sum(run.document.policies is None for run in known.values())
    report = replace(report, level="claimed", without_policies=without)
    if submission.is_sampled:
        note = "The policies sample their actions, so no episode can be repeated."
        return replace(report, notes=(note,) if without < len(known) else ())
    runs, notes, first_arithmetic = [], list[str](), 0
    for name, run in known.items():
        policies = run.document.policies
        if policies is not None and policies.url:
            notes = ["Policies that lie elsewhere are fetched after the merge."]
        elif run.is_first_arithmetic:
            first_arithmetic += 1
        elif policies is not None and (not donated or name in donated):
            runs.append(run)
    digest = new_seeds.files_digest({run.name: run.document.files for run in runs})

    def draw(item: tuple[LoggedRun, Cell]) -> str:
        run, cell = item
        return sha256(f"{digest}/{run.name}/{cell.stage}/{cell.task}".encode()).hexdigest()

    cells = [(run, cell) for run in runs for cell in run.prescribed_cells]
    end = time.monotonic() + SAMPLE_SECONDS
    repeated = episodes = 0
    problems: list[Problem] = []
    for run, cell in sorted(cells, key=draw)[:SAMPLE]:
        if time.monotonic() > end:
            break
        found = repetition(run, [cell], next(played(run.request([cell]), run.log.group)))
        repeated, episodes = repeated + found.repeated, episodes + found.episodes
        if found.difference and found.other_machine:
            notes.append(f"{run.name}: {found.difference}. {found.other_machine}")
        elif found.difference:
            hint = "Store the policy of every stage, and log its first evaluation, on x86-64 Linux."
            problems.append(Problem("not-repeated", run.name, f"{found.difference}.", hint))
    if first_arithmetic:
        notes.append(f"{first_arithmetic} unchanged runs of the first arithmetic are not repeated.")
    report = replace(report, repeated=repeated, episodes=episodes, notes=tuple(notes))
    return _closed(report, problems)
