"""Trains an agent and writes its submission: runs the jobs that are missing, and writes each complete run."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from gym_extensions.baselines import algorithms
from gym_extensions.baselines.agent import Factory
from gym_extensions.baselines.agent_checks import card_of, create_agent
from gym_extensions.baselines.context_checks import observes_of
from gym_extensions.baselines.execution.executors import JobExecutor, open_executor
from gym_extensions.baselines.execution.failures import Failure, failure_of, jobs_failed
from gym_extensions.baselines.reporting.files import TRAIN_LOG
from gym_extensions.baselines.reporting.listeners import check_callback, open_listeners, parse_logs
from gym_extensions.baselines.submission import folder, manifest
from gym_extensions.baselines.submission.lock import lock_all
from gym_extensions.baselines.submission.writer import missing_jobs, write_log
from gym_extensions.baselines.training.events import JobFailed, Listener, TrainingStarted
from gym_extensions.baselines.training.jobs import Settings, TrainingJob
from gym_extensions.baselines.training.progress import FinishedStage, next_step
from gym_extensions.baselines.training.request import (
    Groups,
    Request,
    parse_interim,
    parse_request,
    require_equal_spaces,
    require_positive,
)
from gym_extensions.baselines.training.runner import PendingJob
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.envs import make_vec
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.layout import MANIFEST, PROGRESS

INTERIM_EPISODES = 5
"""Episodes per task of an evaluation during training."""


def train(
    agent: str | Factory,
    groups: Groups,
    protocols: str | Iterable[str],
    budget: str,
    runs: int | Iterable[int],
    *,
    out: str | Path,
    jobs: int = 0,
    ray: str | None = None,
    num_envs: int | None = None,
    num_threads: int = 1,
    progress: bool = True,
    log: str | Iterable[str] | None = None,
    callback: Listener | None = None,
    evaluate_every: int | None = None,
    evaluate_episodes: int = INTERIM_EPISODES,
) -> list[Path]:
    """Trains and evaluates an agent and writes its submission.

    Runs that the submission already contains are not repeated. An interrupted run resumes after its last
    finished stage if the agent can be saved (:class:`gym_extensions.baselines.Resumable`). A run is written
    as soon as its jobs are finished. A job that fails does not stop the others.

    Args:
        agent: the name of a reference agent, ``"module:factory"``, or a factory.
        groups: a task group or several: names of published groups, TOML files of custom groups, or
            :class:`gym_extensions.envs.TaskGroup` objects.
        protocols: ``"sequential"``, ``"single"`` or ``"joint"``, or several.
        budget: ``"smoke"``, ``"100k"``, ``"300k"``, ``"1M"`` or ``"paper"``: training steps per task.
        runs: a training seed from 0 to 999, or several.
        out: the submission's folder.
        jobs: number of worker processes with one thread each; the factory must pickle. 0 trains in this
            process with its number of threads.
        ray: runs the jobs on an existing Ray cluster instead: ``"auto"`` or its address, such as
            ``"10.0.0.5:6379"``. Needs the extra ``cluster`` (docs/cluster.md).
        num_envs: number of training environments; the budget's if None.
        num_threads: threads that step the training environments of one job, for one long job on several
            processors. Results do not depend on it.
        progress: whether to show training return, steps per second and time left: bars in a terminal, lines
            elsewhere. The file ``out/.progress/train.log`` has them in any case.
        log: ``"csv"`` (``out/.progress/events.csv``), ``"tensorboard"`` (``out/.progress/tensorboard``; needs
            the extra ``log``), or both.
        callback: called in this process with every event: :class:`~gym_extensions.baselines.TrainingStarted`,
            ``StageStarted``, ``BatchTrained``, ``TaskEvaluated``, ``JobFinished``, ``JobFailed``. An
            exception stops the training.
        evaluate_every: training steps of a stage between evaluations during training, which are made at the
            end of a batch, on the tasks that are evaluated after the stage (``evaluations.csv``). None
            evaluates after each stage only. Neither what is learned nor the logs depend on it if the agent
            can be saved; docs/submit.md says what is guaranteed for other agents.
        evaluate_episodes: episodes per task of these evaluations, from 1 to 20.

    Returns:
        The paths of the requested logs, including those that were complete before.

    Raises:
        BenchError: an unknown name, a number out of range, a folder that cannot become the submission or
            belongs to another one or is being written by another process, an agent without a required method,
            actions of a wrong shape, an exceeded budget, a missing extra, an unreachable Ray cluster,
            or a callback that raised an exception. Finished stages stay. ``jobs-failed`` names the jobs that
            failed, after the others have finished; if there is one job and it runs in this process, its own
            exception is raised.

    Example:
        >>> logs = train("random", "hopper-gravity", "single", "smoke", 0, out="mine")  # doctest: +SKIP
    """
    request = parse_request(groups, protocols, budget, runs, num_envs)
    require_positive(num_threads, "--num-threads")
    interim, logs = parse_interim(evaluate_every, evaluate_episodes), parse_logs(log)
    check_callback(callback)
    path = Path(out)
    settings = Settings(algorithms.name_of(agent), request.budget.name, num_envs)
    settings = _checked(algorithms.factory(agent), settings, path, request)
    run_titles = dict.fromkeys(job.run_title for missing in _plan(path, request).values() for job in missing)
    if run_titles:
        folder.prepare(path)
    listeners = open_listeners(path, progress=progress, logs=logs, callback=callback)
    with open_executor(ray, jobs) as executor, lock_all(path, run_titles), listeners as listen:
        plan = _plan(path, request)  # another process may have finished a run before the locks were held
        pending = [
            PendingJob(job, agent, settings, path, interim, num_threads)
            for missing in plan.values()
            for job in missing
        ]
        plans = (each.job.plan(request.budget, interim) for each in pending)
        listen(TrainingStarted(tuple(plans), executor.slots))
        failures = _run(pending, executor, listen)
    if len(pending) == 1:
        for failure in failures.values():
            if failure.error is not None:
                raise failure.error
    if failures:
        repeated = [title for title, failure in failures.items() if failure.can_repeat]
        then = f" {next_step(path, repeated)}" if repeated else ""
        hint = f"Tracebacks are in {path / PROGRESS / TRAIN_LOG}.{then}"
        raise jobs_failed(failures, len(pending), hint)
    return [path / group.name / f"{protocol}.csv" for group, protocol in plan]


def _run(pending: Sequence[PendingJob], executor: JobExecutor, listen: Listener) -> dict[str, Failure]:
    """Runs the jobs and writes each run when its last job has finished. Returns failures by title."""
    unfinished = Counter(each.job.run_key for each in pending)
    finished: dict[TrainingJob, list[FinishedStage]] = {}
    failures: dict[str, Failure] = {}
    for index, outcome in executor.run(pending, listen):
        job = pending[index].job
        if isinstance(outcome, Failure):
            failures[job.title] = outcome
        else:
            finished[job] = outcome
            unfinished[job.run_key] -= 1
            if not unfinished[job.run_key]:
                results = {
                    other: finished.pop(other) for other in list(finished) if other.run_key == job.run_key
                }
                try:
                    write_log(pending[index].out, job.group, job.protocol, results, pending[index].settings)
                except (OSError, BenchError) as error:
                    failures[job.title] = failure_of(error, in_this_process=True)
        if job.title in failures:
            listen(JobFailed(job.title, failures[job.title].cause, failures[job.title].traceback))
    return failures


def _plan(out: Path, request: Request) -> dict[tuple[TaskGroup, str], list[TrainingJob]]:
    """The jobs to run for every log."""
    return {
        (group, protocol): missing_jobs(out, group, protocol, request.runs)
        for group, protocol in request.logs()
    }


def _checked(make: Factory, settings: Settings, out: Path, request: Request) -> Settings:
    """The settings with what the agent asks to observe.

    Raises ``BenchError`` before training for anything that cannot become a submission after it.
    """
    folder.validate(out, request.groups)
    require_equal_spaces(request.groups)
    path = out / MANIFEST
    existing = manifest.read(path)
    env = make_vec(request.groups[0].tasks[0], 1)
    agent = create_agent(make, (env.single_observation_space, env.single_action_space), settings.agent)
    card = card_of(agent, settings.agent)
    env.close()
    observes = observes_of(agent, settings.agent)
    settings = replace(
        settings, observes=observes, hyperparameters=card.hyperparameters, packages=card.packages
    )
    new = manifest.run_sections(card, settings.budget, settings.num_envs, settings.observes)
    manifest.require_same(path, existing, new)
    return settings
