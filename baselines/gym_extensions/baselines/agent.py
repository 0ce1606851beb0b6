"""What an agent is: its methods, what it observes, and its card. No simulator is needed to write one."""

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode
from msgspec.structs import astuple
from numpy.typing import NDArray

from gym_extensions.errors import BenchError
from gym_extensions.files import remove
from gym_extensions.submissions.manifest import Observes
from gym_extensions.submissions.policies.files import AnyPolicy

EXCESS = 0.02
"""Fraction of the budget by which an agent's last batch may exceed it."""
NEEDS = {
    **dict.fromkeys(("task_ids", "env_task_ids", "env_tasks"), "task_in_training"),
    **dict.fromkeys(("stage", "num_tasks"), "boundaries"),
}
"""Attributes of the environment that an agent has to ask for, with the field of ``Observes``."""


class NotRequestedError(BenchError, AttributeError):
    """An agent reads what it did not ask for: ``hasattr`` is False and ``getattr`` returns its default."""


def not_requested(name: str, field_name: str) -> NotRequestedError:
    """The error of an attribute that needs a field of ``Observes`` that is not set."""
    message = f"The agent did not ask for it in its attribute observes.{field_name}."
    hint = f"Give the agent's class the attribute observes = Observes({field_name}=True)."
    return NotRequestedError("not-requested", message, name, hint)


@dataclass(frozen=True)
class TaskLabel:
    """A task's id and its index in the training order of its group."""

    id: str
    index: int


@dataclass(frozen=True)
class Context:
    """What the method ``act(observations, context)`` of an agent is given in evaluation.

    Args:
        episode_starts: (num_envs,) booleans, True where the observation is the first one of an episode. All
            are True in the first call of an evaluation.
        label: the evaluated task; None unless the agent asked for it.

    Example:
        >>> context = Context(np.array([True, False]), TaskLabel("gym_extensions/Hopper-v0", 2))
        >>> context.task_id, context.task
        ('gym_extensions/Hopper-v0', 2)
    """

    episode_starts: NDArray[np.bool_]
    label: TaskLabel | None = field(default=None, repr=False)

    @property
    def task_id(self) -> str:
        """The id of the evaluated task. Raises ``BenchError`` unless the agent asked for it."""
        return self._label("task_id").id

    @property
    def task(self) -> int:
        """The task's index in the training order of its group; raises as ``task_id`` does."""
        return self._label("task").index

    def _label(self, name: str) -> TaskLabel:
        if self.label is None:
            raise not_requested(f"context.{name}", "task_in_evaluation")
        return self.label


Array = NDArray[Any]
VectorEnv = gym.vector.VectorEnv[Any, Any, Any]
Setting = str | int | float | bool | Sequence[str | int | float | bool]
"""A hyperparameter as ``submission.toml`` stores it."""


class Agent(Protocol):
    """A learning algorithm. :class:`Resumable`, :class:`Described` and a method ``policy()`` are optional.

    ``policy()`` returns the policy, which acts as ``act`` does, as plain arrays
    (:class:`gym_extensions.policies.Policy`) or as a network (``OnnxPolicy``); None without one. It is
    stored after every stage and published in the submission.

    An agent that observes more than observations and rewards has an attribute ``observes``, an
    ``Observes``. What it does not ask for there is refused. An agent that needs another autoreset mode than
    NEXT_STEP has an attribute ``autoreset_mode``, a ``gymnasium.vector.AutoresetMode``.

    An agent that samples should use separate random generators for acting and learning, so that evaluation
    does not change what is learned.

    Example:
        >>> class Constant:
        ...     def __init__(self, observation_space, action_space, seed):
        ...         self.action = action_space.high
        ...
        ...     def act(self, observations):
        ...         return np.tile(self.action, (len(observations), 1))
        ...
        ...     def learn(self, env, steps):
        ...         pass
    """

    def act(self, observations: Array, *args: Any, **kwargs: Any) -> Array:
        """Chooses one action per environment. It must not change what the agent has learned.

        An agent defines ``act(observations)`` or ``act(observations, context)``. The second form receives a
        :class:`Context` in each call, by the name of the parameter.

        Args:
            observations: (num_envs, …).
            *args: the context, if the agent's ``act`` has a parameter of this name.

        Returns:
            Actions (num_envs, …). Actions outside the action space are clipped.
        """

    def learn(self, env: VectorEnv, steps: int) -> object:
        """Continues training from the current policy.

        Args:
            env: a Gymnasium vector environment in the agent's ``autoreset_mode``. In NEXT_STEP, the default,
                the step after the end of an episode resets that environment, ignores its action and is not a
                transition.
                ``env.batch_steps`` is the batch size of the reference agents; other agents may ignore it.
                ``env.budget_steps`` equals ``steps``. Agents that ask for ``task_in_training`` can read
                ``env.task_ids`` (the tasks that are trained, in order), ``env.env_task_ids`` (one per
                environment) and ``env.env_tasks``, their indices in the training order of the group. Agents
                that ask for ``boundaries`` can read ``env.stage``, from 1, and ``env.num_tasks``.
            steps: transitions to take, summed over all environments; at most 2 % more are allowed.
        """


