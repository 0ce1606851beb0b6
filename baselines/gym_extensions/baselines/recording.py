"""Records policies that were trained elsewhere: evaluates them and writes the run that the loop writes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, replace
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType
from typing import Any, NoReturn, Protocol, runtime_checkable

import numpy as np

from gym_extensions.baselines import entry
from gym_extensions.baselines.agent import Array, Card, Context, Observes, VectorEnv
from gym_extensions.baselines.agent_checks import action_function, card_of, observes_of
from gym_extensions.baselines.training.checkpoints import FinishedStage, Progress
from gym_extensions.baselines.training.evaluation import Evaluator
from gym_extensions.baselines.training.jobs import Settings, Stage, TrainingJob, jobs_of, training_seed
from gym_extensions.baselines.training.recorder import EXCESS
from gym_extensions.baselines.training.request import parse_request
from gym_extensions.baselines.training.usage import Meter
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import budget as budget_named
from gym_extensions.catalog.tasks import Task
from gym_extensions.envs.fingerprint import require_published_engine
from gym_extensions.errors import BenchError, did_you_mean
from gym_extensions.rollouts.layout import LOG, MANIFEST, run_file
from gym_extensions.rollouts.manifest import CLAIMED
from gym_extensions.rollouts.onnx_policy import OnnxPolicy
from gym_extensions.rollouts.policy import Policy as PlainPolicy
from gym_extensions.rollouts.run_policies import AnyPolicy
from gym_extensions.rollouts.tables import CurvePoint, Episode, read_log

WRITE_SECONDS = 300.0
"""How long a process waits for another one that writes the run."""
ClaimedCurves = Mapping[str, Sequence[tuple[int, float]]]
"""By task name or id: pairs of training steps in the stage and mean return of the episodes since the last."""


def task_named(name: str, tasks: Sequence[Task]) -> Task:
    """The task with that name or id. Raises ``BenchError`` if there is none."""
    for task in tasks:
        if name in (task.name, task.id):
            return task
    hint = did_you_mean(str(name), [task.name for task in tasks])
    raise BenchError("unknown-task", f"{name!r} is not a task of this group or stage.", "task", hint)


def curve_points(job: TrainingJob, stage: Stage, curves: ClaimedCurves) -> list[CurvePoint]:
    """The points of a stage's training curves.

    Raises:
        BenchError: a task is not trained in the stage, steps do not increase or exceed the budget, or a
            return is not finite.
    """
    points = []
    for name, values in curves.items():
        task = task_named(name, stage.trained)
        steps = [int(step) for step, _ in values]
        if any(later <= earlier for earlier, later in pairwise([0, *steps])):
            raise _bad_curve(name, "The training steps do not increase.", "Start above 0.")
        if steps and steps[-1] > stage.steps * (1 + EXCESS):
            message = f"It ends at step {steps[-1]}; the budget is {stage.steps}."
            raise _bad_curve(name, message, "Choose the budget that the policy was trained with.")
        if not all(math.isfinite(value) for _, value in values):
            raise _bad_curve(name, "A return is not finite.", "Leave such points out.")
        points += [
            CurvePoint(job.protocol, job.run, task.id, int(step), float(value)) for step, value in values
        ]
    return points


def _bad_curve(name: str, message: str, hint: str) -> BenchError:
    return BenchError("bad-curve", message, f"curves[{name!r}]", hint)


def parse_stage(
    group: TaskGroup, protocol: str, run: int, stage: int | None, task: str | None
) -> tuple[TrainingJob, int]:
    """The job and the number of the stage that the arguments of ``record`` name.

    Raises:
        BenchError: the stage is missing, out of range or not an integer, the task is missing or unknown, or
            an argument belongs to another protocol.
    """
    if protocol == "sequential":
        _require_no_task(task, "Each stage is evaluated on every task; leave task out.")
        return TrainingJob(group, protocol, run), _sequential_stage(group, stage)
    if stage not in (None, 1):
        message = f"Stage {stage!r} is out of range: the protocol {protocol} has stage 1 only."
        raise BenchError("bad-stage", message, "stage", "Leave stage out.")
    if protocol in ("joint", "cumulative"):
        _require_no_task(task, f"The protocol {protocol} has one policy; leave task out.")
        return TrainingJob(group, protocol, run), 1
    if task is None:
        hint = "Name the task that the policy was trained on."
        raise BenchError("bad-task", "The protocol single needs a task.", "task", hint)
    return TrainingJob(group, protocol, run, group.tasks.index(task_named(task, group.tasks))), 1


def _sequential_stage(group: TaskGroup, stage: object) -> int:
    last = len(group.tasks)
    if isinstance(stage, bool) or not isinstance(stage, int) or not 0 <= stage <= last:
        message = (
            "The protocol sequential needs a stage." if stage is None else f"Stage {stage!r} is out of range."
        )
        hint = f"Use the number of tasks of {group.name} that the policy was trained on, 0 to {last}."
        raise BenchError("bad-stage", message, "stage", hint)
    return stage


def _require_no_task(task: str | None, hint: str) -> None:
    if task is not None:
        raise BenchError("bad-task", f"Unexpected task {task!r}.", "task", hint)


POLICY_ERRORS = (ArithmeticError, AttributeError, LookupError, RuntimeError, TypeError, ValueError)
"""What a policy raises for observations of another shape or type."""
SIGNATURE = "Use a function from observations (n, …) to actions (n, …)"


@runtime_checkable
class Acts(Protocol):
    """An agent."""

    def act(self, observations: Array, /) -> Array:
        """Actions (n, …) for observations (n, …)."""


@runtime_checkable
class Predicts(Protocol):
    """An algorithm or policy of Stable-Baselines3."""

    def predict(
        self, observation: Array, state: Any, episode_start: Array, deterministic: bool
    ) -> tuple[Array, Any]:
        """Actions (n, …) and the state of a recurrent policy."""


Policy = PlainPolicy | OnnxPolicy | Acts | Predicts | Callable[[Array], Array]
"""A policy as :func:`gym_extensions.baselines.record` takes it."""


class PolicyAgent:
    """Acts with a policy.

    Args:
        policy: an object with ``act`` or ``predict``, or a function.
        card: the description for the manifest.
        observes: what the policy observes besides observations. None: its attribute ``observes``, or else
            the task if it has arrays per task.

    Raises:
        BenchError: ``policy`` is none of these.
    """

    def __init__(self, policy: Policy, card: Card, observes: Observes | None = None) -> None:
        self._policy, self._card = policy, card
        per_task = isinstance(policy, AnyPolicy) and policy.num_tasks > 0
        by_default: Observes = getattr(policy, "observes", Observes(per_task, per_task))
        self.observes = by_default if observes is None else observes
        self.begin(0)

    def begin(self, seed: int) -> None:
        """Begins the evaluation of a task: forgets the state of a recurrent policy.

        Args:
            seed: of the generator that a policy of :mod:`gym_extensions.rollouts` samples with.
        """
        reads_task = self.observes.task_in_evaluation
        deterministic = self._card.evaluation == "deterministic"
        self._act = _action_function(self._policy, deterministic, reads_task, seed)

    def act(self, observations: Array, context: Context) -> Array:
        """The policy's actions. Raises ``BenchError`` if the policy fails."""
        try:
            return self._act(observations, context)
        except POLICY_ERRORS as error:
            reason = f"{type(error).__name__}: {error}".rstrip(".")
            shape = f"shape {observations.shape} and dtype {observations.dtype}"
            message = f"The policy failed on observations of {shape}: {reason}."
            raise BenchError("bad-policy", message, "policy", f"{SIGNATURE}.") from error

    def learn(self, env: VectorEnv, steps: int) -> NoReturn:
        """Recorded policies are already trained."""
        raise NotImplementedError

    def card(self) -> Card:
        """The description for the manifest."""
        return self._card

    def policy(self) -> AnyPolicy | None:
        """The policy as plain arrays or as a network; None for any other policy."""
        return self._policy if isinstance(self._policy, AnyPolicy) else None


