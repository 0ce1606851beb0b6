"""Runs one job: trains its stages in order, evaluates after each, and records the results."""

import hashlib
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from statistics import fmean

import numpy as np

from gym_extensions.baselines import agent as agents, agent_spec, algorithms, generators
from gym_extensions.baselines.agent import Agent, Array, Context, Resumable, TaskLabel, VectorEnv
from gym_extensions.baselines.training import checkpoints, environment, jobs, progress
from gym_extensions.catalog import groups, protocol
from gym_extensions.catalog.tasks import Task
from gym_extensions.envs import make_vec
from gym_extensions.envs.rollout import Outcome, Watch, run_episodes
from gym_extensions.errors import BenchError
from gym_extensions.files import remove
from gym_extensions.submissions.log import Episode
from gym_extensions.submissions.policies.files import AnyPolicy
from gym_extensions.submissions.run import Curve, InterimEvaluation, Memory


def evaluate(
    agent: Agent,
    env: VectorEnv,
    seeds: Sequence[int],
    label: TaskLabel | None = None,
    watch: Watch | None = None,
) -> list[Outcome]:
    """Runs the first episode of every environment, of which there are ``len(seeds)``, with an agent.

    ``label`` is the task, only for an agent that asked for ``task_in_evaluation``. ``watch`` is called as by
    :func:`run_episodes`, whose outcomes are returned.
    """
    act = agents.action_function(agent)
    return run_episodes(env, seeds, lambda seen, starts, _: act(seen, Context(starts, label)), watch=watch)


@dataclass
class Evaluator:
    """Evaluates on the tasks of a group; creates the environments of a task on first use and keeps them."""

    group: groups.TaskGroup
    observes_task: bool = False  # whether the agent asked for ``task_in_evaluation``
    _envs: dict[tuple[str, int], VectorEnv] = field(default_factory=dict)

    def envs(self, task: Task, episodes: int = protocol.EVALUATION_EPISODES) -> VectorEnv:
        """One environment of the task per episode."""
        if (task.id, episodes) not in self._envs:
            self._envs[task.id, episodes] = make_vec(task, episodes)
        return self._envs[task.id, episodes]

    def evaluate(self, agent: Agent, stage: int, task: Task, policy: AnyPolicy | None) -> list[Episode]:
        """The episodes of the agent on a task. Raises ``BenchError`` if its policy acts in another way.

        If its policy is deterministic, the episodes are the policy's own, so that they can be repeated.
        """
        index, env = self.group.tasks.index(task), self.envs(task)
        seeds, label = self._seeds_and_label(task, protocol.EVALUATION_EPISODES)
        if policy is not None and policy.head == "deterministic":
            actions = agent_spec.first_actions(agent, env, seeds, label)
            agent_spec.require_agreement(policy, env, seeds, actions, index)
            policy.reset()
            outcomes = run_episodes(env, seeds, lambda seen, *_: policy.act(seen, None, index))
        else:
            first: list[Array] = []

            def remember(actions: Array | None) -> None:
                if actions is not None and not first:
                    first.append(np.array(actions))

            outcomes = evaluate(agent, env, seeds, label, remember)
            if policy is not None:
                agent_spec.require_agreement(policy, env, seeds, first[0], index)
        return [
            Episode(stage, task.id, episode, seed, *outcome)
            for episode, (seed, outcome) in enumerate(zip(seeds, outcomes, strict=True))
        ]

    def mean_return(self, agent: Agent, task: Task, episodes: int) -> float:
        """The mean return on a task over its first episodes."""
        seeds, label = self._seeds_and_label(task, episodes)
        outcomes = evaluate(agent, self.envs(task, episodes), seeds, label)
        return fmean(outcome.return_ for outcome in outcomes)

    def _seeds_and_label(self, task: Task, episodes: int) -> tuple[list[int], TaskLabel | None]:
        seeds = [protocol.evaluation_seed(self.group.id, task.id, episode) for episode in range(episodes)]
        label = TaskLabel(task.id, self.group.task_ids.index(task.id)) if self.observes_task else None
        return seeds, label

    def close(self) -> None:
        for env in self._envs.values():
            env.close()


