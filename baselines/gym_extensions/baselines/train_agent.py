"""Trains an agent and writes its submission: the jobs that are missing, then the files."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path

from gym_extensions.baselines import algorithms
from gym_extensions.baselines.agent import Factory
from gym_extensions.baselines.agent_checks import card_of, create_agent
from gym_extensions.baselines.context_checks import observes_of
from gym_extensions.baselines.submission import folder, manifest
from gym_extensions.baselines.submission.writer import missing_jobs, write_log
from gym_extensions.baselines.training.events import Listener
from gym_extensions.baselines.training.jobs import Settings, TrainingJob
from gym_extensions.baselines.training.progress import FinishedStage
from gym_extensions.baselines.training.request import Groups, Request, parse_request
from gym_extensions.baselines.training.runner import PendingJob
from gym_extensions.baselines.training.workers import run_all
from gym_extensions.envs import make_vec
from gym_extensions.rollouts.layout import MANIFEST

PlanListener = Callable[[Mapping[str, int]], object]
"""Called once with the number of evaluations of every job to run, by the job's title."""


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
    on_event: Listener = lambda _: None,
    on_plan: PlanListener = lambda _: None,
) -> list[Path]:
    """Trains and evaluates an agent and writes its submission.

    Runs that the submission already contains are not repeated. An interrupted run resumes after its last
    finished stage if the agent can be saved (:class:`gym_extensions.baselines.Resumable`).

    Args:
        agent: the name of a reference agent, ``"module:factory"``, or a factory.
        groups: a task group or several: names of published groups, TOML files of custom groups, or
            :class:`gym_extensions.envs.TaskGroup` objects.
        protocols: ``"sequential"``, ``"single"`` or ``"joint"``, or several.
        budget: ``"smoke"``, ``"100k"``, ``"1M"`` or ``"paper"``: training steps per task.
        runs: a training seed from 0 to 999, or several.
        out: the submission's folder.
        jobs: number of worker processes with one thread each; the factory must pickle. 0 trains in this
            process with its number of threads.
        num_envs: number of training environments; the budget's if None.
        on_event: called with an event after every training batch and every evaluated task.
        on_plan: called once, before training, with the number of evaluations of each job by its title.

    Returns:
        The paths of the requested logs, including those that were complete before.

    Raises:
        BenchError: an unknown name, a number out of range, a folder that cannot become the submission or
            belongs to another one, an agent without a required method, actions of a wrong shape, or an
            exceeded budget.

    Example:
        >>> logs = train("random", "hopper-gravity", "single", "smoke", 0, out="mine")  # doctest: +SKIP
    """
    request = parse_request(groups, protocols, budget, runs, num_envs)
    path = Path(out)
    settings = Settings(algorithms.name_of(agent), request.budget.name, num_envs)
    settings = _checked(algorithms.factory(agent), settings, path, request)
    plan = {
        (group, protocol): missing_jobs(path, group, protocol, request.runs)
        for group, protocol in request.logs()
    }
    pending = [job for missing in plan.values() for job in missing]
    if pending:
        folder.prepare(path)
    on_plan({job.title: job.num_evaluations(request.budget) for job in pending})
    finished: dict[TrainingJob, list[FinishedStage]] = {}
    runnables = [PendingJob(job, agent, settings, path) for job in pending]
    for index, stages in run_all(runnables, jobs, on_event):
        job = pending[index]
        finished[job] = stages
        siblings = plan[job.group, job.protocol]
        if all(sibling in finished for sibling in siblings):
            results = {sibling: finished.pop(sibling) for sibling in siblings}
            write_log(path, job.group, job.protocol, results, settings)
    return [path / group.name / f"{protocol}.csv" for group, protocol in plan]


def _checked(make: Factory, settings: Settings, out: Path, request: Request) -> Settings:
    """The settings with what the agent asks to observe.

    Raises ``BenchError`` before training for anything that cannot become a submission after it.
    """
    folder.validate(out, request.groups)
    path = out / MANIFEST
    existing = manifest.read(path)
    env = make_vec(request.groups[0].tasks[0], 1)
    agent = create_agent(make, (env.single_observation_space, env.single_action_space), settings.agent)
    card = card_of(agent, settings.agent)
    env.close()
    settings = replace(settings, observes=observes_of(agent, settings.agent))
    new = manifest.run_sections(card, settings.budget, settings.num_envs, settings.observes)
    manifest.require_same(path, existing, new)
    return settings
