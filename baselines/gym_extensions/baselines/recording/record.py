"""Records policies that were trained elsewhere, one call per stage or task."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from types import MappingProxyType

from gym_extensions.baselines.agent import Card, Observes
from gym_extensions.baselines.agent_checks import card_of
from gym_extensions.baselines.context_checks import observes_of
from gym_extensions.baselines.recording.curves import ClaimedCurves, curve_points
from gym_extensions.baselines.recording.policy_agent import Policy, PolicyAgent
from gym_extensions.baselines.recording.stage import parse_stage
from gym_extensions.baselines.submission import folder, manifest
from gym_extensions.baselines.submission.lock import WRITE_SECONDS, lock
from gym_extensions.baselines.submission.rows import read_episodes
from gym_extensions.baselines.submission.writer import require_extensible, write_log
from gym_extensions.baselines.training.evaluator import Evaluator
from gym_extensions.baselines.training.jobs import Settings, Stage, TrainingJob, jobs_of
from gym_extensions.baselines.training.policies import store_policy
from gym_extensions.baselines.training.progress import FinishedStage, Progress
from gym_extensions.baselines.training.request import parse_request
from gym_extensions.baselines.training.seeding import training_seed
from gym_extensions.catalog.budgets import budget as budget_named
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.errors import BenchError
from gym_extensions.installed import blas_kernels
from gym_extensions.rollouts.episodes import Episode
from gym_extensions.rollouts.layout import MANIFEST
from gym_extensions.rollouts.manifest import CLAIMED

NO_CURVES: ClaimedCurves = MappingProxyType({})


def record(
    policy: Policy,
    group: str | Path | TaskGroup,
    protocol: str,
    *,
    run: int,
    stage: int | None = None,
    task: str | None = None,
    out: str | Path,
    budget: str,
    card: Card,
    observes: Observes | None = None,
    curves: ClaimedCurves = NO_CURVES,
    skip_recorded: bool = False,
) -> dict[str, float]:
    """Evaluates a policy that was trained elsewhere and records it as a stage of a submission.

    The policy is evaluated as :func:`train` evaluates agents. A run is written to the submission when all of
    its stages (``sequential``) or tasks (``single``) have been recorded, in any order, by one process or
    several; until then they are in the folder ``.progress``. The manifest says that the training steps are
    claimed, not recorded.

    Args:
        policy: a function from observations (n, …) to actions (n, …), an object with such a method ``act``,
            a :class:`gym_extensions.rollouts.policies.Policy`,
            which the submission then contains, or an object with a method ``predict`` as in
            Stable-Baselines3. Actions are clipped to the action space.
        group: a task group: the name of a published group, the TOML file of a custom group, or a
            :class:`gym_extensions.envs.TaskGroup`.
        protocol: ``"sequential"``, ``"single"`` or ``"joint"``.
        run: the training seed, 0 to 999.
        stage: sequential: the number of tasks that the policy has been trained on, 0 to T. 0 is the policy
            before training.
        task: single: the name or id of the task that the policy was trained on.
        out: the submission's folder.
        budget: ``"smoke"``, ``"100k"``, ``"300k"``, ``"1M"`` or ``"paper"``: the training steps per task.
        card: what the manifest says about the algorithm. The algorithm, the hyperparameters and
            ``evaluation`` are the same in every call.
        observes: what the policies of all stages observe besides observations. By default the attribute
            ``observes`` of the policy; a :class:`gym_extensions.rollouts.policies.Policy` observes the task
            if it has arrays per task. Name it if the first stages have none.
        curves: the stage's training curves by task name, each as pairs of training step and mean return;
            optional.
        skip_recorded: whether to skip what is already recorded. By default a stage of an unfinished run is
            recorded again, and a stage of a finished run is an error.

    Returns:
        The mean return of every evaluated task by its id.

    Raises:
        BenchError: an unknown name, a stage or run out of range, a policy that fails or returns actions of
            a wrong shape, a folder of another submission, a run that is finished, or another process that
            records the same stage.

    Example:
        >>> record(policy, "hopper-gravity", "single", run=0, task="Hopper", out="mine", budget="100k",
        ...        card=Card("SAC", evaluation="deterministic"))  # doctest: +SKIP
    """
    request = parse_request([group], protocol, budget, [run], None)
    ((task_group, _),) = request.logs()
    job, number = parse_stage(task_group, protocol, request.runs[0], stage, task)
    recorded = next(item for item in job.stages(request.budget) if item.number == number)
    points = curve_points(job, recorded, curves)
    path = Path(out)
    agent = PolicyAgent(policy, card, observes)
    observed = observes_of(agent, "policy")
    settings = Settings(card_of(agent, "card").algorithm, request.budget.name, None, observed, CLAIMED)
    _check(path, task_group, card, settings)
    if existing := _existing(path, job, number, skip_recorded):
        if Progress.of(path, job).finished():
            _write_if_complete(path, job, settings)  # an earlier call may have failed to
        return _mean_returns(existing)
    require_extensible(path, task_group, protocol)
    folder.prepare(path)
    with lock(path, f"{job.title} stage {number}"):
        progress = Progress.of(path, job)
        progress.begin(_identity(job, card, settings))
        episodes = _evaluate(agent, job, recorded, settings, path)
        memory = (card.parameters, card.parameters)
        record = FinishedStage(number, episodes, points, card, memory, blas=blas_kernels())
        progress.finish(record, agent, last=True)
    _write_if_complete(path, job, settings)
    return _mean_returns(episodes)


def _check(path: Path, group: TaskGroup, card: Card, settings: Settings) -> None:
    folder.validate(path, [group])
    sections = manifest.run_sections(card, settings.budget, None, settings.observes, steps=settings.steps)
    manifest.require_same(path / MANIFEST, manifest.read(path / MANIFEST), sections)


def _existing(out: Path, job: TrainingJob, stage: int, skip: bool) -> list[Episode]:
    """The rows of a stage that is not recorded again, empty if it is to be recorded."""
    log = out / job.group.name / f"{job.protocol}.csv"
    tasks = job.group.task_ids if job.task is None else (job.group.task_ids[job.task],)
    rows = [
        row for row in read_episodes(log) if (row.run, row.stage) == (job.run, stage) and row.task in tasks
    ]
    if rows and not skip:
        message = f"Run {job.run} is already in {job.group.name}/{job.protocol}.csv."
        hint = "Pass skip_recorded=True to skip it, choose another run, or choose another out."
        raise BenchError("run-recorded", message, str(out), hint)
    if rows or not skip:
        return rows
    finished = Progress.of(out, job).finished()
    return next((record.episodes for record in finished if record.stage == stage), [])


def _identity(job: TrainingJob, card: Card, settings: Settings) -> dict[str, object]:
    """What is the same in every call for one job."""
    sections = manifest.run_sections(card, settings.budget, None, settings.observes, steps=settings.steps)
    return asdict(settings) | {
        "group": job.group.id,
        "tasks": list(job.group.task_ids),
        "stages": len(job.stages(budget_named(settings.budget))),
        "protocol": sections["protocol"],
        "hyperparameters": sections["hyperparameters"],
    }


def _evaluate(
    agent: PolicyAgent, job: TrainingJob, stage: Stage, settings: Settings, out: Path
) -> list[Episode]:
    evaluator, policy = Evaluator(job, settings, out), agent.policy()
    rows = []
    try:
        for task in stage.evaluated:
            agent.begin(training_seed(job.run, job.group.id, f"policy {stage.number}", task.id))
            rows += evaluator.evaluate(agent, stage.number, task, policy)
        store_policy(out, job, stage.number, policy)
    finally:
        evaluator.close()
    return rows


def _write_if_complete(out: Path, job: TrainingJob, settings: Settings) -> None:
    """Writes the run to the submission if all of its stages and tasks are recorded."""
    with lock(out, job.run_title, seconds=WRITE_SECONDS):
        jobs = jobs_of(job.group, job.protocol, [job.run])
        records = {item: Progress.of(out, item).finished() for item in jobs}
        stages = job.stages(budget_named(settings.budget))
        if all(len(finished) == len(stages) for finished in records.values()):
            complete = {item: _with_first_parameters(finished) for item, finished in records.items()}
            write_log(out, job.group, job.protocol, complete, settings)


def _with_first_parameters(records: list[FinishedStage]) -> list[FinishedStage]:
    first = records[0].card.parameters
    return [replace(record, parameters=(first, record.card.parameters)) for record in records]


def _mean_returns(episodes: list[Episode]) -> dict[str, float]:
    returns: Mapping[str, list[float]] = {row.task: [] for row in episodes}
    for row in episodes:
        returns[row.task].append(row.return_)
    return {task: sum(values) / len(values) for task, values in returns.items()}
