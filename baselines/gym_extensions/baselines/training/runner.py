"""Runs one job: trains its stages in order, evaluates after each, and records the results."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from gym_extensions.baselines import algorithms
from gym_extensions.baselines.agent import Agent, policy_of
from gym_extensions.baselines.agent_spec import card_of
from gym_extensions.baselines.generators import seeded_copy, seeded_global_generators, training_seed
from gym_extensions.baselines.training import events
from gym_extensions.baselines.training.checkpoints import FinishedStage, JobFolder
from gym_extensions.baselines.training.environment import Report, TrainingEnv
from gym_extensions.baselines.training.evaluation import Evaluator, acting_copy
from gym_extensions.baselines.training.jobs import Interim, Settings, Stage, TrainingJob
from gym_extensions.baselines.training.provenance import processor_time, usage_since
from gym_extensions.envs import make_vec
from gym_extensions.submissions.run import Curve, InterimEvaluation, Memory


@dataclass(frozen=True)
class PendingJob:
    """A job with everything that a worker process needs to run it."""

    job: TrainingJob
    settings: Settings
    out: Path  # the submission's folder

    @property
    def plan(self) -> events.JobPlan:
        return self.job.plan(self.settings.budget, self.settings.interim)

    def run(self, listen: events.Listener) -> list[FinishedStage]:
        """Runs every stage that an earlier attempt did not finish. Returns the records of all stages."""
        job, settings, spec = self.job, self.settings, self.settings.agent
        stages = job.stages(settings.budget)
        folder = JobFolder(self.out, job)
        folder.begin(settings)
        done = folder.finished()
        if len(done) < len(stages):
            evaluator = Evaluator(job.group, spec.observes.task_in_evaluation)
            env = evaluator.envs(stages[0].evaluated[0])

            def create() -> Agent:
                observations = seeded_copy(env.single_observation_space, self._seed("observation space"))
                actions = seeded_copy(env.single_action_space, self._seed("action space"))
                with seeded_global_generators(self._seed("creation")):
                    return algorithms.factory(spec.factory)(observations, actions, self._seed("agent"))

            agent = create()
            spec.require_same(agent, job.title)
            first_parameters = card_of(agent, spec.name).parameters
            if done and not folder.resume(agent, done):
                done = []
            acting = partial(acting_copy, agent, create, folder.path / "acting.npz")
            for stage in stages[len(done) :]:
                job_step = sum(earlier.steps for earlier in stages if earlier.number < stage.number)
                monitor = StageMonitor(folder, stage, job_step, listen, settings.interim, evaluator, acting)
                record = self._run_stage(agent, monitor, first_parameters)
                folder.finish(record, agent, last=stage is stages[-1])
                done.append(record)
            evaluator.close()
        listen(events.JobFinished(job.title))
        return done

    def _seed(self, *purpose: str) -> int:
        return training_seed(self.job.run, self.job.group.id, *purpose)

    def _run_stage(self, agent: Agent, monitor: StageMonitor, first_parameters: int) -> FinishedStage:
        started, stage = processor_time(agent), monitor.stage
        ids = tuple(task.id for task in stage.trained)
        monitor.listen(events.StageStarted(self.job.title, stage.number, ids, stage.steps))
        taken = self._train(stage, agent, monitor) if stage.steps else 0
        policy, episodes = policy_of(agent), []
        for task in stage.evaluated:
            start = time.perf_counter()
            with seeded_global_generators(self._seed(f"evaluation {stage.number}", task.id)):
                new = monitor.evaluator.evaluate(agent, stage.number, task, policy)
            mean_return = sum(episode.return_ for episode in new) / len(new)
            monitor.evaluated(stage.steps, (task.id, len(new), mean_return, time.perf_counter() - start))
            episodes += new
        monitor.folder.store_policy(stage.number, policy)
        card = card_of(agent, self.settings.agent.name)
        memory = Memory(
            stored_steps=card.stored_steps,
            parameters_first=first_parameters,
            parameters_last=card.parameters,
        )
        used, curves, evaluations = usage_since(started, taken, agent), monitor.curves, monitor.evaluations
        return FinishedStage(stage.number, episodes, curves, memory, used, evaluations)

    def _train(self, stage: Stage, agent: Agent, monitor: StageMonitor) -> int:
        """Trains a stage and returns the steps that the agent took."""
        settings, ids = self.settings, [task.id for task in stage.trained]
        env = TrainingEnv(
            make_vec(stage.trained, settings.num_envs_for(len(ids)), settings.num_threads),
            ids,
            steps=stage.steps,
            batch_steps=settings.budget.batch_steps,
            seed=self._seed(*ids, "training"),
            report=monitor.trained,
            observes=settings.agent.observes,
            group_ids=self.job.group.task_ids,
            stage=stage.number,
        )
        with seeded_global_generators(self._seed(*ids, "global generators")):
            agent.learn(env, stage.steps)
        env.flush()
        env.close()
        return env.taken


@dataclass
class StageMonitor:
    """Stores and sends what happens in a stage, and evaluates the agent during training."""

    folder: JobFolder
    stage: Stage
    job_step: int  # training steps of the stages before
    listen: events.Listener
    interim: Interim | None  # None evaluates at the end of the stage only
    evaluator: Evaluator
    acting: Callable[[], AbstractContextManager[Agent]]  # the agent that acts in evaluations during training

    def __post_init__(self) -> None:
        number, episodes = self.stage.number, self.interim.episodes if self.interim else 0
        self._next = self.interim.every if self.interim else 0
        self._curves = {
            task.id: Curve(stage=number, task=task.id, steps=[], returns=[]) for task in self.stage.trained
        }
        self._evaluations = {
            task.id: InterimEvaluation(stage=number, task=task.id, episodes=episodes, steps=[], returns=[])
            for task in self.stage.evaluated
        }

    @property
    def curves(self) -> list[Curve]:
        """The training curves that have points, in training order."""
        return [curve for curve in self._curves.values() if curve.steps]

    @property
    def evaluations(self) -> list[InterimEvaluation]:
        """The evaluations during training, in training order of the tasks."""
        return [each for each in self._evaluations.values() if each.steps]

    def trained(self, batch: Report) -> None:
        """Appends the returns to the curves, sends the event and evaluates if it is time to."""
        stage, interim, step = self.stage, self.interim, batch.step
        for task_id, value in batch.returns.items():
            self._curves[task_id].steps.append(step)
            self._curves[task_id].returns.append(value)
        speed = batch.steps / max(batch.seconds, 1e-9)
        self.listen(events.BatchTrained(*self._where(step), batch.mean_return, speed, batch.seconds))
        if interim is not None and self._next <= step < stage.steps:
            self._next = interim.every * (1 + step // interim.every)
            with self.acting() as agent:
                for task in stage.evaluated:
                    start = time.perf_counter()
                    mean_return = self.evaluator.mean_return(agent, task, interim.episodes)
                    self._evaluations[task.id].steps.append(step)
                    self._evaluations[task.id].returns.append(mean_return)
                    result = task.id, interim.episodes, mean_return, time.perf_counter() - start
                    self.evaluated(step, result, in_training=True)

    def evaluated(self, step: int, result: tuple[str, int, float, float], in_training: bool = False) -> None:
        """Sends the event of an evaluated task: its id, episodes, mean return, and the seconds it took."""
        self.listen(events.TaskEvaluated(*self._where(step), *result, in_training))

    def _where(self, step: int) -> tuple[str, int, int, int]:
        return self.folder.job.title, self.stage.number, step, self.job_step + step
