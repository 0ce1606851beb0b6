"""Evaluates agents on the tasks of a job with the prescribed seeds, and checks their policies."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from statistics import fmean
from typing import Any

import numpy as np

from gym_extensions.baselines.agent import Agent, Array, Card, Context, Resumable, TaskLabel, VectorEnv
from gym_extensions.baselines.agent_checks import VARIADIC, action_function
from gym_extensions.baselines.generators import preserved_global_generators
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, evaluation_seed
from gym_extensions.catalog.tasks import Task
from gym_extensions.envs import make_vec
from gym_extensions.envs.rollout import Outcome, Watch, clip_actions, run_episodes
from gym_extensions.errors import BenchError
from gym_extensions.submissions.log import Episode
from gym_extensions.submissions.manifest import Observes
from gym_extensions.submissions.policies.files import AnyPolicy, policy_keys, run_arrays, size_error
from gym_extensions.submissions.policies.mlp import mean_and_log_sigma, to_action
from gym_extensions.submissions.policies.onnx import OnnxPolicy

TOLERANCE = 1e-4
"""Largest difference between an agent's action and its policy's, in half widths of the action space.

Other batch sizes change the action of a policy by rounding.
"""
DEVIATIONS = 8.0
"""An action that a Gaussian policy samples is within this many standard deviations of the mean."""


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
    act = action_function(agent)
    return run_episodes(env, seeds, lambda seen, starts, _: act(seen, Context(starts, label)), watch=watch)


@dataclass
class Evaluator:
    """Evaluates on the tasks of a group; creates the environments of a task on first use and keeps them."""

    group: TaskGroup
    observes_task: bool = False  # whether the agent asked for ``task_in_evaluation``
    _envs: dict[tuple[str, int], VectorEnv] = field(default_factory=dict)

    def envs(self, task: Task, episodes: int = EVALUATION_EPISODES) -> VectorEnv:
        """One environment of the task per episode."""
        if (task.id, episodes) not in self._envs:
            self._envs[task.id, episodes] = make_vec(task, episodes)
        return self._envs[task.id, episodes]

    def evaluate(self, agent: Agent, stage: int, task: Task, policy: AnyPolicy | None) -> list[Episode]:
        """The episodes of the agent on a task. Raises ``BenchError`` if its policy acts in another way.

        If its policy is deterministic, the episodes are the policy's own, so that they can be repeated.
        """
        index, env = self.group.tasks.index(task), self.envs(task)
        seeds, label = self._seeds_and_label(task, EVALUATION_EPISODES)
        if policy is not None and policy.head == "deterministic":
            require_agreement(policy, env, seeds, first_actions(agent, env, seeds, label), index)
            policy.reset()
            outcomes = run_episodes(env, seeds, lambda seen, *_: policy.act(seen, None, index))
        else:
            first: list[Array] = []

            def remember(actions: Array | None) -> None:
                if actions is not None and not first:
                    first.append(np.array(actions))

            outcomes = evaluate(agent, env, seeds, label, remember)
            if policy is not None:
                require_agreement(policy, env, seeds, first[0], index)
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
        seeds = [evaluation_seed(self.group.id, task.id, episode) for episode in range(episodes)]
        label = TaskLabel(task.id, self.group.task_ids.index(task.id)) if self.observes_task else None
        return seeds, label

    def close(self) -> None:
        for env in self._envs.values():
            env.close()


def policy_of(agent: Agent) -> AnyPolicy | None:
    """The agent's policy; None if it has no method ``policy`` or cannot express its policy.

    An attribute ``policy`` that is not a method, such as a torch module, or a method with arguments is
    something else.

    Raises ``BenchError`` if the method returns neither a policy nor None.
    """
    method = getattr(agent, "policy", None)
    if not inspect.isroutine(method) or _required_parameters(method):
        return None
    policy: object = method()
    if policy is None or isinstance(policy, AnyPolicy):
        return policy
    message = f"Expected a Policy, an OnnxPolicy or None, got a value of type {type(policy).__name__}."
    raise BenchError("bad-policy", message, "policy()", "Return a gym_extensions.policies.Policy.")


def _required_parameters(method: Callable[..., object]) -> list[str]:
    parameters = inspect.signature(method).parameters.values()
    return [each.name for each in parameters if each.default is each.empty and each.kind not in VARIADIC]


def first_actions(agent: Agent, env: VectorEnv, seeds: Sequence[int], label: TaskLabel | None) -> Array:
    """The actions (num_envs, …) of an agent after a reset, clipped to the action space."""
    observations, _ = env.reset(seed=list(seeds))  # type: ignore[arg-type]
    context = Context(np.ones(len(seeds), np.bool_), label)
    return clip_actions(action_function(agent)(observations, context), env, "act()")


def require_agreement(
    policy: AnyPolicy, env: VectorEnv, seeds: Sequence[int], actions: Array, task: int
) -> None:
    """Checks that the policy takes the first actions of evaluation episodes.

    The action of a deterministic policy is known. For the others every action that they can sample agrees;
    of networks that sample only the number of actions is checked. The environments are reset with ``seeds``.

    Args:
        policy, env, seeds: the agent's policy, and the evaluation environments of a task.
        actions: the first action of each episode, as applied (num_envs, …).
        task: index of the task in the group.

    Raises:
        BenchError: an action differs, or the observations have another size than the policy's inputs.
    """
    observations, _ = env.reset(seed=list(seeds))  # type: ignore[arg-type]
    taken = actions.reshape(len(actions), -1)
    if taken.shape[1] != policy.num_actions:
        message = f"The actions have {taken.shape[1]} values; the policy has {policy.num_actions}."
        raise BenchError("bad-policy", message, "policy()", "Return the policy that act() uses.")
    space: Any = env.single_action_space
    low, high = (np.asarray(bound, np.float64).ravel() for bound in (space.low, space.high))
    with np.errstate(all="ignore"):
        bounds = [each.astype(np.float64) for each in _extremes(policy, observations, task)]
        lower, upper = (np.clip(bound, low, high) for bound in bounds)
        excess = np.maximum(lower - taken, taken - upper) / ((high - low) / 2)
    difference = float(np.maximum(excess, 0).max())
    if not difference <= TOLERANCE:
        message = f"The policy's actions differ from act() by {difference / 2:.3g} of the action range."
        hint = "Return the policy that act() uses, or None."
        raise BenchError("policy-differs", message, "policy()", hint)


def require_submittable(
    policy: AnyPolicy, card: Card, observes: Observes, group: TaskGroup, protocol: str
) -> None:
    """Checks, before training, what the rules of submissions say about policies.

    Raises ``BenchError`` (``bad-policy``) if the policy samples although the card says that evaluation is
    deterministic, if it depends on the task without observing it or has rows for more tasks than the group,
    or if the policies of a run would exceed the limits of size.
    """
    message, hint = "", "Use arrays without an axis of tasks, or one row per task and task_in_evaluation."
    if card.evaluation == "deterministic" and policy.head != "deterministic":
        message = f"The policy samples (its head is {policy.head!r}), and the card says that it does not."
        hint = 'Return a policy with head="deterministic", or a card with evaluation="sampled".'
    elif policy.num_tasks and not observes.task_in_evaluation:
        message = "The policy depends on the task, and the agent does not ask for task_in_evaluation."
    elif policy.num_tasks > len(group.tasks):
        message = f"The policy has arrays for {policy.num_tasks} tasks; {group.name} has {len(group.tasks)}."
    elif message := size_error(run_arrays(dict.fromkeys(policy_keys(protocol, group), policy))):
        hint = "Use smaller networks or float32, or no policy; without one, a run cannot be verified."
    if message:
        raise BenchError("bad-policy", message, "policy()", hint)


def _extremes(policy: AnyPolicy, observations: Array, task: int) -> tuple[Array, Array]:
    """The lowest and highest actions that a policy samples; for a deterministic one its actions."""
    if isinstance(policy, OnnxPolicy):
        if policy.head != "deterministic":
            bound = np.full((len(observations), policy.num_actions), np.inf)
            return -bound, bound
        policy.reset()
        actions = policy.act(observations, None, task)
        return actions, actions
    mean, log_sigma = mean_and_log_sigma(policy, observations, task)
    width = {"deterministic": 0.0, "uniform": 1.0}.get(policy.head, DEVIATIONS * np.exp(log_sigma))
    return to_action(policy, mean - width), to_action(policy, mean + width)


@contextmanager
def acting_copy(agent: Agent, create: Callable[[], Agent], path: Path) -> Iterator[Agent]:
    """A copy of the agent that acts without an effect on its training; restores global random generators.

    An agent that cannot be saved acts itself, so that its generator for acting moves on. ``create`` makes an
    agent of the same kind; the file ``path`` is written and deleted.
    """
    with preserved_global_generators():
        acting = create() if isinstance(agent, Resumable) else agent
        if isinstance(agent, Resumable) and isinstance(acting, Resumable):
            try:
                agent.save(path)
                acting.load(path)
            finally:
                path.unlink(missing_ok=True)
        yield acting
