"""Trains an agent and writes its submission: runs the jobs that are missing, and writes each finished run."""

import multiprocessing
import shlex
import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import chain
from pathlib import Path

from gym_extensions.baselines import agent_spec, algorithms, submission, workers
from gym_extensions.baselines.agent import Factory
from gym_extensions.baselines.isolated.proxy import IsolatedAgent
from gym_extensions.baselines.training import runner
from gym_extensions.baselines.training.checkpoints import CONTINUES, FinishedStage
from gym_extensions.baselines.training.jobs import (
    Origin,
    Parallel,
    Settings,
    TrainingJob,
    parse_request,
    require_fit,
)
from gym_extensions.baselines.training.progress import (
    TRAIN_LOG,
    JobFailed,
    Listener,
    Monitor,
    TrainingStarted,
)
from gym_extensions.catalog.groups import Groups
from gym_extensions.catalog.variations import KINDS
from gym_extensions.envs.fingerprinting import require_published_engine
from gym_extensions.errors import BenchError
from gym_extensions.submissions import layout

NO_ORIGIN = Origin()


def train(
    agent: str | Factory,
    groups: Groups,
    protocols: str | Iterable[str],
    budget: str,
    runs: int | Iterable[int],
    *,
    out: str | Path,
    jobs: int | Parallel = 0,
    progress: bool | Monitor = True,
    origin: Origin = NO_ORIGIN,
) -> list[Path]:
    """Trains and evaluates an agent and writes its submission.

    Runs that the submission already contains are not repeated. An interrupted run resumes after its last
    finished stage if the agent can be saved (:class:`gym_extensions.baselines.Resumable`). A run is written
    as soon as its jobs are finished. A job that fails does not stop the others.

    Args:
        agent: the name of a reference agent, ``"path/to/agent.py:factory"``, ``"module:factory"``, or a
            factory.
        groups: a task group or several: names of published groups, ``"core"``, TOML files of custom
            groups, or :class:`gym_extensions.envs.TaskGroup` objects.
        protocols: ``"sequential"``, ``"single"`` or another one (docs/concepts.md), or several.
        budget: ``"smoke"``, ``"100k"``, ``"300k"``, ``"1M"`` or ``"paper"``: training steps per task.
        runs: the number of a run, which is its training seed, from 0 to 99; or several.
        out: the submission's folder.
        jobs: the number of worker processes; 0 trains in this process. A
            :class:`~gym_extensions.baselines.Parallel` also sets environments and threads.
        progress: whether to show the progress. A :class:`~gym_extensions.baselines.Monitor` also has a
            callback and evaluations during training.
        origin: who trains the runs, and from what text their seeds follow; by default, they follow from the
            run's number.

    Returns:
        The paths of the logs of the requested runs, including those that were finished before.

    Raises:
        BenchError: an unknown name, a number out of range, a folder that cannot become the submission or
            belongs to another one or is being written by another process, an agent without a required method,
            actions of a wrong shape, an exceeded budget, a missing extra, or a callback that
            raised an exception. Finished stages stay. ``jobs-failed`` names the jobs that
            failed, after the others have finished; if there is one job and it runs in this process, its own
            exception is raised.

    Example:
        >>> logs = train("random", "hopper-gravity", "single", "smoke", 0, out="mine")  # doctest: +SKIP
    """
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        sys.exit(workers.NO_GUARD)  # this worker process imports the script, whose call would train again
    parallel = jobs if isinstance(jobs, Parallel) else Parallel(jobs)
    monitor = progress if isinstance(progress, Monitor) else Monitor(progress=bool(progress))
    request, path = parse_request(groups, protocols, budget, runs, parallel.num_envs), Path(out)
    if parallel.jobs:
        workers.require_sendable(agent)
    # Whatever cannot become a submission after training is refused before it.
    submission.validate(path, request.groups)
    require_published_engine([task for group in request.groups for task in group.tasks])
    require_fit(request.groups)
    spec = agent_spec.AgentSpec.of(agent, request.logs(), on_boards=request.budget.on_boards)
    settings = Settings(
        spec,
        request.budget,
        parallel.num_envs,
        parallel.num_threads,
        monitor.evaluate_every,
        monitor.evaluate_episodes,
        origin.seeds,
    )
    submission.require_same(path / layout.MANIFEST, submission.manifest_tables(settings))

    def unfinished() -> list[runner.PendingJob]:
        missing = [submission.missing_jobs(path, *log, request.runs) for log in request.logs()]
        return [runner.PendingJob(job, settings, path) for job in chain.from_iterable(missing)]

    titles = dict.fromkeys(each.job.run_title for each in unfinished())
    if titles:
        submission.prepare(path)
    with submission.lock_runs(path, titles), monitor.listening(path) as listen:
        pending = unfinished()  # another process may have finished a run before the locks were held
        listen(TrainingStarted({each.title: each.steps for each in pending}))
        failures = _run(pending, listen, parallel.jobs, origin.by)
    if failures:
        if len(pending) == 1 and (error := next(iter(failures.values())).error):
            raise error
        hint = f"Tracebacks are in {path / layout.PROGRESS / TRAIN_LOG}. {CONTINUES}"
        raise workers.jobs_failed(failures, len(pending), hint)
    runs_of = [(group.name, protocol, run) for group, protocol in request.logs() for run in request.runs]
    return [path / layout.run_file(*each, layout.LOG) for each in runs_of]