def _action_function(
    policy: object, deterministic: bool, reads_task: bool, seed: int
) -> Callable[[Array, Context], Array]:
    if isinstance(policy, AnyPolicy):
        stored, rng = policy, np.random.default_rng(seed)
        stored.reset()
        return lambda observations, context: stored.act(
            observations, rng, context.task if reads_task and stored.num_tasks else 0
        )
    if isinstance(policy, Acts):
        return action_function(policy)  # type: ignore[arg-type]
    if isinstance(policy, Predicts):
        return _Prediction(policy, deterministic)
    if callable(policy):
        function = policy
        return lambda observations, _: function(observations)
    hint = f"{SIGNATURE}, or an object with a method act or predict."
    raise BenchError(
        "bad-policy", f"A value of type {type(policy).__name__} is not a policy.", "policy", hint
    )


class _Prediction:
    """The predictions of a Stable-Baselines3 model, with the state of a recurrent policy between steps."""

    def __init__(self, model: Predicts, deterministic: bool) -> None:
        self._model, self._deterministic = model, deterministic
        self._state: Any = None

    def __call__(self, observations: Array, context: Context) -> Array:
        actions, self._state = self._model.predict(
            observations,
            state=self._state,
            episode_start=context.episode_starts,
            deterministic=self._deterministic,
        )
        return actions


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
            a :class:`gym_extensions.rollouts.policy.Policy` or
            :class:`gym_extensions.rollouts.onnx_policy.OnnxPolicy`,
            which the submission then contains, or an object with a method ``predict`` as in
            Stable-Baselines3. Actions are clipped to the action space.
        group: a task group: the name of a published group, the TOML file of a custom group, or a
            :class:`gym_extensions.envs.TaskGroup`.
        protocol: ``"sequential"``, ``"single"``, ``"joint"`` or ``"cumulative"``.
        run: the training seed, 0 to 999.
        stage: sequential: the number of tasks that the policy has been trained on, 0 to T. 0 is the policy
            before training.
        task: single: the name or id of the task that the policy was trained on.
        out: the submission's folder.
        budget: ``"smoke"``, ``"100k"``, ``"300k"``, ``"1M"`` or ``"paper"``: the training steps per task.
        card: what the manifest says about the algorithm. The algorithm, the hyperparameters and
            ``evaluation`` are the same in every call.
        observes: what the policies of all stages observe besides observations. By default the attribute
            ``observes`` of the policy; a :class:`gym_extensions.rollouts.policy.Policy` observes the task
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
    tables = entry.manifest_tables(card, settings)
    entry.validate(path, [task_group])
    require_published_engine(task_group.tasks)
    entry.require_same(path / MANIFEST, entry.read_manifest(path / MANIFEST), tables)
    if existing := _existing(path, job, number, skip_recorded):
        if Progress.of(path, job).finished():
            _write_if_complete(path, job, settings)  # an earlier call may have failed to
        return existing
    entry.prepare(path)
    with entry.lock_runs(path, [f"{job.title} stage {number}"]):
        meter, progress = Meter(), Progress.of(path, job)
        progress.begin(_identity(job, settings, tables))
        episodes = _evaluate(agent, job, recorded, settings, progress)
        usage, memory = meter.usage(recorded.steps), (card.parameters, card.parameters)
        progress.finish(FinishedStage(number, episodes, points, card, memory, usage), agent, last=True)
    _write_if_complete(path, job, settings)
    return _mean_returns([(episode.task, episode.return_) for episode in episodes])


