"""Writes a submission: its manifest once, and every finished run as a log, a document and policies.

Nothing belongs to two runs, so runs of several machines are joined by copying their files.
"""

import datetime
import hashlib
import platform
import subprocess
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import tomli_w
from filelock import FileLock, Timeout

from gym_extensions.baselines import agent, agent_spec
from gym_extensions.baselines.isolated.proxy import IsolatedAgent
from gym_extensions.baselines.training.checkpoints import FinishedStage, JobFolder, job_versions
from gym_extensions.baselines.training.jobs import Settings, TrainingJob, jobs_of
from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.envs.fingerprinting import fingerprint_of
from gym_extensions.errors import BenchError
from gym_extensions.files import write_bytes
from gym_extensions.submissions import layout, run as documents
from gym_extensions.submissions.layout import AGENT, DOCUMENT, LOG, MANIFEST, PROGRESS
from gym_extensions.submissions.log import log_text
from gym_extensions.submissions.policies.files import content_sha256, policy_files, size_error
from gym_extensions.submissions.policies.onnx import RUNTIME
from gym_extensions.versions import version

SHARED_SECTIONS = ("protocol", "hyperparameters", "observes")
"""Sections of the manifest that are the same in every run of a submission."""
DEFAULTS = {"protocol": {"parent": ""}}
"""Values of keys that a manifest may leave out."""
ANOTHER = "Choose another --out."
ONE_SETTING = "A submission has one algorithm, budget and set of hyperparameters; choose another --out."
DERIVED = "This section follows from the agent's attribute observes. Change that, or choose another --out."

Tables = Mapping[str, Any]


def validate(out: Path, groups: Iterable[TaskGroup] = ()) -> None:
    """Checks that ``out`` is, or can become, the folder of a submission of ``groups``. Changes nothing.

    Raises ``BenchError`` if the name is not allowed, ``out`` is a file, not accessible or inside another
    submission, it contains folders that are not groups, it contains runs without a manifest, the log of a run
    is damaged, or a document states another order than its place.
    """
    known = GROUPS | {group.name: group for group in groups}
    with _reports_access(out):
        name = out.resolve().name
        if not layout.NAME.fullmatch(name):
            message = f"{name!r} is not a valid submission name."
            raise BenchError("bad-out", message, str(out), layout.NAME_HINT)
        around = next((each for each in out.resolve().parents if (each / MANIFEST).exists()), None)
        if around and not layout.TRAINED_VERSION.fullmatch(out.resolve().relative_to(around).as_posix()):
            raise BenchError("bad-out", f"It is inside the submission {around}.", str(out), ANOTHER)
        if not out.exists():
            return
        if not out.is_dir():
            raise BenchError("bad-out", "A submission is a folder, and this is a file.", str(out), ANOTHER)
        folders = sorted(path.name for path in out.iterdir() if path.is_dir())
        allowed = {*known, PROGRESS, AGENT, *layout.WRITTEN}
        unexpected = [folder for folder in folders if folder not in allowed]
        if unexpected:
            message = f"Unexpected folder {unexpected[0]!r}: no published group, and none of those named."
            hint = "Name the file of a custom group, too; else move the folder, or choose another --out."
            raise BenchError("bad-out", message, str(out), hint)
        runs = [path for folder in folders if folder in known for path in (out / folder).glob(f"*/run*{LOG}")]
        if runs and not (out / MANIFEST).exists():
            message = f"The folder contains {runs[0].relative_to(out)} but no {MANIFEST}."
            hint = f"Restore {MANIFEST}, or choose another --out."
            raise BenchError("manifest-lost", message, str(out), hint)
        for path in runs:
            document = path.with_suffix(DOCUMENT)
            made = documents.read_run(document) if document.exists() else None
            if made is None or made.log != documents.file_sha256(path):
                message = "The run is damaged: its document is missing or states another log."
                hint = f"Restore it, or delete {path.stem}.* to train the run again."
                raise BenchError("damaged-run", message, str(path), hint)
            group, protocol, run = known[path.parts[-3]], path.parts[-2], int(path.stem.removeprefix("run"))
            if message := documents.order_error(made, group, protocol, run):
                hint = "Move its files to where they belong, or choose another --out."
                raise BenchError("wrong-order", message, str(document), hint)


def prepare(out: Path) -> None:
    """Creates the folder and that of unfinished runs. Raises ``BenchError`` if they are not writable."""
    with _reports_access(out):
        (out / PROGRESS).mkdir(parents=True, exist_ok=True)
        for probe in (out / ".probe", out / PROGRESS / ".probe"):
            probe.touch()
            probe.unlink(missing_ok=True)


