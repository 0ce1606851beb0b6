"""What training knows of an agent, made and checked once, before anything runs."""

import itertools
import math
import sys
import tempfile
import warnings
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from types import ModuleType
from typing import Any, Self

import msgspec
import numpy as np
from gymnasium.vector import AutoresetMode
from msgspec.structs import asdict

from gym_extensions.baselines import agent as agents, algorithms, generators
from gym_extensions.baselines.agent import Agent, Array, Card, Context, Factory, TaskLabel, VectorEnv
from gym_extensions.baselines.algorithms.floors import FLOORS
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import STANDARD_BUDGET, evaluation_seed
from gym_extensions.envs import make_vec, rollout
from gym_extensions.errors import BenchError
from gym_extensions.submissions import layout, manifest, rules, run
from gym_extensions.submissions.policies import mlp, onnx
from gym_extensions.submissions.policies.files import AnyPolicy, Key, policy_keys, run_arrays, size_error
from gym_extensions.versions import version_or_none

CARD_TYPES: dict[str, Any] = {
    "algorithm": str,
    "hyperparameters": dict[str, Any],
    **dict.fromkeys(("tuning_tasks", "packages"), tuple[str, ...]),
    **dict.fromkeys(("stored_steps", "parameters"), run.Count),
}
"""The types of what ``submission.toml`` does not hold, or holds in another way."""
NO_FOLDER = layout.Folder(Path("card"), "card", (), {})
"""The rules look at the tables only."""
STORED, MOST_HELD = 1000, 100
"""Observations that an agent may hold without stating that it stores steps; parts that are looked at."""
TOLERANCE = 1e-4
"""Largest difference between an agent's action and its policy's, in half widths of the action space.

Other batch sizes change the action of a policy by rounding.
"""
DEVIATIONS = 8.0
"""An action that a Gaussian policy samples is within this many standard deviations of the mean."""


@dataclass(frozen=True)
class AgentSpec:
    """An agent that fits the training loop and submissions, in all protocols and runs of one command.

    Args:
        name: of the factory, for agents without a card.
        factory: the factory, or its name, which each process looks up itself: importing the module of an
            agent may set up its libraries.
        card: the agent's, before training.
        observes: what it asks for.
        autoreset_mode: of its environment in training.
    """

    name: str
    factory: str | Factory
    card: Card
    observes: manifest.Observes
    autoreset_mode: AutoresetMode = AutoresetMode.NEXT_STEP

    @classmethod
    def of(
        cls, agent: str | Factory, logs: Sequence[tuple[TaskGroup, str]], *, on_boards: bool = False
    ) -> Self:
        """The spec of an agent for logs of these groups and protocols, whose budget may be on boards.

        One agent is created for it, which acts once; a second one if it can be saved. The runs create their
        own: acting changes what an agent samples next, worker processes cannot receive most agents, and a
        folder is refused before they start.

        Raises ``BenchError`` if the factory, the agent or its card does not fit, the agent's actions have a
        wrong shape or are not those of its policy, the submission may not contain the policy, or the agent
        cannot load what it saved. Warns if it loads something else, uses packages that no card names, or has
        no policy, which a rank requires.
        """
        name, make = algorithms.name_of(agent), algorithms.factory(agent)
        group, _ = logs[0]
        env = make_vec(group.tasks[0], 1)
        spaces = env.single_observation_space, env.single_action_space
        trial = agents.create(make, spaces, 0, name)
        observes, mode = agents.observes_of(trial, name), agents.autoreset_mode_of(trial, name)
        spec = cls(name, agent, checked_card(trial, name), observes, mode)
        label = TaskLabel(group.task_ids[0], 0) if spec.observes.task_in_evaluation else None
        seeds = [evaluation_seed(group.id, group.task_ids[0], 0)]
        actions = first_actions(trial, env, seeds, label)
        if (policy := agents.policy_of(trial)) is not None:
            require_agreement(policy, env, seeds, actions, 0)
            for log_group, protocol in logs:
                keys = policy_keys(protocol, log_group)
                require_submittable(policy, spec.card, spec.observes, log_group, keys)
        elif on_boards:
            message = "The agent gives no policy, and a run without policies has no rank. "
            hint = "Add a method policy() before you train: finished runs are not trained again."
            warnings.warn(message + hint, stacklevel=3)
        if isinstance(trial, agents.Resumable):
            other, acted = agents.create(make, spaces, 1, name), list[Array]()
            with tempfile.TemporaryDirectory() as folder:
                agents.save(trial, saved := Path(folder, "agent.npz"))
                for each in (trial, agents.load(other, saved)):  # type: ignore[arg-type]
                    with generators.preserved_global_generators(0):
                        acted.append(first_actions(each, env, seeds, label))
            if not np.allclose(acted[0], acted[1], TOLERANCE, TOLERANCE):
                message = "After save() and load() the agent takes other actions, so that an interrupted run "
                hint = "would go on otherwise. Save the whole agent, random generators included."
                warnings.warn(message + hint, stacklevel=3)
        if not spec.card.packages and (used := packages_of(trial)):
            message = f"The agent holds objects of {', '.join(used)}, and its card names no packages. "
            hint = "Name those on which results depend in Card(packages=...)."
            warnings.warn(message + hint, stacklevel=3)
        env.close()
        return spec

    def require_same(self, agent: Agent, title: str) -> None:
        """Raises ``BenchError`` if the agent of a job states or asks for something else than the spec."""
        observes, settings = agents.observes_of(agent, self.name), card_of(agent, self.name).hyperparameters
        for what, one, other in (
            ("attribute observes", observes, self.observes),
            ("hyperparameters", settings, self.card.hyperparameters),
        ):
            if one != other:
                message = f"The agent of {title} has the {what} {one}, another agent {other}."
                hint = f"Give all agents of a factory the same {what}, whatever the seed and the spaces."
                raise BenchError("bad-agent", message, self.name, hint)