@runtime_checkable
class Resumable(Protocol):
    """An agent that can be checkpointed, so an interrupted run resumes after its last finished stage.

    A checkpoint holds the whole agent, random generators included.
    """

    def save(self, path: Path) -> object:
        """Writes the agent to ``path``, which becomes a file or a folder, as arrays without pickle."""

    def load(self, path: Path) -> object:
        """Restores the agent that was saved to ``path``: itself, or, as a class method, a new one.

        A new agent is returned; an agent that restores itself returns itself or None.
        """


@dataclass(frozen=True)
class Card:
    """What a submission's manifest says about its agent.

    Args:
        algorithm: a short name of at most 100 characters.
        title: the heading of the submission; ``algorithm`` if empty.
        description: at most 4000 characters.
        evaluation: how the agent acts in evaluation, ``"sampled"`` or ``"deterministic"``.
        hyperparameters: strings, finite numbers, booleans, or lists of them, by name.
        tuning_steps: training steps spent on choosing the hyperparameters, over all trials.
        tuning_tasks: the tasks of these trials, in your words, such as ``"Hopper at 0.9 gravity"``: they may
            be others than those of this benchmark.
        stored_steps: the largest number of transitions that the agent stores.
        parameters: the number of the agent's trained parameters.
        packages: names of the packages, besides Gymnasium, MuJoCo and NumPy, on which the results depend,
            such as ``"torch"``. The manifest states their versions.
        parent: the algorithm to which the agent is equal until the end of the first stage; empty if none.

    Example:
        >>> Card("hill climbing", evaluation="deterministic", parameters=33).algorithm
        'hill climbing'
    """

    algorithm: str
    title: str = ""
    description: str = ""
    evaluation: str = "sampled"
    hyperparameters: Mapping[str, Setting] = field(default_factory=dict)
    tuning_steps: int = 0
    tuning_tasks: tuple[str, ...] = ()
    stored_steps: int = 0
    parameters: int = 0
    packages: tuple[str, ...] = ()
    parent: str = ""

    def __post_init__(self) -> None:
        def plain(value: Any) -> Any:
            """Numbers of numpy, such as ``np.prod`` of a shape, are numbers."""
            if isinstance(value, list | tuple):
                return [plain(each) for each in value]
            return value.item() if isinstance(value, np.generic) else value

        for name in ("tuning_steps", "stored_steps", "parameters"):
            object.__setattr__(self, name, plain(getattr(self, name)))
        if isinstance(self.hyperparameters, Mapping):
            settings = {key: plain(value) for key, value in self.hyperparameters.items()}
            object.__setattr__(self, "hyperparameters", settings)


@runtime_checkable
class Described(Protocol):
    """An agent that describes itself in the manifest."""

    def card(self) -> Card:
        """The description of the agent in its current state."""


class Factory(Protocol):
    """Creates untrained agents.

    An agent's class is a factory, and so is any function with these three arguments.
    """

    def __call__(self, observation_space: Any, action_space: Any, seed: int, /) -> Agent:
        """Creates an untrained agent.

        The spaces are the Gymnasium spaces of one environment. ``seed`` is the source of all the agent's
        randomness.
        """


VARIADIC = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
METHODS = {"act": "act(observations)", "learn": "learn(env, steps)"}
"""The required methods of an agent and their signatures."""
SB3_MODULES = ("stable_baselines3.", "sb3_contrib.", "sbx.")
ARGUMENTS = "(observation_space, action_space, seed)"


def create(make: Factory, spaces: tuple[gym.Space[Any], gym.Space[Any]], seed: int, name: str) -> Agent:
    """Creates an agent and checks that the factory and the agent fit the training loop.

    Raises ``BenchError`` if ``make`` cannot be called as a factory, a method is missing or has other
    arguments, ``card`` is not a method, or ``observes`` is not valid. It names ``name``.
    """
    require_factory(make, name)
    agent = make(*spaces, seed)
    for method, signature in METHODS.items():
        if not callable(getattr(agent, method, None)):
            message = f"The agent, of type {type(agent).__name__}, has no method {method}()."
            hint = f"Add a method {signature}; docs/agents.md has an example."
            raise BenchError("bad-agent", message, name, hint)
    card: object = getattr(agent, "card", None)
    if card is not None and not callable(card):
        message = f"card is an attribute of type {type(card).__name__}, not a method."
        raise BenchError("bad-agent", message, name, "Write a method: def card(self): return Card(...).")
    check_context(agent, name)
    return agent


def require_factory(make: object, name: str) -> None:
    """Raises ``BenchError`` if ``make`` cannot be called as a factory of agents."""
    if not callable(make):
        message = f"Expected a factory of agents, got a value of type {type(make).__name__}."
        hint = f"Pass an agent's name, or a class or function with the arguments {ARGUMENTS}."
        raise BenchError("bad-agent", message, name, hint)
    if isinstance(make, type) and make.__module__.startswith(SB3_MODULES):
        message = f"{make.__name__} is an algorithm of Stable-Baselines3, not an agent."
        raise BenchError("bad-agent", message, name, f"Pass sb3({make.__name__}).")
    try:
        inspect.signature(make).bind(None, None, 0)
    except TypeError as mismatch:
        message = f"The factory cannot be called with {ARGUMENTS}: {mismatch}."
        raise BenchError("bad-agent", message, name, "Give it these three arguments.") from mismatch