def _existing(out: Path, job: TrainingJob, stage: int, skip: bool) -> dict[str, float]:
    """The mean returns of a stage that is not recorded again, empty if it is to be recorded."""
    log = out / run_file(job.group.name, job.protocol, job.run, LOG)
    if log.exists():
        if not skip:
            message = f"Run {job.run} is already in {job.group.name}/{job.protocol}."
            hint = "Pass skip_recorded=True to skip it, choose another run, or choose another out."
            raise BenchError("run-recorded", message, str(out), hint)
        tasks = job.group.task_ids if job.task is None else (job.group.task_ids[job.task],)
        frame = read_log(log)
        frame = frame[(frame["stage"] == stage) & frame["task"].isin(tasks)]
        return _mean_returns(zip(frame["task"], frame["return"].tolist(), strict=True))
    finished = Progress.of(out, job).finished() if skip else []
    episodes = [episode for record in finished if record.stage == stage for episode in record.episodes]
    return _mean_returns([(episode.task, episode.return_) for episode in episodes])


def _identity(job: TrainingJob, settings: Settings, tables: Mapping[str, Any]) -> dict[str, object]:
    """What is the same in every call for one job."""
    return asdict(settings) | {
        "group": job.group.id,
        "tasks": list(job.group.task_ids),
        "stages": len(job.stages(budget_named(settings.budget))),
        "protocol": tables["protocol"],
        "hyperparameters": tables["hyperparameters"],
    }


def _evaluate(
    agent: PolicyAgent, job: TrainingJob, stage: Stage, settings: Settings, progress: Progress
) -> list[Episode]:
    evaluator, policy = Evaluator(job.group, settings.observes.task_in_evaluation), agent.policy()
    episodes = []
    try:
        for task in stage.evaluated:
            agent.begin(training_seed(job.run, job.group.id, f"policy {stage.number}", task.id))
            episodes += evaluator.evaluate(agent, stage.number, task, policy)
        progress.store_policy(stage.number, job.task_name, policy)
    finally:
        evaluator.close()
    return episodes


def _write_if_complete(out: Path, job: TrainingJob, settings: Settings) -> None:
    """Writes the run to the submission if all of its stages and tasks are recorded."""
    with entry.lock_runs(out, [job.run_title], seconds=WRITE_SECONDS):
        jobs = jobs_of(job.group, job.protocol, [job.run])
        records = {item: Progress.of(out, item).finished() for item in jobs}
        stages = job.stages(budget_named(settings.budget))
        if all(len(finished) == len(stages) for finished in records.values()):
            complete = {item: _with_first_parameters(finished) for item, finished in records.items()}
            command = (
                f"gym_extensions.baselines.record(…, {job.group.name!r}, {job.protocol!r}, run={job.run})"
            )
            entry.write_run_files(out, complete, settings, command=command)


def _with_first_parameters(records: list[FinishedStage]) -> list[FinishedStage]:
    first = records[0].card.parameters
    return [replace(record, parameters=(first, record.card.parameters)) for record in records]


def _mean_returns(returns: Iterable[tuple[str, float]]) -> dict[str, float]:
    """The mean return of each task, from pairs of task and return."""
    by_task: dict[str, list[float]] = {}
    for task, value in returns:
        by_task.setdefault(task, []).append(value)
    return {task: sum(values) / len(values) for task, values in by_task.items()}
