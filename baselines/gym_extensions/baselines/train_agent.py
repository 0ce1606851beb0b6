"""Trains an agent and writes its submission: runs the jobs that are missing, and writes each finished run."""

from __future__ import annotations

import multiprocessing
import shlex
import shutil
import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any

from gym_extensions.baselines import algorithms, submission, workers
from gym_extensions.baselines.agent import Card, Factory, TaskLabel
from gym_extensions.baselines.agent_checks import card_of, create_agent, observes_of
from gym_extensions.baselines.training import arguments
from gym_extensions.baselines.training.arguments import Groups, Request
from gym_extensions.baselines.training.checkpoints import CONTINUES, FinishedStage
from gym_extensions.baselines.training.evaluation import (
    first_actions,
    policy_of,
    require_agreement,
    require_submittable,
)
from gym_extensions.baselines.training.events import JobFailed, Listener, TrainingStarted
from gym_extensions.baselines.training.jobs import Settings, TrainingJob
from gym_extensions.baselines.training.progress import TRAIN_LOG, open_listeners, parse_logs
from gym_extensions.baselines.training.runner import PendingJob
from gym_extensions.baselines.training.usage import commit_of
from gym_extensions.baselines.workers import Failure, failure_of, jobs_failed, require_sendable
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import evaluation_seed
from gym_extensions.catalog.tasks import whole_number
from gym_extensions.envs import make_vec
from gym_extensions.envs.fingerprinting import require_published_engine
from gym_extensions.errors import BenchError
from gym_extensions.submissions.layout import DOCUMENT, LOG, MANIFEST, PROGRESS, run_file
from gym_extensions.submissions.manifest import RECORDED
from gym_extensions.submissions.run import LONGEST, read_run

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
    num_envs: int | None = None,
    num_threads: int = 1,
    progress: bool = True,
    log: str | Iterable[str] | None = None,
    callback: Listener | None = None,
    evaluate_every: int | None = None,
    evaluate_episodes: int = INTERIM_EPISODES,
    by: str = "",
) -> list[Path]:
    """Trains and evaluates an agent and writes its submission.

    Runs that the submission already contains are not repeated. An interrupted run resumes after its last
    finished stage if the agent can be saved (:class:`gym_extensions.baselines.Resumable`). A run is written
    as soon as its jobs are finished. A job that fails does not stop the others.

    Args:
        agent: the name of a reference agent, ``"module:factory"``, or a factory.
        groups: a task group or several: names of published groups, ``"core"``, TOML files of custom
            groups, or :class:`gym_extensions.envs.TaskGroup` objects.
        protocols: ``"sequential"``, ``"single"``, ``"joint"`` or ``"cumulative"``, or several.
        budget: ``"smoke"``, ``"100k"``, ``"300k"``, ``"1M"`` or ``"paper"``: training steps per task.
        runs: the number of a run, which is its training seed, from 0 to 99; or several.
        out: the submission's folder.
        jobs: number of worker processes with one thread each; the factory must pickle. 0 trains in this
            process with its number of threads.
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
            end of a batch, on the tasks that are evaluated after the stage. None
            evaluates after each stage only. Neither what is learned nor the logs depend on it if the agent
            can be saved; docs/submit.md says what is guaranteed for other agents.
        evaluate_episodes: episodes per task of these evaluations, from 1 to 20.
        by: who trains the runs, at most 200 characters: for runs that are donated to a submission of others.

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
    request = arguments.parse_request(groups, protocols, budget, runs, num_envs)
    num_threads = whole_number("num_threads", num_threads, "bad-num-threads", "--num-threads")
    interim, logs = arguments.parse_interim(evaluate_every, evaluate_episodes), parse_logs(log)
    if not isinstance(by, str) or len(by) > LONGEST:
        raise BenchError("bad-by", f"It is not text of at most {LONGEST} characters.", "--by", "Shorten it.")
    path = Path(out)
    if jobs != 0:
        jobs = whole_number("jobs", jobs, "bad-jobs", "--jobs")
        require_sendable(agent)
    settings = Settings(algorithms.name_of(agent), request.budget.name, request.num_envs)
    settings = _checked(algorithms.factory(agent), settings, path, request)
    titles = dict.fromkeys(job.run_title for job in _plan(path, request))
    if titles:
        submission.prepare(path)
    listeners = open_listeners(path, progress=progress, logs=logs, callback=callback)
    with submission.lock_runs(path, titles), listeners as listen:
        # Another process may have finished a run before the locks were held.
        left = _plan(path, request)
        pending = [PendingJob(job, agent, settings, path, interim, num_threads) for job in left]
        listen(TrainingStarted(tuple(each.plan for each in pending), max(jobs, 1)))
        failures = _run(pending, listen, jobs, by)
    if failures:
        if len(pending) == 1 and (error := next(iter(failures.values())).error):
            raise error
        hint = f"Tracebacks are in {path / PROGRESS / TRAIN_LOG}. {CONTINUES}"
        raise jobs_failed(failures, len(pending), hint)
    runs_of = [(group.name, protocol, run) for group, protocol in request.logs() for run in request.runs]
    return [path / run_file(*each, LOG) for each in runs_of]


def retrain(folder: Path, group: TaskGroup, protocol: str, run: int, out: Path) -> Path:
    """Trains one run of a submission again with the reference agent that its manifest names.

    The submission in ``folder`` stays as it is; ``out`` is the folder of the new submission, which may be an
    unfinished one of an earlier call. Returns the path of the log; document and policies are beside it.

    Raises:
        BenchError: the training of the submission was not recorded, no reference agent has its name, or the
            agent is another one or has other settings.
    """
    path, budget = folder / MANIFEST, str(_recorded_protocol(folder)["budget"])
    options: dict[str, Any] = {"out": out, "progress": False}
    options["num_envs"] = submission.read_manifest(path).get("hyperparameters", {}).get("num_envs")
    agent = reference_agent(folder)
    out.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(path, out / MANIFEST)  # with it in place, another agent or setting is refused
    document = folder / run_file(group.name, protocol, run, DOCUMENT)
    if document.exists() and (evaluations := read_run(document).evaluations):
        # An agent that cannot be saved acts itself in them, so its run depends on them.
        options |= {"evaluate_every": evaluations[0].steps[0], "evaluate_episodes": evaluations[0].episodes}
    try:
        (log,) = train(agent, [group], protocol, budget, run, **options)
    except BenchError as error:
        if error.code != "mixed-submission":
            raise
        hint = "Check out the commit of the run."
        raise BenchError("not-reproducible", error.message, str(path), hint) from error
    return log


def reference_agent(folder: Path) -> str:
    """The reference agent that a submission's manifest names.

    Raises ``BenchError`` if the training of the submission was not recorded, or no reference agent has its
    name.
    """
    name = _recorded_protocol(folder)["algorithm"]
    if name not in algorithms.names():
        message = f"The algorithm {name!r} is not a reference agent."
        hint = "Train the submission's own agent by hand."
        raise BenchError("not-reproducible", message, str(folder / MANIFEST), hint)
    return str(name)


def _recorded_protocol(folder: Path) -> dict[str, Any]:
    """The section ``protocol`` of a manifest. Raises ``BenchError`` if the training was not recorded."""
    tables = submission.read_manifest(folder / MANIFEST)
    table: dict[str, Any] = {"algorithm": "", "budget": "", "steps": RECORDED} | tables.get("protocol", {})
    if table["steps"] != RECORDED or "reported" in tables:
        message = "The training of this submission was not recorded, so it cannot be repeated."
        raise BenchError("not-reproducible", message, str(folder / MANIFEST), "Verify without --retrain.")
    return table


def _run(pending: Sequence[PendingJob], listen: Listener, jobs: int, by: str) -> dict[str, Failure]:
    """Runs the jobs and writes each run when its last job has finished. Returns failures by title."""
    unfinished = Counter(each.job.run_title for each in pending)
    finished: dict[str, dict[TrainingJob, list[FinishedStage]]] = {title: {} for title in unfinished}
    failures: dict[str, Failure] = {}
    commit = commit_of(Path.cwd())
    for index, outcome in workers.run(pending, listen, jobs):
        each, job = pending[index], pending[index].job
        if isinstance(outcome, Failure):
            failures[job.title] = outcome
        else:
            of_run = finished[job.run_title]
            of_run[job] = outcome
            if len(of_run) == unfinished[job.run_title]:
                how = {"command": command_of(each), "commit": commit, "by": by}
                try:
                    submission.write_run_files(each.out, of_run, each.settings, **how)
                except (OSError, BenchError) as error:
                    failures[job.title] = failure_of(error, in_this_process=True)
        if failure := failures.get(job.title):
            listen(JobFailed(job.title, failure.cause, failure.traceback))
    return failures


def command_of(pending: PendingJob) -> str:
    """The command line that trains a job's run alone."""
    job, settings, interim, agent = pending.job, pending.settings, pending.interim, pending.agent
    if not isinstance(agent, str):
        module, name = getattr(agent, "__module__", ""), getattr(agent, "__qualname__", "")
        if module == "__main__":  # the agent's script; a notebook has none
            module = Path(getattr(sys.modules[module], "__file__", None) or "").stem
        agent = f"{module}:{name}" if module and name else settings.agent
    words = ["gym-extensions", "train", agent]
    words += ["--groups", job.group.name if job.group.published else f"{job.group.name}.toml"]
    words += ["--protocol", job.protocol, "--budget", settings.budget, "--runs", str(job.run)]
    if settings.num_envs is not None:
        words += ["--num-envs", str(settings.num_envs)]
    if interim is not None:
        words += ["--evaluate-every", str(interim.every), "--evaluate-episodes", str(interim.episodes)]
    return shlex.join([*words, "--out", pending.out.resolve().name])