def observes_of(agent: Agent, name: str) -> Observes:
    """What the agent asks for in its attribute ``observes``; nothing if it has none.

    Raises ``BenchError`` if the attribute is not an ``Observes`` of booleans.
    """
    observes: object = getattr(agent, "observes", Observes())
    if not isinstance(observes, Observes) or not all(isinstance(each, bool) for each in astuple(observes)):
        message = f"The agent's attribute observes is {observes!r}."
        hint = "Use a gym_extensions.baselines.Observes, with True or False."
        raise BenchError("bad-agent", message, name, hint)
    return observes


def autoreset_mode_of(agent: Agent, name: str) -> AutoresetMode:
    """The agent's ``autoreset_mode``, by default NEXT_STEP. Raises ``BenchError`` for another value."""
    mode: object = getattr(agent, "autoreset_mode", AutoresetMode.NEXT_STEP)
    try:
        return AutoresetMode(mode)
    except ValueError:
        hint = "Use a gymnasium.vector.AutoresetMode."
        message = f"The agent's attribute autoreset_mode is {mode!r}."
        raise BenchError("bad-agent", message, name, hint) from None


def save(agent: Resumable, path: Path) -> None:
    """Saves an agent to a path at which nothing stays of an earlier attempt.

    Raises ``BenchError`` if it writes neither a file nor a folder there.
    """
    remove(path)
    agent.save(path)
    if not path.exists():
        message = f"save() did not write the file or folder that it was given, {path.name}."
        hint = "Write to this name as it is; numpy.save appends .npy, numpy.savez does not."
        raise BenchError("bad-agent", message, "save()", hint)


def load(agent: Resumable, path: Path) -> Agent:
    """The agent that was saved to a path: ``agent`` itself, or the one that its ``load`` returns.

    Raises ``BenchError`` if there is no checkpoint, ``load`` raises, or it returns something else.
    """
    hint = "Correct load(); or, of an interrupted run, delete the folder to start it again."
    if not path.exists():
        raise BenchError("bad-checkpoint", "The agent's checkpoint is missing.", str(path), hint)
    try:
        returned = agent.load(path)
    except BenchError:  # of an agent in a box, which says more
        raise
    except Exception as error:
        message = f"The agent cannot load its checkpoint: {type(error).__name__}: {error}".rstrip(" .:")
        raise BenchError("bad-checkpoint", f"{message}.", str(path), hint) from error
    restored: Any = agent if returned is None else returned
    if not all(callable(getattr(restored, method, None)) for method in METHODS):
        message = f"load() returned a value of type {type(returned).__name__}."
        raise BenchError("bad-agent", message, "load()", "Return the restored agent, or None.")
    return restored


def check_context(agent: Agent, name: str) -> None:
    """Checks that the agent can receive what it asks for.

    Raises ``BenchError`` if ``observes`` is not valid, ``act`` requires another argument than the context, or
    the agent asks for the task in evaluation and ``act`` has no parameter ``context``.
    """
    parameters, message = inspect.signature(agent.act).parameters, ""
    for parameter in list(parameters.values())[1:]:
        is_optional = parameter.default is not parameter.empty or parameter.kind in VARIADIC
        if not is_optional and parameter.name != "context":
            message = f"act() requires the argument {parameter.name!r}."
    if observes_of(agent, name).task_in_evaluation and "context" not in parameters:
        message = "The agent asks for task_in_evaluation, but act() does not receive the context."
    if message:
        hint = "Use act(observations) or act(observations, context)."
        raise BenchError("bad-agent", message, name, hint)


def action_function(agent: Agent) -> Callable[[Array, Context], Array]:
    """The agent's ``act`` as a function of observations and context; it may have no parameter ``context``."""
    if "context" in inspect.signature(agent.act).parameters:
        return lambda observations, context: agent.act(observations, context=context)
    return lambda observations, _: agent.act(observations)


def policy_of(agent: Agent) -> AnyPolicy | None:
    """The agent's policy; None if it has no method ``policy`` or cannot express its policy.

    An attribute ``policy`` that is not a method, such as a torch module, or a method with arguments is
    something else.

    Raises ``BenchError`` if the method returns neither a policy nor None.
    """
    method = getattr(agent, "policy", None)
    if not inspect.isroutine(method):
        return None
    parameters = inspect.signature(method).parameters.values()
    if any(each.default is each.empty and each.kind not in VARIADIC for each in parameters):
        return None
    policy: object = method()
    if policy is None or isinstance(policy, AnyPolicy):
        return policy
    message = f"Expected a Policy, an OnnxPolicy or None, got a value of type {type(policy).__name__}."
    raise BenchError("bad-policy", message, "policy()", "Return a gym_extensions.policies.Policy.")