@contextmanager
def _reports_access(out: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        message = f"The folder is not writable: {error.strerror or error}."
        raise BenchError("bad-out", message, str(out), ANOTHER) from error


@contextmanager
def lock_runs(out: Path, titles: Iterable[str], seconds: float = 0.0) -> Iterator[None]:
    """Holds the locks of several runs, so that one process at a time trains and writes a run.

    The operating system releases a lock when its process ends, so that a lock is never stale. ``seconds`` is
    how long to wait for another process.

    Raises ``BenchError`` if another process holds a lock.
    """
    with ExitStack() as locks:
        for title in titles:
            path = out / PROGRESS / "locks" / f"{title}.lock"
            try:
                locks.enter_context(FileLock(path, timeout=seconds))
            except Timeout as busy:
                message = f"{title!r} is being trained or recorded by another process."
                hint = "Wait until it has finished or end it, choose other runs, or choose another --out."
                raise BenchError("two-writers", message, str(out), hint) from busy
        yield


def missing_jobs(out: Path, group: TaskGroup, protocol: str, runs: Sequence[int]) -> list[TrainingJob]:
    """The jobs of the runs that have no log. Folders of jobs whose run has one are deleted."""
    paths = (out / group.name / protocol).glob(f"run*{LOG}")
    finished = {int(match[1]) for path in paths if (match := layout.RUN_FILE.fullmatch(path.name))}
    for job in jobs_of(group, protocol, sorted(finished)):
        JobFolder(out, job).remove()
    return jobs_of(group, protocol, [run for run in runs if run not in finished])


def read_manifest(path: Path) -> dict[str, Any]:
    """The manifest's tables, empty if the file does not exist. Raises ``BenchError`` if it is not TOML."""
    if not path.exists():
        return {}
    try:
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        hint = "Correct the file, or choose another --out."
        raise BenchError("bad-manifest", f"The file is not valid TOML: {error}.", str(path), hint) from error


def manifest_tables(settings: Settings) -> dict[str, Any]:
    """The manifest of a new submission, with values as TOML reads them back."""
    tables = agent_spec.card_tables(settings.agent.card, settings.agent.observes)
    tables["protocol"] |= {"budget": settings.budget.name}
    if settings.num_envs is not None:
        tables["hyperparameters"] |= {"num_envs": settings.num_envs}
    return tomllib.loads(tomli_w.dumps(tables))


def require_same(path: Path, new: Tables) -> Tables:
    """The manifest at ``path``, empty if there is none.

    Raises ``BenchError`` if it differs from ``new`` in what must be the same in every run.
    """
    existing = read_manifest(path)
    for section in SHARED_SECTIONS:
        if (stated := existing.get(section)) is None:
            continue
        old, default = stated, DEFAULTS.get(section, {})
        for key in sorted(old.keys() | new[section].keys()):
            previous, current = (each.get(key, default.get(key)) for each in (old, new[section]))
            if previous != current:
                first, second = ("not stated" if each is None else repr(each) for each in (previous, current))
                message = f"{section}.{key} is {first} in this submission and {second} in the new run."
                hint = DERIVED if section == "observes" else ONE_SETTING
                raise BenchError("mixed-submission", message, str(path), hint)
    return existing


def joined(texts: Iterable[str]) -> str:
    """The distinct texts, as one of at most ``documents.LONGEST`` characters."""
    return ", ".join(dict.fromkeys(filter(None, texts)))[: documents.LONGEST]


def commit_of(folder: Path) -> str:
    """The commit of the folder's git repository; empty without one, with ``-dirty`` if there are changes."""
    command = ["git", "-C", str(folder), "describe", "--always", "--abbrev=40", "--dirty", "--exclude=*"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=10, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""


def run_versions(kernels: Iterable[str]) -> documents.Versions:
    """The versions of the packages, of Python and of the platform, with the BLAS kernels of the stages."""
    return documents.Versions(
        **job_versions(),
        python=platform.python_version(),
        platform=f"{platform.system()}-{platform.machine()}",
        blas=joined(kernels),
    )


def write_run_files(
    out: Path,
    finished: Mapping[TrainingJob, Sequence[FinishedStage]],
    settings: Settings,
    *,
    command: str = "",
    commit: str = "",
    by: str = "",
) -> None:
    """Writes a finished run, creates the manifest if there is none, and deletes the folders of the jobs.

    Each file is written whole, the log last. If one cannot be, for a full disk, the others of the run are
    removed, and the call can be repeated. The manifest stays: other processes may have written runs.

    Args:
        out: the submission's folder.
        finished: the stages of all jobs of the run.
        settings: how they ran.
        command, commit, by: what trains the run, the commit of the code, and who trained it.

    Raises ``BenchError`` if another process has made the folder the submission of another agent.
    """
    jobs = sorted(finished, key=lambda job: job.task or 0)
    records = [record for job in jobs for record in finished[job]]
    group, protocol, run = jobs[0].group, jobs[0].protocol, jobs[0].run
    existing = require_same(out / MANIFEST, manifest_tables(settings))
    policies = _policies([JobFolder(out, job) for job in jobs])
    files = policy_files(policies) if policies else {}
    size = sum(map(len, files.values()))
    packages = [*settings.agent.card.packages]
    packages += [RUNTIME] if any(suffix.endswith(layout.NETWORK) for suffix in files) else []
    log = log_text([each for record in records for each in record.episodes], group.task_ids).encode()
    usages, measured = [record.usage for record in records], dict[str, Any]()
    if settings.steps_counted:
        measured["cpu_seconds"] = round(sum(used.cpu_seconds for used in usages), 3)
        measured["peak_memory_mb"] = max(used.peak_memory_mb for used in usages) or None
    document = documents.RunDocument(
        group=group.id,
        protocol=protocol,  # type: ignore[arg-type]
        run=run,
        order=documents.order_of(group, protocol, run),
        command=command,
        commit=commit,
        by=by,
        date=datetime.datetime.now(datetime.UTC).date().isoformat(),
        versions=run_versions(used.kernels for used in usages),
        packages={package: version(package) for package in packages},
        machine=documents.Machine(
            processor=joined(used.processor for used in usages), cores=max(used.cores for used in usages)
        ),
        steps=sum(used.steps for used in usages),
        steps_counted=settings.steps_counted,
        memory=documents.Memory(
            stored_steps=max(record.memory.stored_steps for record in records),
            parameters_first=max(stages[0].memory.parameters_first for stages in finished.values()),
            parameters_last=max(record.memory.parameters_last for record in records),
        ),
        fingerprints={task.id: fingerprint_of(task) for task in group.tasks},
        curves=[curve for record in records for curve in record.curves],
        evaluations=[each for record in records for each in record.evaluations],
        arithmetic=documents.ARITHMETIC,
        log=hashlib.sha256(log).hexdigest(),
        policies=documents.PolicyFile(sha256=content_sha256(policies), size=size) if policies else None,
        **measured,
    )

    def place(suffix: str) -> Path:
        return out / layout.run_file(group.name, protocol, run, suffix)

    new = {place(suffix): data for suffix, data in files.items()}
    new[place(DOCUMENT)] = documents.run_text(document).encode()
    if not existing:
        new[out / MANIFEST] = _manifest_text(out, settings).encode()
    new[place(LOG)] = log
    try:
        for path, data in new.items():
            write_bytes(path, data)
    except BaseException:  # a full disk, Ctrl-C
        for path in new.keys() - {out / MANIFEST}:
            path.unlink(missing_ok=True)
        raise
    for job in jobs:
        JobFolder(out, job).remove()


def _manifest_text(out: Path, settings: Settings) -> str:
    """A new manifest; it states the code of an agent that was trained in a box and lies in the folder."""
    tables, agent = manifest_tables(settings), settings.agent.factory
    code = out.resolve() / AGENT
    if isinstance(agent, IsolatedAgent) and agent.path and agent.path.resolve().is_relative_to(code):
        file = "__init__.py" if agent.path.is_dir() else agent.path.name
        packages = list(settings.agent.card.packages)
        tables["agent"] = {"entry": f"{file}:{agent.attribute}", "packages": packages}
    return tomli_w.dumps(tables)


def _policies(jobs: Sequence[JobFolder]) -> dict[str, agent.Array]:
    """The arrays of the policies of all jobs; empty if there are none.

    Raises ``BenchError`` if only some of them are there, or if they exceed a limit. Nothing is deleted.
    """
    arrays: dict[str, agent.Array] = {}
    missing: list[Path] = []
    for job in jobs:
        part, absent = job.policies()
        arrays, missing = arrays | part, missing + absent
    if not arrays:
        return {}
    message = f"{missing[0].name} is missing, but other stages have a policy." if missing else ""
    if message := message or size_error(arrays):
        hint = "Record the stage with a policy, or delete the files policy*.npz to write the run without."
        raise BenchError("bad-policies", message, str((missing or [jobs[0].path])[0]), hint)
    return arrays