def card_of(agent: Agent, name: str) -> Card:
    """The agent's card in its present state; one with only ``name`` if it has none.

    Raises ``BenchError`` if it is another value, or a value has another type.
    """
    card: object = agent.card() if isinstance(agent, agents.Described) else Card(algorithm=name)
    if not isinstance(card, Card):
        message = f"Expected a Card, got {type(card).__name__}."
        raise BenchError("bad-card", message, "card()", "Return a gym_extensions.baselines.Card.")
    for field, kind in CARD_TYPES.items():
        try:
            msgspec.convert(getattr(card, field), kind)
        except msgspec.ValidationError as error:
            raise _bad_card(field, f"The value is {getattr(card, field)!r}: {error}.") from error
    return card


def packages_of(agent: object) -> list[str]:
    """The names of packages, besides those that every run states, whose objects an agent holds."""
    held = (value for value in _held(agent) if type(value).__module__.partition(".")[0] != "gym_extensions")
    roots = {kind.__module__.partition(".")[0] for value in held for kind in type(value).__mro__}
    roots -= {type(agent).__module__.partition(".")[0], *run.Versions.__struct_fields__}
    roots -= sys.stdlib_module_names
    names = metadata.packages_distributions() if roots else {}
    return sorted({name for root in roots for name in names.get(root, ())[:1]})


def warn_of_stored_steps(agent: object, shape: tuple[int, ...]) -> None:
    """Warns if an agent whose card states no stored steps holds many observations of this shape."""
    most = 0
    for value in _held(agent):
        size = getattr(value, "shape", None)
        if isinstance(value, list | deque):
            most = max(most, len(value) if value and not np.isscalar(value[0]) else 0)
        elif isinstance(size, tuple) and shape and size[-len(shape) :] == shape:
            most = max(most, math.prod(size[: -len(shape)]))
    if most >= STORED:
        message = f"The agent holds about {most:,} steps, and its card says stored_steps=0. "
        warnings.warn(f"{message}State them in Card(stored_steps=...).", stacklevel=2)


def warn_of_few_steps(card: Card, taken: int, steps: int) -> None:
    """Warns if an agent that learns, which floors do not, took less than half of the steps of a stage."""
    if taken < steps / 2 and card.algorithm not in FLOORS:
        message = f"learn() took {taken:,} of {steps:,} steps. "
        warnings.warn(f"{message}Take all: boards compare agents at equal budgets.", stacklevel=2)


def _held(owner: Any, depth: int = 3) -> Iterator[Any]:
    """What an object holds: attributes, items of containers, and theirs, but not the parts of a network."""
    if not depth or isinstance(owner, type | ModuleType) or callable(getattr(owner, "parameters", None)):
        return
    values = owner if isinstance(owner, list | tuple | deque) else getattr(owner, "__dict__", {}).values()
    values = owner.values() if isinstance(owner, Mapping) else values
    for value in itertools.islice(values, MOST_HELD):
        yield value
        yield from _held(value, depth - 1)


