"""Trains the code of a submission in a box, on seeds that nobody knew when it was submitted.

``maintain train-here`` calls it by hand and in the job after a merge; another job takes what it wrote. The
gate calls :func:`repeats` before the merge.
"""

import tempfile
from collections.abc import Collection, Iterator
from datetime import UTC, datetime
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import tomli_w
from msgspec.structs import replace

from gym_extensions import baselines
from gym_extensions.baselines import cli, submission as written, workers
from gym_extensions.baselines.training.progress import Event, JobFailed
from gym_extensions.catalog.groups import CORE, CORES, GROUPS
from gym_extensions.catalog.protocol import STANDARD_BUDGET
from gym_extensions.errors import BenchError, require_known
from gym_extensions.files import write_bytes, write_text
from gym_extensions.submissions import layout, problem, reader
from gym_extensions.submissions.layout import AGENT, DOCUMENT, LOG, MANIFEST, TRAINED, run_key
from gym_extensions.submissions.log import read_log
from gym_extensions.submissions.policies.files import content_sha256, policy_name, read_arrays
from gym_extensions.submissions.problem import refuse_problems
from gym_extensions.submissions.review import Training, is_withdrawn, training_of, training_text
from gym_extensions.submissions.run import read_run
from gym_extensions.submissions.submission import Submission
from gym_extensions.verification import git, limits
from gym_extensions.versions import version

AGENT_ERRORS = frozenset(
    [
        *("agent-cpu", "agent-ended", "agent-failed", "agent-frames", "agent-output", "agent-slow"),
        *("bad-action", "bad-actions", "bad-agent", "bad-card", "bad-observations", "bad-policies"),
        *("bad-policy", "bad-reset-mask", "budget-exceeded", "needs-context"),
        *("no-generator", "onnx-failed", "policy-differs", "single-task-agent"),
        *("slow-policy", "too-many-resets", "unknown-agent", "unsupported-policy"),
    ]
)
"""The errors that are an agent's own. After any other one, the run is trained again."""
CORE_GROUPS = tuple(group.name for group in GROUPS.values() if group.id in CORES[CORE])


def wanted_runs(
    runs: int, protocol: str = "sequential", groups: Collection[str] = CORE_GROUPS
) -> dict[str, tuple[str, str, int]]:
    """The group, protocol and number of the runs 0 to ``runs`` − 1 of every group, by their names.

    Raises ``BenchError`` for a group that is not published.
    """
    for group in groups:
        require_known("group", group, GROUPS)
    return {run_key(group, protocol, run): (group, protocol, run) for group in groups for run in range(runs)}


def problems_of(submission: Submission) -> tuple[problem.Problem, ...]:
    """Its problems without those of runs here: a machine that died may have left half a run, which is trained
    again."""
    return tuple(each for each in submission.problems if not fnmatch(each.where, f"{TRAINED}/*/*"))


def is_due(submission: Submission, wanted: Collection[str]) -> bool:
    """Whether a submission has code of which not all runs with these names were trained, and stands."""
    if problems_of(submission) or not submission.code or is_withdrawn(submission.review.decisions):
        return False
    trained = submission.trained
    if trained is None or trained.training.agent != submission.code:
        return True
    return not set(wanted) <= trained.training.runs.keys()


def version_and_record(submission: Submission, value: str) -> tuple[int, Training]:
    """The number of the version of a submission's code, and its record, which is new if it has none.

    Raises ``BenchError`` if the submission has problems or no code, or was trained with another value.
    """
    refuse_problems(submission.path, problems_of(submission))
    trained, where = submission.trained, submission.name
    if not submission.code:
        hint = "Add its code as agent/, with [agent] in submission.toml."
        raise BenchError("no-agent", "The submission has no code to train.", where, hint)
    if trained is None or trained.training.agent != submission.code:
        today, made = datetime.now(UTC).date().isoformat(), version("gym-extensions")
        repository = git.Repository(submission.path)
        repository.fixed(submission.path, [AGENT, MANIFEST])  # they are committed
        commit = repository.code_commit("HEAD", repository.inside(submission.path))
        if not value and (found := repository.not_merged(commit)):
            raise BenchError(found.rule, found.message, found.where, found.hint)
        number = 1 if trained is None else trained.version + 1
        return number, Training(date=today, version=made, commit=commit, value=value, agent=submission.code)
    if value not in ("", trained.training.value):
        message = "This version of its code is trained with another value, which stands."
        raise BenchError("other-seeds", message, where, "Leave out --value.")
    return trained.version, trained.training


