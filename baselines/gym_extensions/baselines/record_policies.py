"""Records policies that were trained elsewhere: evaluates them and writes the run that the loop writes."""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from statistics import fmean
from typing import Any, NoReturn

import numpy as np

from gym_extensions.baselines import agent_spec, generators, submission
from gym_extensions.baselines.agent import (
    EXCESS,
    Array,
    Card,
    Context,
    VectorEnv,
    action_function,
    observes_of,
)
from gym_extensions.baselines.training import runner
from gym_extensions.baselines.training.checkpoints import FinishedStage, JobFolder, usage_since
from gym_extensions.baselines.training.jobs import Settings, Stage, TrainingJob, jobs_of, parse_request
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import IN_ORDER, Budget
from gym_extensions.catalog.tasks import Task
from gym_extensions.envs.fingerprinting import require_published_engine
from gym_extensions.errors import BenchError, did_you_mean
from gym_extensions.submissions import layout, log, manifest
from gym_extensions.submissions.policies import files, mlp, onnx
from gym_extensions.submissions.run import Curve, Memory

ClaimedCurves = Mapping[str, Sequence[tuple[int, float]]]
"""By task name or id: pairs of training steps in the stage and mean return of the episodes since the last."""


def task_named(name: str, tasks: Sequence[Task]) -> Task:
    """The task with that name or id. Raises ``BenchError`` if there is none."""
    for task in tasks:
        if name in (task.name, task.id):
            return task
    hint = did_you_mean(str(name), [task.name for task in tasks])
    raise BenchError("unknown-task", f"{name!r} is not a task of this group or stage.", "task", hint)


def claimed_curves(stage: Stage, curves: ClaimedCurves) -> list[Curve]:
    """The training curves of a stage, in training order.

    Raises ``BenchError`` if a task is not trained in the stage, steps do not increase or exceed the budget,
    a return is not finite, or the points are not pairs of numbers.
    """
    by_task = {task_named(name, stage.trained): points for name, points in curves.items()}
    found = []
    for task in stage.trained:
        points, message = by_task.get(task, ()), ""
        try:
            steps, returns = [int(step) for step, _ in points], [float(value) for _, value in points]
        except (OverflowError, TypeError, ValueError):
            steps, returns, message = [], [], "Its points are not pairs of a training step and a return."
        if any(later <= earlier for earlier, later in pairwise([0, *steps])):
            message = "The training steps do not increase from above 0."
        elif steps and steps[-1] > stage.steps * (1 + EXCESS):
            message = f"It ends at step {steps[-1]}; the budget is {stage.steps}."
        elif not all(map(math.isfinite, returns)):
            message = "A return is not finite."
        if message:
            hint = "Give pairs of training step and mean return, with increasing steps up to the budget."
            raise BenchError("bad-curve", message, f"curves[{task.name!r}]", hint)
        if steps:
            found.append(Curve(stage=stage.number, task=task.id, steps=steps, returns=returns))
    return found


def parse_stage(
    group: TaskGroup, protocol: str, run: int, budget: Budget, *, stage: int | None, task: str | None
) -> tuple[TrainingJob, Stage]:
    """The job and the stage that the arguments of ``record`` name.

    Raises ``BenchError`` if the stage is missing, out of range or not an integer, the task is missing or
    unknown, or an argument belongs to another protocol.
    """
    if (task is None) == (protocol == "single"):
        message = "The protocol single needs a task." if task is None else f"Unexpected task {task!r}."
        raise BenchError("bad-task", message, "task", "Name the trained task in the protocol single alone.")
    index = None if task is None else group.tasks.index(task_named(task, group.tasks))
    job = TrainingJob(group, protocol, run, index)
    stages = job.stages(budget)
    if protocol not in IN_ORDER and stage is None:
        return job, stages[0]
    for each in stages:
        if each.number == stage and not isinstance(stage, bool | float):
            return job, each
    missing = f"The protocol {protocol} needs a stage."
    message = missing if stage is None else f"Stage {stage!r} is out of range."
    hint = f"Use the number of tasks that the policy was trained on, 0 to {len(group.tasks)}."
    raise BenchError("bad-stage", message, "stage", hint if protocol in IN_ORDER else "Leave stage out.")