def _run(
    pending: Sequence[runner.PendingJob], listen: Listener, processes: int, by: str
) -> dict[str, workers.Failure]:
    """Runs the jobs and writes each run when its last job has finished. Returns failures by title."""
    unfinished = Counter(each.job.run_title for each in pending)
    finished: dict[str, dict[TrainingJob, list[FinishedStage]]] = {title: {} for title in unfinished}
    failures: dict[str, workers.Failure] = {}
    commit = submission.commit_of(Path.cwd())
    for index, outcome in workers.run(pending, listen, processes):
        each, job = pending[index], pending[index].job
        if isinstance(outcome, workers.Failure):
            failures[job.title] = outcome
        else:
            of_run = finished[job.run_title]
            of_run[job] = outcome
            if len(of_run) == unfinished[job.run_title]:
                how = {"command": command_of(each), "commit": commit, "by": by}
                try:
                    submission.write_run_files(each.out, of_run, each.settings, **how)
                except (OSError, BenchError) as error:
                    failures[job.title] = workers.failure_of(error, in_this_process=True)
        if failure := failures.get(job.title):
            listen(JobFailed(job.title, failure.cause, failure.traceback, failure.code))
    return failures


def command_of(pending: runner.PendingJob) -> str:
    """The command line that trains a job's run alone; empty for a factory that has no name in a module."""
    job, settings, agent = pending.job, pending.settings, pending.settings.agent.factory
    variations = (each for task in job.group.tasks for each in task.variations)
    if any(type(each) not in KINDS.values() for each in variations):
        return ""  # no file of a group can name the user's own classes
    options = []
    if isinstance(agent, IsolatedAgent):
        options, agent = ["--isolated"], agent.written
    elif isinstance(agent, str):
        path, attribute = algorithms.place_of(agent)
        agent = f"{path.name}:{attribute}" if path else agent
    else:
        module, name = getattr(agent, "__module__", ""), getattr(agent, "__qualname__", "")
        if module == "__main__":  # the agent's script; a notebook has none
            module = Path(getattr(sys.modules[module], "__file__", None) or "").stem
        if not all(map(str.isidentifier, [*module.split("."), name])):
            return ""
        agent = f"{module}:{name}"
    words = ["gym-extensions", "train", *options, agent]
    words += ["--groups", job.group.name if job.group.published else f"{job.group.name}.toml"]
    words += ["--protocol", job.protocol, "--budget", settings.budget.name, "--runs", str(job.run)]
    if settings.num_envs is not None:
        words += ["--num-envs", str(settings.num_envs)]
    if settings.evaluate_every is not None:
        words += ["--evaluate-every", str(settings.evaluate_every)]
        words += ["--evaluate-episodes", str(settings.evaluate_episodes)]
    if settings.seeds:
        words += ["--seeds", settings.seeds]
    return shlex.join([*words, "--out", pending.out.resolve().name])