@dataclass(frozen=True)
class PendingJob:
    """A job with everything that a worker process needs to run it."""

    job: jobs.TrainingJob
    settings: jobs.Settings
    out: Path  # the submission's folder

    @property
    def title(self) -> str:
        return self.job.title

    @property
    def steps(self) -> int:
        """The training steps of all stages."""
        return sum(stage.steps for stage in self.job.stages(self.settings.budget))

    def run(self, listen: progress.Listener) -> list[checkpoints.FinishedStage]:
        """Runs every stage that an earlier attempt did not finish. Returns the records of all stages."""
        job, settings, spec = self.job, self.settings, self.settings.agent
        stages = job.stages(settings.budget)
        folder = checkpoints.JobFolder(self.out, job)
        folder.begin(settings)
        done = folder.finished()
        if len(done) < len(stages):
            evaluator = Evaluator(job.group, spec.observes.task_in_evaluation)
            env = evaluator.envs(stages[0].evaluated[0])
            limited = getattr(spec.factory, "for_job", None)  # of agents in boxes
            factory = limited(job.group, self.steps) if limited else spec.factory

            def create() -> Agent:
                spaces = env.single_observation_space, env.single_action_space
                seeds = self.seed("observation space"), self.seed("action space")
                observations, actions = map(generators.seeded_copy, spaces, seeds)
                with generators.preserved_global_generators(self.seed("creation")):
                    make = algorithms.factory(factory)
                    generators.seed_global_generators()  # the agent's file may have loaded torch
                    return make(observations, actions, self.seed("agent"))

            agent = create()
            spec.require_same(agent, job.title)
            first_parameters = agent_spec.card_of(agent, spec.name).parameters
            if done and (resumed := folder.resume(agent, done)) is not None:
                agent = resumed
            else:
                done = []
            for stage in stages[len(done) :]:
                before = sum(earlier.steps for earlier in stages if earlier.number < stage.number)
                run = StageRun(self, folder, stage, before, listen, evaluator, agent, create)
                record = run.run(first_parameters)
                folder.finish(record, agent, last=stage is stages[-1])
                done.append(record)
            evaluator.close()
        listen(progress.JobFinished(job.title))
        return done

    def seed(self, *purpose: str) -> int:
        """The seed of one purpose in the run."""
        run, group = self.job.run, self.job.group
        if seeds := self.settings.seeds:
            run = int(hashlib.sha256(f"{seeds}/{group.id}/{run}".encode()).hexdigest(), 16)
        return generators.training_seed(run, group.id, *purpose)