def train_here(
    submission: Submission,
    runs: int,
    value: str = "",
    *,
    protocol: str = "sequential",
    groups: Collection[str] = CORE_GROUPS,
    trial: Path | None = None,
    jobs: int = 1,
) -> Training:
    """Trains the runs 0 to ``runs`` − 1 of a submission's code that are missing, and records them.

    Everything is kept as soon as it is finished, a failure too, so that an interrupted call goes on where it
    was and a failed run is not tried again.

    Args:
        submission: with code.
        runs: number of runs of each group.
        value: hexadecimal digits that became public after the merge and that nobody could choose.
        protocol: one in which a policy learns the tasks in order. The core ranks sequential runs alone.
        groups: names of published groups.
        trial: a folder for runs with the budget for trials, in place of the submission, which stays as it is.
        jobs: worker processes.

    Raises:
        BenchError: no box can be started, the code is not committed, or something else than the agent failed.
    """
    wanted = wanted_runs(runs, protocol, groups)
    number, training = version_and_record(submission, value)
    folder, budget = submission.path / TRAINED / str(number), STANDARD_BUDGET
    if trial:
        training, folder, budget = replace(training, runs={}, failed={}), trial / str(number), "smoke"
    assert submission.manifest and submission.manifest.agent, "it has code"
    code = f"{submission.path / AGENT}/{submission.manifest.agent.entry}"
    factory = cli.isolated(code, [*groups], [protocol], budget)
    titles = {f"{group} {protocol}-run{run}": name for name, (group, _, run) in wanted.items()}

    def missing() -> list[str]:
        return [name for name in wanted if not (folder / f"{name}{LOG}").exists()]

    def listen(event: Event) -> None:
        if isinstance(event, JobFailed) and event.code in AGENT_ERRORS:
            _recorded(folder, replace(training, failed={titles[event.job]: problem.cut(event.cause)}))

    def replace_failed() -> None:
        for name in _recorded(folder, training).failed.keys() & missing():
            _write_floor(folder, wanted[name], budget, training.seeds, submission.path / MANIFEST)

    replace_failed()
    error: BenchError | None = None
    try:
        if missing():
            baselines.train(
                *(factory, groups, protocol, budget, range(runs)),
                out=folder,
                jobs=jobs,
                progress=baselines.Monitor(callback=listen),
                origin=baselines.Origin(seeds=training.seeds),
            )
    except BenchError as raised:
        if raised.code in AGENT_ERRORS:  # no job began
            _recorded(folder, replace(training, failed=dict.fromkeys(missing(), problem.cut(str(raised)))))
        elif raised.code != workers.JOBS_FAILED:
            raise
        error = raised
    replace_failed()
    unfinished = missing()
    finished = [name for name in wanted if name not in unfinished]
    digests = {name: read_run(folder / f"{name}{DOCUMENT}").digest for name in finished}
    training = _recorded(folder, replace(training, runs=digests))
    if error and unfinished:
        raise error
    return training


def _recorded(folder: Path, training: Training) -> Training:
    """Adds the runs and failures of a training to the record of its folder, and returns the record.

    A command with another protocol may have added to it in the meantime.
    """
    path = folder.with_suffix(".toml")
    with written.lock_runs(folder, ["record"], seconds=60):
        if path.exists():
            known = training_of(path.read_bytes())
            training = replace(known, runs=known.runs | training.runs, failed=known.failed | training.failed)
        write_text(path, training_text(training))
    return training


def _write_floor(folder: Path, place: tuple[str, str, int], budget: str, seeds: str, manifest: Path) -> None:
    """Writes, in the place of a failed run, that of the agent that does nothing.

    If no run has a manifest yet, it is that of the submission, with the budget of the training.
    """
    group, protocol, run = place
    with tempfile.TemporaryDirectory() as scratch:
        out = Path(scratch) / "floor"
        origin = baselines.Origin(seeds=seeds)
        (log,) = baselines.train("zero", group, protocol, budget, run, out=out, progress=False, origin=origin)
        if not (folder / MANIFEST).exists():
            tables = written.read_manifest(manifest)
            tables["protocol"]["budget"] = budget
            tables.pop("agent")
            write_text(folder / MANIFEST, tomli_w.dumps(tables))
        for path in (*(path for path in log.parent.iterdir() if path != log), log):  # the log says it is done
            write_bytes(folder / path.relative_to(out), path.read_bytes())


