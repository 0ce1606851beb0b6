"""Runs one job: trains its stages in order, evaluates after each, and records the results."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path

from gym_extensions.atomic import write_bytes
from gym_extensions.baselines import algorithms
from gym_extensions.baselines.agent import Agent, Factory, Observes, VectorEnv
from gym_extensions.baselines.agent_checks import card_of
from gym_extensions.baselines.context import TaskLabel
from gym_extensions.baselines.context_checks import observes_of
from gym_extensions.baselines.training.context_env import TrainingContext
from gym_extensions.baselines.training.evaluation import evaluate
from gym_extensions.baselines.training.events import Event, Listener
from gym_extensions.baselines.training.jobs import Settings, Stage, TrainingJob
from gym_extensions.baselines.training.policies import policy_of, require_agreement, store_policy
from gym_extensions.baselines.training.progress import FinishedStage, Progress
from gym_extensions.baselines.training.recorder import Recorder
from gym_extensions.baselines.training.seeding import training_seed
from gym_extensions.catalog.budgets import budget
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, evaluation_seed
from gym_extensions.catalog.task import Task
from gym_extensions.envs import make_vec
from gym_extensions.envs.fingerprint import fingerprint_of
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.episodes import CurvePoint, Episode
from gym_extensions.rollouts.layout import PROGRESS, trace_name
from gym_extensions.rollouts.policies import Policy
from gym_extensions.rollouts.traces import trace_bytes


@dataclass(frozen=True)
class PendingJob:
    """A job with everything that a worker process needs to run it."""

    job: TrainingJob
    agent: str | Factory
    settings: Settings
    out: Path

    def run(self, listen: Listener) -> list[FinishedStage]:
        """Runs the job; see :func:`run_job`."""
        return run_job(self.job, algorithms.factory(self.agent), self.settings, self.out, listen)


class Evaluator:
    """The evaluation environments of every task, created on first use and reused in every stage."""

    def __init__(self, job: TrainingJob, settings: Settings, out: Path) -> None:
        self._job, self._traces = job, traces_folder(out, job.group.name)
        self._task_is_observed = settings.observes.task_in_evaluation
        self._envs: dict[str, VectorEnv] = {}

    def envs(self, task: Task) -> VectorEnv:
        """One environment of the task per evaluation episode."""
        if task.id not in self._envs:
            self._envs[task.id] = make_vec(task, EVALUATION_EPISODES)
        return self._envs[task.id]

    def evaluate(self, agent: Agent, stage: int, task: Task, policy: Policy | None) -> list[Episode]:
        """Evaluates the agent on a task, stores the traces, and compares them with the policy."""
        job, rows = self._job, []
        seeds = [evaluation_seed(job.group.id, task.id, episode) for episode in range(EVALUATION_EPISODES)]
        label = TaskLabel(task.id, job.group.task_ids.index(task.id)) if self._task_is_observed else None
        rollouts = evaluate(agent, self.envs(task), seeds, task.body.segments.steps, label)
        for episode, (seed, rollout) in enumerate(zip(seeds, rollouts, strict=True)):
            if rollout.trace is not None:
                name = trace_name(job.protocol, job.run, stage, task.name, episode)
                write_bytes(self._traces / name, trace_bytes(rollout.trace))
            result = (rollout.length, rollout.return_, rollout.terminated)
            rows.append(Episode(job.run, stage, task.id, episode, seed, *result, fingerprint_of(task)))
        if policy is not None:
            actions = [rollout.trace.actions[0] for rollout in rollouts if rollout.trace is not None]
            require_agreement(policy, self.envs(task), seeds, actions, job.group.tasks.index(task))
        return rows

    def close(self) -> None:
        """Closes every environment."""
        for env in self._envs.values():
            env.close()


def traces_folder(out: Path, group_name: str) -> Path:
    """The folder with the traces of all episodes, from which the audit sample is taken."""
    return out / PROGRESS / group_name / "traces"


def run_job(
    job: TrainingJob, make: Factory, settings: Settings, out: Path, listen: Listener
) -> list[FinishedStage]:
    """Runs every stage of the job that an earlier attempt did not finish.

    Returns:
        The records of all stages, those of earlier attempts included.
    """
    stages = job.stages(budget(settings.budget))
    progress = Progress.of(out, job)
    progress.begin(
        asdict(settings) | {"group": job.group.id, "tasks": list(job.group.task_ids), "stages": len(stages)}
    )
    done = progress.finished()
    if len(done) == len(stages):
        return done
    evaluator = Evaluator(job, settings, out)
    env = evaluator.envs(stages[0].evaluated[0])
    seed = training_seed(job.run, job.group.id, "agent")
    agent = make(env.single_observation_space, env.single_action_space, seed)
    _require_same(observes_of(agent, settings.agent), settings, job)
    first_parameters = done[0].parameters[0] if done else card_of(agent, settings.agent).parameters
    if done and not progress.resume(agent, done):
        done = []
    for stage in stages[len(done) :]:
        curves = _train(job, stage, agent, settings, listen) if stage.steps else []
        episodes, policy = [], policy_of(agent)
        for task in stage.evaluated:
            rows = evaluator.evaluate(agent, stage.number, task, policy)
            mean_return = sum(row.return_ for row in rows) / len(rows)
            listen(Event(job.title, stage.number, stage.steps, task.id, mean_return))
            episodes += rows
        if policy is not None:
            store_policy(out, job, stage.number, policy)
        card = card_of(agent, settings.agent)
        record = FinishedStage(stage.number, episodes, curves, card, (first_parameters, card.parameters))
        progress.finish(record, agent, last=stage is stages[-1])
        done.append(record)
    evaluator.close()
    return done


def _require_same(observes: Observes, settings: Settings, job: TrainingJob) -> None:
    if observes != settings.observes:
        message = f"The agent of {job.title} asks for {observes}, another agent for {settings.observes}."
        hint = "Give all agents of a factory the same attribute observes."
        raise BenchError("bad-agent", message, settings.agent, hint)


def _train(
    job: TrainingJob, stage: Stage, agent: Agent, settings: Settings, listen: Listener
) -> list[CurvePoint]:
    ids = [task.id for task in stage.trained]
    env = make_vec(stage.trained, settings.num_envs_for(len(ids)))
    recorder = Recorder(
        env,
        ids,
        steps=stage.steps,
        batch_steps=budget(settings.budget).batch_steps,
        seed=training_seed(job.run, job.group.id, *ids, "training"),
        report=lambda taken: listen(Event(job.title, stage.number, taken)),
        context=TrainingContext(settings.observes, job.group.task_ids, stage.number),
    )
    agent.learn(recorder, stage.steps)
    recorder.flush()
    env.close()
    return [
        CurvePoint(job.protocol, job.run, point.task, point.step, point.return_) for point in recorder.points
    ]
