"""TRPO with shared hidden layers and a head per task (Wolczyk et al. 2021), or with a network per task."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from gym_extensions.baselines.agent import Array, Card, Context, VectorEnv
from gym_extensions.baselines.algorithms.trpo import Trpo
from gym_extensions.baselines.trust_region import policy as policies
from gym_extensions.errors import BenchError
from gym_extensions.submissions.manifest import Observes
from gym_extensions.submissions.policies.mlp import Policy, by_task

Row = TypeVar("Row")


def single_task(env: VectorEnv, name: str) -> int:
    """The index of the task that the training environments run. Raises ``BenchError`` if they run several."""
    tasks = np.unique(env.env_tasks)  # type: ignore[attr-defined]  # of the training environments
    if len(tasks) > 1:
        hint = "Use any protocol but joint, or an agent without heads, such as trpo."
        message = f"The agent learns a single task at a time, but the environments run {len(tasks)} tasks."
        raise BenchError("single-task-agent", message, name, hint)
    return int(tasks[0])


def rows_of(learned: Mapping[int, Row], present: int, num_tasks: int) -> list[Row]:
    """What is published for each task: what was learned, or what the present task has.

    The last row of a policy is also that of all later tasks.
    """
    count = max(learned) + 1
    if present + 1 != count:  # the present row, for the tasks after the last one that was learned
        count = min(count + 1, num_tasks)
    return [learned.get(task, learned[present]) for task in range(count)]


@dataclass(frozen=True)
class Head:
    """A task's own part of the policy."""

    parameters: Array  # of the output layer, then log σ (k,)
    moments: policies.Moments  # of the observations, at the end of the task
    number: int  # 1 for the task that was learned first, 2 for the second, and so on


class MultiHead(Trpo):
    """The agent ``multi-head``.

    A task starts with a new output layer, the initial log σ, and the hidden layers and moments of the task
    before. At its end its output layer, log σ and moments are stored. A task that was not learned yet is
    evaluated with those of the present task.
    """

    name, title = "multi-head", "TRPO + multi-head"
    description = "The reference agent with an output layer and log σ per task; it observes the task."
    parent = Trpo.name
    observes = Observes(task_in_training=True, task_in_evaluation=True, boundaries=True)
    shares_hidden_layers = True
    """Whether the tasks share all layers but the last; else they share none."""

    def __init__(self, *arguments: Any, copy_head: bool = False, **settings: Any) -> None:
        """With ``copy_head`` a task starts with the output layer and log σ of the task before."""
        super().__init__(*arguments, **settings)
        self._copy_head = copy_head
        sizes = self._architecture.sizes
        self._shared_layers = len(sizes) - 2 if self.shares_hidden_layers else 0
        # The parameters of the shared layers come first in the flat vector.
        count = policies.parameter_count(sizes[: self._shared_layers + 1])
        self._hidden, self._head = slice(count), slice(count, None)
        self._heads: dict[int, Head] = {}  # by the index of their task in the group
        self._task = self._number = self._num_tasks = 0

    def act(self, observations: Array, context: Context | None = None) -> Array:
        """Acts as in the context's task; without a context, as in the present one."""
        head = self._heads.get(context.task) if context else None
        if head is None:
            return super().act(observations)
        return self._act(observations, self._parameters_of(head), head.moments)

    def learn(self, env: VectorEnv, steps: int) -> None:
        """Learns one task. Raises ``BenchError`` if the environments run several tasks."""
        self._task = single_task(env, self.name)
        self._num_tasks = int(env.num_tasks)  # type: ignore[attr-defined]  # of the training environments
        self._begin()
        super().learn(env, steps)
        self._heads[self._task] = Head(self._theta[self._head].copy(), self._moments, self._number)

    def _begin(self) -> None:
        self._number += 1
        if self._heads and self.shares_hidden_layers and not self._copy_head:
            head = self._initial_policy()[self._head]
            self._theta = np.concatenate([self._theta[self._hidden], head])

    def _parameters_of(self, head: Head) -> Array:
        """The policy's parameters in a finished task (p,)."""
        return np.concatenate([self._theta[self._hidden], head.parameters])

    def policy(self) -> Policy:
        """The policy as plain arrays, with a row per task; its actions are the agent's up to rounding.

        The rows of tasks that were not learned yet are those of the present one.
        """
        if not self._heads:
            return super().policy()
        rows = rows_of(self._heads, self._task, self._num_tasks)
        return by_task([self._policy_of(head) for head in rows], self._shared_layers)

    def _policy_of(self, head: Head) -> Policy:
        """The policy in a finished task."""
        return self._exported(np.concatenate([self._theta[self._hidden], head.parameters]), head.moments)

    def card(self) -> Card:
        """The card of ``trpo`` with the parameters of all heads, and ``copy_head`` if it is used."""
        card = super().card()
        more = max(len(self._heads) - 1, 0) * len(self._theta[self._head])
        settings = {**card.hyperparameters} | ({"copy_head": True} if self._copy_head else {})
        return replace(card, hyperparameters=settings, parameters=card.parameters + more)

    def _state(self) -> dict[str, Array]:
        """The state of ``trpo`` with the heads: ``head3/parameters``, ``head3/mean`` and so on."""
        heads = dict[str, Array]()
        for task, head in self._heads.items():
            parts = {"parameters": head.parameters, "number": head.number, **vars(head.moments)}
            heads |= {f"head{task}/{name}": np.asarray(value) for name, value in parts.items()}
        return super()._state() | heads | {"progress": np.array([self._task, self._number, self._num_tasks])}

    def _restore(self, arrays: Mapping[str, Array]) -> None:
        super()._restore(arrays)
        self._task, self._number, self._num_tasks = map(int, arrays["progress"])
        self._heads = {}
        for head in (name.removesuffix("/number") for name in arrays if name.endswith("/number")):
            names = ("parameters", "number", "count", "mean", "squares")
            parameters, number, count, mean, squares = (arrays[f"{head}/{name}"] for name in names)
            moments = policies.Moments(float(count), mean, squares)
            self._heads[int(head.removeprefix("head"))] = Head(parameters, moments, int(number))


class Snapshots(MultiHead):
    """The agent ``snapshots``. It learns bit for bit as ``trpo`` does, and copies its policy after each task.

    It is ``multi-head`` with the whole network as the head of a task, which starts with the parameters of the
    task before. A task that was not learned yet is evaluated with the present policy. So its score at the end
    is what ``trpo`` scores right after training, by definition, and it forgets nothing.
    """

    name, title = "snapshots", "TRPO + snapshots"
    description = "The reference agent with a copy of its policy per learned task; it observes the task."
    shares_hidden_layers = False


make = MultiHead