def read_runs(request: dict[str, Any]) -> Iterator[Any]:
    """The job of that process: problems and budget of a folder of runs, and each one's digest and command."""
    runs = reader.read(Path(request["folder"]), policies=True)
    found = {name: (document.digest, document.command) for name, document in runs.documents.items()}
    broken = (each for each in runs.problems if each.rule not in reader.NOT_OF_TRAINED)
    problems = [f"{each.where}: {each.message}" for each in broken]
    budget = runs.manifest.protocol.budget if runs.manifest else ""
    yield {"problems": problems, "runs": found, "budget": budget}


def take(submission: Submission, folder: Path, value: str = "") -> None:
    """Adds what another job trained, its ``trained`` in ``folder``, to the submission, all or nothing.

    The record is written last. Files of runs that it does not have are those of a machine that died, and are
    written over.

    Raises ``BenchError`` if it is of another version of the code, if its seeds do not follow from the merge
    commit and the value, if it breaks a rule, or if it changes a run or a failure that is known.
    """
    number, known = version_and_record(submission, value)
    record, source = folder / f"{number}.toml", folder / str(number)

    def refusal(message: str) -> BenchError:
        hint = "Write it again with: gym-extensions maintain train-here SUBMISSION"
        return BenchError("bad-training", message, str(record), hint)

    try:
        training = training_of(layout.read_regular(record, layout.max_bytes(layout.REVIEW)))
    except (OSError, ValueError, RecursionError) as error:
        raise refusal(f"It is not a record: {error}.") from error
    if training.seeds != known.seeds:
        raise refusal("Its seeds do not follow from the merge commit, the value and the code.")
    if not (known.runs.items() <= training.runs.items() and known.failed.items() <= training.failed.items()):
        raise refusal("It changes a run that is known.")
    (found,) = limits.answers(read_runs, {"folder": str(source.resolve())}, limits.READING)
    if found["problems"]:
        raise refusal(f"It breaks a rule: {found['problems'][0]}")
    if found["budget"] != STANDARD_BUDGET:
        raise refusal(f"Its runs have the budget {found['budget']}, as a trial has.")
    digests = {key: digest for key, (digest, _) in found["runs"].items()}
    if not training.runs.items() <= digests.items():
        raise refusal("Its runs are not those of the record.")
    if any(training.seeds not in command for _, command in found["runs"].values()):
        raise refusal("A run has other seeds.")
    target, unrecorded = submission.path / TRAINED, digests.keys() - known.runs.keys()
    for item in layout.scan(source).items:
        path, run = target / str(number) / item.path, item.path.partition(".")[0]
        if item.kind == "file" and (run in unrecorded or not path.exists()):
            write_bytes(path, layout.read_regular(source / item.path, item.size))
    # A machine that died has finished more than it could record.
    write_text(target / record.name, training_text(replace(training, runs=digests)))


def repeats(folder: Path) -> str:
    """Trains the code of a submission twice with the budget for trials, and says in words whether the bytes
    are the same.

    Raises ``BenchError`` if no box can be started, the agent fails, or the manifest states another one.
    """
    stated = written.read_manifest(folder / MANIFEST)
    code = f"{folder / AGENT}/{stated['agent']['entry']}"
    factory = cli.isolated(code, [*CORE_GROUPS], ["sequential"], "smoke")
    with tempfile.TemporaryDirectory() as scratch:
        first, second = Path(scratch, "first"), Path(scratch, "second")
        for name in CORE_GROUPS:  # one job alone raises its own error
            for out in (first, second):
                baselines.train(factory, name, "sequential", "smoke", 0, out=out, progress=False)
            made = written.read_manifest(first / MANIFEST)
            made["protocol"]["budget"] = stated["protocol"]["budget"]
            written.require_same(folder / MANIFEST, made)  # what it states is what the code says
            if (stage := _first_difference(first, second, name)) is not None:
                return f"Trained twice, it differs from stage {stage} of {name}: its runs cannot be repeated."
    return "Trained twice, it gives the same bytes."


def _first_difference(first: Path, second: Path, name: str) -> int | None:
    """The first stage whose episodes or policies differ; None if none does."""
    path = layout.run_file(name, "sequential", 0, LOG)
    one, other = (read_log(folder / path) for folder in (first, second))
    arrays = [read_arrays(folder, GROUPS[name], "sequential", 0) for folder in (first, second)]
    for stage in range(len(GROUPS[name].tasks) + 1):
        start = f"{policy_name((stage, None))}/"
        own = [{key: each for key, each in part.items() if key.startswith(start)} for part in arrays]
        is_same = content_sha256(own[0]) == content_sha256(own[1])
        if not is_same or not one[one.stage == stage].equals(other[other.stage == stage]):
            return stage
    return None
