"""Runs one job: trains its stages in order, evaluates after each, and records the results."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

from gym_extensions.baselines import algorithms
from gym_extensions.baselines.agent import Agent, Factory, VectorEnv
from gym_extensions.baselines.agent_checks import card_of, observes_of
from gym_extensions.baselines.training.checkpoints import FinishedStage, JobFolder
from gym_extensions.baselines.training.environment import StageMonitor, TrainingContext, TrainingEnv
from gym_extensions.baselines.training.evaluation import Evaluator, isolated, policy_of
from gym_extensions.baselines.training.events import (
    JobFinished,
    JobPlan,
    Listener,
    StageStarted,
    TaskEvaluated,
)
from gym_extensions.baselines.training.jobs import (
    Interim,
    Settings,
    Stage,
    TrainingJob,
    seeded_copy,
    seeded_global_generators,
    training_seed,
)
from gym_extensions.baselines.training.usage import Meter
from gym_extensions.catalog.protocol import budget
from gym_extensions.envs import make_vec
from gym_extensions.envs.fingerprinting import fingerprint_of
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.log import Episode


@dataclass(frozen=True)
class PendingJob:
    """A job with everything that a worker process needs to run it.

    Args:
        job: the job.
        agent: the name or the factory of the agent.
        settings: how it runs.
        out: the submission's folder.
        interim: when to evaluate during training; None evaluates at the end of each stage only.
        num_threads: threads that step the training environments. Results do not depend on it.
    """

    job: TrainingJob
    agent: str | Factory
    settings: Settings
    out: Path
    interim: Interim | None = None
    num_threads: int = 1

    @property
    def plan(self) -> JobPlan:
        """The work of every stage."""
        return self.job.plan(budget(self.settings.budget), self.interim)

    def run(self, listen: Listener) -> list[FinishedStage]:
        """Runs every stage that an earlier attempt did not finish. Returns the records of all stages."""
        job, settings = self.job, self.settings
        stages = job.stages(budget(settings.budget))
        progress = JobFolder.of(self.out, job)
        progress.begin(
            asdict(settings)
            | {"group": job.group.id, "tasks": list(job.group.task_ids)}
            | {"fingerprints": [fingerprint_of(task) for task in job.group.tasks]}
        )
        done = progress.finished()
        if len(done) < len(stages):
            evaluator = Evaluator(job.group, settings.observes.task_in_evaluation)
            spaces = evaluator.envs(stages[0].evaluated[0])
            agent = self._create(spaces)
            card = card_of(agent, settings.agent)
            first_parameters = done[0].parameters[0] if done else card.parameters
            if done and not progress.resume(agent, done):
                done = []
            for stage in stages[len(done) :]:
                record = self._run_stage(
                    *(agent, stage, listen, progress, evaluator),
                    job_step=sum(earlier.steps for earlier in stages if earlier.number < stage.number),
                    first_parameters=first_parameters,
                    create=partial(self._create, spaces),
                )
                progress.finish(record, agent, last=stage is stages[-1])
                done.append(record)
            evaluator.close()
        listen(JobFinished(job.title))
        return done

    def _seed(self, *purpose: str) -> int:
        return training_seed(self.job.run, self.job.group.id, *purpose)

    def _create(self, env: VectorEnv) -> Agent:
        make, settings = algorithms.factory(self.agent), self.settings
        observations = seeded_copy(env.single_observation_space, self._seed("observation space"))
        actions = seeded_copy(env.single_action_space, self._seed("action space"))
        with seeded_global_generators(self._seed("creation")):
            agent = make(observations, actions, self._seed("agent"))
        observes = observes_of(agent, settings.agent)
        if observes != settings.observes:
            message = (
                f"The agent of {self.job.title} asks for {observes}, another agent for {settings.observes}."
            )
            hint = "Give all agents of a factory the same attribute observes."
            raise BenchError("bad-agent", message, settings.agent, hint)
        return agent

    def _run_stage(
        self,
        agent: Agent,
        stage: Stage,
        listen: Listener,
        progress: JobFolder,
        evaluator: Evaluator,
        *,
        job_step: int,
        first_parameters: int,
        create: Callable[[], Agent],
    ) -> FinishedStage:
        job, meter = self.job, Meter()
        listen(StageStarted(job.title, stage.number, tuple(task.id for task in stage.trained), stage.steps))
        monitor = StageMonitor(
            *(job, stage, job_step),
            curve=progress.new_curve(stage.number),
            listen=listen,
            interim=self.interim,
            evaluate=isolated(agent, create, progress.folder / "acting.npz", evaluator.mean_returns),
        )
        taken = self._train(stage, agent, monitor) if stage.steps else 0
        episodes, policy = list[Episode](), policy_of(agent)
        for task in stage.evaluated:
            start = time.perf_counter()
            with seeded_global_generators(self._seed(f"evaluation {stage.number}", task.id)):
                new = evaluator.evaluate(agent, stage.number, task, policy)
            result = (task.id, len(new), sum(episode.return_ for episode in new) / len(new))
            where = (job.title, stage.number, stage.steps, job_step + stage.steps)
            listen(TaskEvaluated(*where, *result, seconds=time.perf_counter() - start))
            episodes += new
        progress.store_policy(stage.number, job.task_name, policy)
        card = card_of(agent, self.settings.agent)
        parameters, usage = (first_parameters, card.parameters), meter.usage(taken)
        return FinishedStage(
            stage.number, episodes, monitor.curves, card, parameters, usage, monitor.evaluations
        )

    def _train(self, stage: Stage, agent: Agent, monitor: StageMonitor) -> int:
        """Trains a stage and returns the steps that the agent took."""
        settings, ids = self.settings, [task.id for task in stage.trained]
        env = TrainingEnv(
            make_vec(stage.trained, settings.num_envs_for(len(ids)), self.num_threads),
            ids,
            steps=stage.steps,
            batch_steps=budget(settings.budget).batch_steps,
            seed=self._seed(*ids, "training"),
            report=monitor,
            context=TrainingContext(settings.observes, self.job.group.task_ids, stage.number),
        )
        with seeded_global_generators(self._seed(*ids, "global generators")):
            agent.learn(env, stage.steps)
        env.flush()
        env.close()
        return env.taken