POLICY_ERRORS = (ArithmeticError, AttributeError, LookupError, RuntimeError, TypeError, ValueError)
"""What a policy raises for observations of another shape or type."""
SIGNATURE = "Use a function from observations (n, …) to actions (n, …), or an object with act or predict."
Policy = mlp.Policy | onnx.OnnxPolicy | Callable[[Array], Array] | Any
"""A policy as :func:`gym_extensions.baselines.record` takes it; or an object with ``act`` or ``predict``."""


class PolicyAgent:
    """Acts with a policy.

    Raises ``BenchError`` if ``policy`` is neither a function nor an object with ``act`` or ``predict``.
    """

    def __init__(self, policy: Any, card: Card, observes: manifest.Observes | None = None) -> None:
        self._policy, self._card = policy, card
        per_task = isinstance(policy, files.AnyPolicy) and policy.num_tasks > 0
        by_default: manifest.Observes = getattr(policy, "observes", manifest.Observes(per_task, per_task))
        self.observes = by_default if observes is None else observes
        if not (callable(policy) or hasattr(policy, "act") or hasattr(policy, "predict")):
            message = f"A value of type {type(policy).__name__} is not a policy."
            raise BenchError("bad-policy", message, "policy", SIGNATURE)

    def begin(self, seed: int) -> None:
        """Begins the evaluation of a task: forgets the state of a recurrent policy, seeds its sampling."""
        self._rng, self._state = np.random.default_rng(seed), None
        if isinstance(self._policy, files.AnyPolicy):
            self._policy.reset()

    def act(self, observations: Array, context: Context) -> Array:
        """The policy's actions. Raises ``BenchError`` if the policy fails."""
        policy = self._policy
        try:
            if isinstance(policy, files.AnyPolicy):
                task = context.task if self.observes.task_in_evaluation and policy.num_tasks else 0
                return policy.act(observations, self._rng, task)
            if hasattr(policy, "act"):
                return action_function(policy)(observations, context)
            if not hasattr(policy, "predict"):
                return policy(observations)
            if normalizer := getattr(policy, "get_vec_normalize_env", lambda: None)():  # a model of SB3
                observations = normalizer.normalize_obs(observations)
            best, starts = self._card.evaluation == "deterministic", context.episode_starts
            actions, self._state = policy.predict(
                observations, state=self._state, episode_start=starts, deterministic=best
            )
            return np.asarray(actions)
        except POLICY_ERRORS as error:
            reason = f"{type(error).__name__}: {error}".rstrip(".")
            shape = f"shape {observations.shape} and dtype {observations.dtype}"
            message = f"The policy failed on observations of {shape}: {reason}."
            raise BenchError("bad-policy", message, "policy", SIGNATURE) from error

    def learn(self, env: VectorEnv, steps: int) -> NoReturn:
        """Recorded policies are already trained."""
        raise NotImplementedError

    def card(self) -> Card:
        return self._card

    def policy(self) -> files.AnyPolicy | None:
        return self._policy if isinstance(self._policy, files.AnyPolicy) else None


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
    observes: manifest.Observes | None = None,
    curves: ClaimedCurves | None = None,
) -> dict[str, float]:
    """Evaluates a policy that was trained elsewhere and records it as a stage of a submission.

    The policy is evaluated as :func:`train` evaluates agents. A run is written to the submission when all of
    its stages or tasks (``single``) have been recorded, in any order, by one process or several; until then
    they are in the folder ``.progress``, where recording a stage again replaces it. The run's document says
    that the training steps were not counted.

    Args:
        policy: a function from observations (n, …) to actions (n, …), an object with such a method ``act``,
            a :class:`gym_extensions.policies.Policy` or an ``OnnxPolicy``, which the submission contains, or
            an object with a method ``predict`` as in Stable-Baselines3. Actions are clipped to their space.
        group: a task group: the name of a published group, the TOML file of a custom group, or a
            :class:`gym_extensions.envs.TaskGroup`.
        protocol: ``"sequential"``, ``"single"`` or another one (docs/concepts.md).
        run: the number of the run, 0 to 99.
        stage: sequential, descending, balanced: the number of tasks that the policy has been trained on, 0
            to T. 0 is the policy before training.
        task: single: the name or id of the task that the policy was trained on.
        out: the submission's folder.
        budget: ``"smoke"``, ``"100k"``, ``"300k"``, ``"1M"`` or ``"paper"``: the training steps per task.
        card: what the manifest says about the algorithm. The algorithm, the hyperparameters and
            ``evaluation`` are the same in every call.
        observes: what the policies of all stages observe besides observations. By default the attribute
            ``observes`` of the policy; a ``Policy`` observes the task if it has arrays per task. Pass it if
            the policies of the first stages have none.
        curves: the stage's training curves by task name, each as pairs of training step and mean return;
            optional.

    Returns:
        The mean return of every evaluated task by its id.

    Raises:
        BenchError: an unknown name, a stage or run out of range, a policy that fails, returns actions of
            a wrong shape or may not be in a submission, a run of which only some stages have a policy that
            can be stored (record the others again), a folder of another submission, a run that is finished,
            or another process that records the same stage.

    Example:
        >>> record(policy, "hopper-gravity", "single", run=0, task="Hopper", out="mine", budget="100k",
        ...        card=Card("SAC", evaluation="deterministic"))  # doctest: +SKIP
    """
    request = parse_request([group], protocol, budget, [run])
    if len(request.logs()) > 1:
        hint = "Name one group and one protocol."
        raise BenchError("bad-groups", "A policy is recorded in one group and protocol.", "record", hint)
    ((task_group, _),) = request.logs()
    job, recorded = parse_stage(task_group, protocol, request.runs[0], request.budget, stage=stage, task=task)
    trained = claimed_curves(recorded, curves or {})
    path = Path(out)
    agent = PolicyAgent(policy, card, observes)
    observed, card = observes_of(agent, "policy"), agent_spec.checked_card(agent, "card")
    spec = agent_spec.AgentSpec(card.algorithm, lambda *_: agent, card, observed)
    settings = Settings(spec, request.budget, steps_counted=False)
    if (stored := agent.policy()) is not None:
        keys = files.policy_keys(protocol, task_group)
        agent_spec.require_submittable(stored, card, observed, task_group, keys)
    submission.validate(path, [task_group])
    require_published_engine(task_group.tasks)
    submission.require_same(path / layout.MANIFEST, submission.manifest_tables(settings))
    if (path / layout.run_file(task_group.name, protocol, job.run, layout.LOG)).exists():
        message = f"Run {job.run} is already in {task_group.name}/{protocol}."
        hint = "Choose another run or another out, or delete the files of the run."
        raise BenchError("run-recorded", message, str(path), hint)
    submission.prepare(path)
    with submission.lock_runs(path, [f"{job.title} stage {recorded.number}"]):
        started, folder = time.process_time(), JobFolder(path, job)
        folder.begin(settings)
        episodes = _evaluate(agent, job, recorded, folder)
        memory = Memory(
            stored_steps=card.stored_steps, parameters_first=card.parameters, parameters_last=card.parameters
        )
        used = usage_since(started, recorded.steps)
        folder.finish(FinishedStage(recorded.number, episodes, trained, memory, used), agent, last=True)
    _write_if_complete(path, job, settings)
    return {
        each.id: fmean(episode.return_ for episode in episodes if episode.task == each.id)
        for each in recorded.evaluated
    }


def _evaluate(agent: PolicyAgent, job: TrainingJob, stage: Stage, folder: JobFolder) -> list[log.Episode]:
    evaluator, policy = runner.Evaluator(job.group, agent.observes.task_in_evaluation), agent.policy()
    episodes = []
    try:
        for task in stage.evaluated:
            agent.begin(generators.training_seed(job.run, job.group.id, f"policy {stage.number}", task.id))
            episodes += evaluator.evaluate(agent, stage.number, task, policy)
        folder.store_policy(stage.number, policy)
    finally:
        evaluator.close()
    return episodes


def _write_if_complete(out: Path, job: TrainingJob, settings: Settings) -> None:
    """Writes the run to the submission if all of its stages and tasks are recorded."""
    with submission.lock_runs(out, [job.run_title], seconds=300):
        jobs = jobs_of(job.group, job.protocol, [job.run])
        records = {item: JobFolder(out, item).finished() for item in jobs}
        count = len(job.stages(settings.budget))
        if all(len(finished) == count for finished in records.values()):
            words = f"…, {job.group.name!r}, {job.protocol!r}, run={job.run}"
            command = f"gym_extensions.baselines.record({words})"
            submission.write_run_files(out, records, settings, command=command)
