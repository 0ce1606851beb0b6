"""Runs one job: trains its stages in order, evaluates after each, and records the results."""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass
from pathlib import Path

from gym_extensions.baselines import algorithms
from gym_extensions.baselines.agent import Agent, Factory, Observes
from gym_extensions.baselines.agent_checks import card_of
from gym_extensions.baselines.context_checks import observes_of
from gym_extensions.baselines.training.context_env import TrainingContext
from gym_extensions.baselines.training.evaluator import Evaluator
from gym_extensions.baselines.training.events import JobFinished, Listener, StageStarted, TaskEvaluated
from gym_extensions.baselines.training.isolation import isolated
from gym_extensions.baselines.training.jobs import Interim, Settings, Stage, TrainingJob
from gym_extensions.baselines.training.monitor import StageMonitor
from gym_extensions.baselines.training.policies import policy_of, store_policy
from gym_extensions.baselines.training.progress import FinishedStage, Progress
from gym_extensions.baselines.training.recorder import Recorder
from gym_extensions.baselines.training.seeding import training_seed
from gym_extensions.catalog.budgets import budget
from gym_extensions.envs import make_vec
from gym_extensions.envs.fingerprint import fingerprint_of
from gym_extensions.errors import BenchError
from gym_extensions.installed import blas_kernels


@dataclass(frozen=True)
class PendingJob:
    """A job with everything that a worker process needs to run it."""

    job: TrainingJob
    agent: str | Factory
    settings: Settings
    out: Path
    interim: Interim | None = None
    num_threads: int = 1

    def run(self, listen: Listener) -> list[FinishedStage]:
        """Runs the job; see :func:`run_job`."""
        make = algorithms.factory(self.agent)
        return run_job(
            *(self.job, make, self.settings, self.out, listen),
            interim=self.interim,
            num_threads=self.num_threads,
        )


def run_job(
    job: TrainingJob,
    make: Factory,
    settings: Settings,
    out: Path,
    listen: Listener,
    *,
    interim: Interim | None = None,
    num_threads: int = 1,
) -> list[FinishedStage]:
    """Runs every stage of the job that an earlier attempt did not finish.

    Args:
        job: the job.
        make: creates its agent.
        settings: how it runs.
        out: the submission's folder.
        listen: receives the events.
        interim: when to evaluate during training; None evaluates at the end of each stage only.
        num_threads: threads that step the training environments. Results do not depend on it.

    Returns:
        The records of all stages, those of earlier attempts included.
    """
    stages = job.stages(budget(settings.budget))
    progress = Progress.of(out, job)
    progress.begin(
        asdict(settings)
        | {"group": job.group.id, "tasks": list(job.group.task_ids), "stages": len(stages)}
        | {"fingerprints": [fingerprint_of(task) for task in job.group.tasks]}
    )
    done = progress.finished()
    if len(done) == len(stages):
        listen(JobFinished(job.title))
        return done
    evaluator = Evaluator(job, settings, out)
    spaces = evaluator.envs(stages[0].evaluated[0])
    seed = training_seed(job.run, job.group.id, "agent")

    def create() -> Agent:
        return make(spaces.single_observation_space, spaces.single_action_space, seed)

    agent = create()
    _require_same(observes_of(agent, settings.agent), settings, job)
    first_parameters = done[0].parameters[0] if done else card_of(agent, settings.agent).parameters
    if done and not progress.resume(agent, done):
        done = []
    for stage in stages[len(done) :]:
        ids = tuple(task.id for task in stage.trained)
        listen(StageStarted(job.title, stage.number, ids, stage.steps))
        job_step = sum(earlier.steps for earlier in stages[: len(done)])
        monitor = StageMonitor(
            *(job, stage, job_step),
            curve=progress.new_curve(stage.number),
            listen=listen,
            interim=interim,
            evaluate=isolated(agent, create, progress.folder / "acting.npz", evaluator.mean_returns),
        )
        if stage.steps:
            env = _training_env(job, stage, settings, monitor, num_threads)
            agent.learn(env, stage.steps)
            env.flush()
            env.close()
        episodes, policy = [], policy_of(agent)
        for task in stage.evaluated:
            start = time.perf_counter()
            rows = evaluator.evaluate(agent, stage.number, task, policy)
            result = (task.id, len(rows), sum(row.return_ for row in rows) / len(rows))
            where = (job.title, stage.number, stage.steps, job_step + stage.steps)
            listen(TaskEvaluated(*where, *result, seconds=time.perf_counter() - start))
            episodes += rows
        store_policy(out, job, stage.number, policy)
        card = card_of(agent, settings.agent)
        parameters = (first_parameters, card.parameters)
        record = FinishedStage(
            *(stage.number, episodes, monitor.curves, card, parameters, monitor.evaluations, blas_kernels())
        )
        progress.finish(record, agent, last=stage is stages[-1])
        done.append(record)
    evaluator.close()
    listen(JobFinished(job.title))
    return done


def _require_same(observes: Observes, settings: Settings, job: TrainingJob) -> None:
    if observes != settings.observes:
        message = f"The agent of {job.title} asks for {observes}, another agent for {settings.observes}."
        hint = "Give all agents of a factory the same attribute observes."
        raise BenchError("bad-agent", message, settings.agent, hint)


def _training_env(
    job: TrainingJob, stage: Stage, settings: Settings, monitor: StageMonitor, num_threads: int
) -> Recorder:
    ids = [task.id for task in stage.trained]
    return Recorder(
        make_vec(stage.trained, settings.num_envs_for(len(ids)), num_threads),
        ids,
        steps=stage.steps,
        batch_steps=budget(settings.budget).batch_steps,
        seed=training_seed(job.run, job.group.id, *ids, "training"),
        report=monitor,
        context=TrainingContext(settings.observes, job.group.task_ids, stage.number),
    )