@dataclass
class StageRun:
    """Runs one stage of a job: trains, evaluates, stores the policy, and sends what happens as events."""

    pending: PendingJob
    folder: checkpoints.JobFolder
    stage: jobs.Stage
    steps_before: int  # training steps of the stages before
    listen: progress.Listener
    evaluator: Evaluator
    agent: Agent
    create: Callable[[], Agent]  # makes another one of its kind

    def __post_init__(self) -> None:
        number, during = self.stage.number, self.pending.settings.evaluate_episodes
        self._next = self.pending.settings.evaluate_every or 0
        self._curves = {
            task.id: Curve(stage=number, task=task.id, steps=[], returns=[]) for task in self.stage.trained
        }
        self._evaluations = {
            task.id: InterimEvaluation(stage=number, task=task.id, episodes=during, steps=[], returns=[])
            for task in self.stage.evaluated
        }

    def run(self, first_parameters: int) -> checkpoints.FinishedStage:
        """Returns the record of the stage; ``first_parameters`` is the agent's number before training."""
        agent, stage, spec = self.agent, self.stage, self.pending.settings.agent
        started = checkpoints.processor_time(agent)
        number, ids = stage.number, tuple(self._curves)
        self.listen(progress.StageStarted(self.pending.job.title, number, ids, stage.steps))
        taken = self._train(ids) if stage.steps else 0
        policy, episodes = agents.policy_of(agent), list[Episode]()
        if policy is not None:
            agent_spec.require_submittable(policy, spec.card, spec.observes, self.pending.job.group)
        with_policy, without = self.folder.policies()  # of earlier stages
        if (with_policy and policy is None) or (without and policy is not None):
            hint = "Return one in every stage, before training, too, or None in all."
            raise BenchError("bad-policy", "Only some stages have a policy.", "policy()", hint)
        for task in stage.evaluated:
            start = time.perf_counter()
            with generators.preserved_global_generators(self.pending.seed(f"evaluation {number}", task.id)):
                new = self.evaluator.evaluate(agent, number, task, policy)
            mean_return = fmean(episode.return_ for episode in new)
            result = task.id, len(new), mean_return, time.perf_counter() - start
            self.listen(progress.TaskEvaluated(*self._where(stage.steps), *result))
            episodes += new
        self.folder.store_policy(number, policy)
        card = agent_spec.card_of(agent, spec.name)
        memory = Memory(
            stored_steps=card.stored_steps, parameters_first=first_parameters, parameters_last=card.parameters
        )
        agent_spec.warn_of_few_steps(card, taken, stage.steps)
        if stage.steps and not card.stored_steps:
            space = self.evaluator.envs(stage.evaluated[0]).single_observation_space
            agent_spec.warn_of_stored_steps(agent, space.shape or ())
        curves = [curve for curve in self._curves.values() if curve.steps]
        evaluations = [each for each in self._evaluations.values() if each.steps]
        used = checkpoints.usage_since(started, taken, agent)
        return checkpoints.FinishedStage(number, episodes, curves, memory, used, evaluations)

    def _train(self, ids: Sequence[str]) -> int:
        """Returns the steps that the agent took on the tasks with these ids."""
        settings, stage, seed = self.pending.settings, self.stage, self.pending.seed
        env = environment.TrainingEnv(
            make_vec(
                stage.trained,
                settings.num_envs_for(len(ids)),
                settings.num_threads,
                autoreset_mode=settings.agent.autoreset_mode,
            ),
            ids,
            steps=stage.steps,
            batch_steps=settings.budget.batch_steps,
            seed=seed(*ids, "training"),
            report=self._report,
            tick=lambda step, speed: self.listen(progress.StepsTrained(*self._where(step), speed)),
            observes=settings.agent.observes,
            group_ids=self.pending.job.group.task_ids,
            stage=stage.number,
        )
        with generators.preserved_global_generators(seed(*ids, "global generators")):
            self.agent.learn(env, stage.steps)
        env.flush()
        env.close()
        return env.taken

    def _report(self, batch: environment.Report) -> None:
        """Appends the returns to the curves, sends the event and evaluates if it is time to."""
        for task_id, value in batch.returns.items():
            self._curves[task_id].steps.append(batch.step)
            self._curves[task_id].returns.append(value)
        where, speed = self._where(batch.step), batch.steps / max(batch.seconds, 1e-9)
        self.listen(progress.BatchTrained(*where, batch.mean_return, speed, batch.seconds))
        every, episodes = self.pending.settings.evaluate_every, self.pending.settings.evaluate_episodes
        if every and self._next <= batch.step < self.stage.steps:
            self._next = every * (1 + batch.step // every)
            with self._acting_copy() as agent:
                for task in self.stage.evaluated:
                    start = time.perf_counter()
                    mean_return = self.evaluator.mean_return(agent, task, episodes)
                    self._evaluations[task.id].steps.append(batch.step)
                    self._evaluations[task.id].returns.append(mean_return)
                    result = task.id, episodes, mean_return, time.perf_counter() - start
                    self.listen(progress.TaskEvaluated(*where, *result, in_training=True))

    @contextmanager
    def _acting_copy(self) -> Iterator[Agent]:
        """A copy of the agent that acts without an effect on its training; restores global random generators.

        An agent that cannot be saved acts itself, so that its generator for acting moves on.
        """
        with generators.preserved_global_generators():
            acting, path = self.agent, self.folder.path / "acting.npz"
            if isinstance(self.agent, Resumable):
                try:
                    agents.save(self.agent, path)
                    acting = agents.load(self.create(), path)  # type: ignore[arg-type]
                finally:
                    remove(path)
            yield acting

    def _where(self, step: int) -> tuple[str, int, int, int]:
        return self.pending.job.title, self.stage.number, step, self.steps_before + step