def checked_card(agent: Agent, name: str) -> Card:
    """The agent's card, checked by the rules of ``submission.toml``.

    Raises ``BenchError`` if scoring would refuse a value, or a package is not installed.
    """
    card = card_of(agent, name)
    if not card.algorithm.strip():
        raise _bad_card("algorithm", "The algorithm has no name.")
    tables = card_tables(card, manifest.Observes())
    tables["protocol"]["budget"] = STANDARD_BUDGET
    for problem in rules.problems("manifest", NO_FOLDER, tables):
        if problem.rule != "no-groups":
            raise _bad_card(problem.where.removeprefix(f"{layout.MANIFEST}, "), problem.message, problem.hint)
    for package in card.packages:
        if package in run.Versions.__struct_fields__:
            raise _bad_card("packages", f"Every run states the version of {package!r}.", "Leave it out.")
        if version_or_none(package) is None:
            hint = "Use the names that pip lists."
            raise _bad_card("packages", f"The package {package!r} is not installed.", hint)
    return card


def card_tables(card: Card, observes: manifest.Observes) -> dict[str, Any]:
    """The sections of ``submission.toml`` that follow from a card, with values as TOML reads them back."""
    parent = {"parent": card.parent} if card.parent else {}
    return {
        "format": manifest.FORMAT,
        "title": card.title or card.algorithm,
        "authors": [],
        "description": card.description,
        "code": {"url": "", "commit": ""},
        "protocol": {"algorithm": card.algorithm, "evaluation": card.evaluation} | parent,
        "hyperparameters": dict(card.hyperparameters),
        "observes": asdict(observes),
        "tuning": {"steps": card.tuning_steps, "tasks": list(card.tuning_tasks)},
    }


def _bad_card(where: str, message: str, hint: str = "See gym_extensions.baselines.Card.") -> BenchError:
    return BenchError("bad-card", message, f"card(): {where}", hint)


def first_actions(agent: Agent, env: VectorEnv, seeds: Sequence[int], label: TaskLabel | None) -> Array:
    """The actions (num_envs, …) of an agent after a reset, clipped to the action space."""
    observations, _ = env.reset(seed=list(seeds))  # type: ignore[arg-type]
    context = Context(np.ones(len(seeds), np.bool_), label)
    return rollout.clip_actions(agents.action_function(agent)(observations, context), env, "act()")


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
    taken, size = actions.reshape(len(actions), -1), observations[0].size
    if policy.num_inputs not in (None, size) or taken.shape[1] != policy.num_actions:
        message = f"The policy has {policy.num_inputs or 'no'} inputs and {policy.num_actions} actions; "
        message += f"an observation has {size} values, and act() gives {taken.shape[1]}."
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
    policy: AnyPolicy, card: Card, observes: manifest.Observes, group: TaskGroup, keys: Iterable[Key] = ()
) -> None:
    """Checks a policy against the rules of submissions before it is stored.

    Raises ``BenchError`` (``bad-policy``) if the policy samples although the card says that evaluation is
    deterministic, if it depends on the task without observing it or has rows for more tasks than the group,
    or if a run with such a policy under all of these keys would exceed the limits of size.
    """
    message, hint = "", "Use arrays without an axis of tasks, or one row per task and task_in_evaluation."
    if card.evaluation == "deterministic" and policy.head != "deterministic":
        message = f"The policy samples (its head is {policy.head!r}), and the card says that it does not."
        hint = 'Return a policy with head="deterministic", or a card with evaluation="sampled".'
    elif policy.num_tasks and not observes.task_in_evaluation:
        message = "The policy depends on the task, and the agent does not ask for task_in_evaluation."
    elif policy.num_tasks > len(group.tasks):
        message = f"The policy has arrays for {policy.num_tasks} tasks; {group.name} has {len(group.tasks)}."
    elif message := size_error(run_arrays(dict.fromkeys(keys, policy))):
        hint = "Use smaller networks or float32, or no policy; without one, a run cannot be verified."
    if message:
        raise BenchError("bad-policy", message, "policy()", hint)


def _extremes(policy: AnyPolicy, observations: Array, task: int) -> tuple[Array, Array]:
    """The lowest and highest actions that a policy samples; for a deterministic one its actions."""
    if isinstance(policy, onnx.OnnxPolicy):
        if policy.head != "deterministic":
            bound = np.full((len(observations), policy.num_actions), np.inf)
            return -bound, bound
        policy.reset()
        actions = policy.act(observations, None, task)
        return actions, actions
    mean, log_sigma = mlp.mean_and_log_sigma(policy, observations, task)
    width = {"deterministic": 0.0, "uniform": 1.0}.get(policy.head, DEVIATIONS * np.exp(log_sigma))
    return mlp.to_action(policy, mean - width), mlp.to_action(policy, mean + width)