def _plan(out: Path, request: Request) -> list[TrainingJob]:
    """The jobs of the requested runs that are not finished."""
    logs = (submission.missing_jobs(out, *log, request.runs) for log in request.logs())
    return list(chain.from_iterable(logs))


def _checked(make: Factory, settings: Settings, out: Path, request: Request) -> Settings:
    """The settings with what the agent asks to observe.

    Raises ``BenchError`` before training for anything that cannot become a submission after it.
    """
    submission.validate(out, request.groups)
    require_published_engine([task for group in request.groups for task in group.tasks])
    arguments.require_equal_spaces(request.groups)
    settings, card = agent_settings(make, settings, request.logs())
    path, tables = out / MANIFEST, submission.manifest_tables(card, settings)
    submission.require_same(path, submission.read_manifest(path), tables)
    return settings


def agent_settings(
    make: Factory, settings: Settings, logs: Sequence[tuple[TaskGroup, str]]
) -> tuple[Settings, Card]:
    """The settings with what an agent states and asks to observe, and its card.

    Raises ``BenchError`` if the factory, the agent or its card does not fit, the agent's actions have a wrong
    shape or are not those of its policy, or the submission, with these groups and protocols, may not contain
    the policy.
    """
    group, _ = logs[0]
    env = make_vec(group.tasks[0], 1)
    agent = create_agent(make, (env.single_observation_space, env.single_action_space), settings.agent)
    card, observes = card_of(agent, settings.agent), observes_of(agent, settings.agent)
    seeds, label = [evaluation_seed(group.id, group.task_ids[0], 0)], TaskLabel(group.task_ids[0], 0)
    actions = first_actions(agent, env, seeds, label if observes.task_in_evaluation else None)
    if (policy := policy_of(agent)) is not None:
        require_agreement(policy, env, seeds, actions, 0)
        for log in logs:
            require_submittable(policy, card, observes, *log)
    env.close()
    stated = {"hyperparameters": card.hyperparameters, "packages": card.packages}
    return replace(settings, observes=observes, **stated), card  # type: ignore[arg-type]
