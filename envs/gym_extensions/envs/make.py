"""Makes environments and vector environments of tasks, and registers the published ids with Gymnasium."""

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from functools import partial
from typing import Any

import gymnasium as gym
from gymnasium.envs.registration import EnvSpec
from gymnasium.vector import AutoresetMode, SyncVectorEnv, VectorEnv
from gymnasium.wrappers import HumanRendering

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.tasks import NAMESPACE, TASKS, Task, customize, definition, from_definition
from gym_extensions.catalog.variations import KINDS, Variation
from gym_extensions.envs import foreign, vector_env
from gym_extensions.envs.mujoco.env import MujocoVectorEnv, TaskEnv
from gym_extensions.errors import BenchError, whole_number

VECTOR = ".vector"
"""The end of the names of vector entry points."""


def make(
    task: str | Task,
    variations: Sequence[Variation] = (),
    *,
    render_mode: str | None = None,
    max_steps: int | None = None,
) -> gym.Env[Any, Any]:
    """Returns the environment of a published or custom task, with its time limit.

    Its ``spec`` can be written with ``to_json`` and made again with ``gymnasium.make``, unless the task has
    variations of your own classes or is an environment of another package.

    Args:
        task: an id (``gym_extensions/HopperGravityHalf-v0``), a bare name (``HopperGravityHalf``), or a Task.
        variations: added to the task's own. If the result equals a published task, it is that task.
        render_mode: as in ``gymnasium.make``.
        max_steps: the time limit in environment steps; None keeps the task's.

    Raises:
        BenchError: the task is unknown, the limit is below 1, or a variation does not fit the base body.
    """
    made = customize(task, variations, max_steps=max_steps)
    if made.is_foreign:
        return build(made, render_mode=render_mode)
    spec: str | EnvSpec = made.id
    if TASKS.get(made.id) != made:
        is_data = all(KINDS.get(type(variation).__name__) is type(variation) for variation in made.variations)
        spec = EnvSpec(
            made.id,
            entry_point=f"{__name__}:construct",
            vector_entry_point=f"{__name__}:construct_vec",
            max_episode_steps=made.max_steps,
            kwargs={"task": definition(made) if is_data else made},
        )
    return gym.make(spec, render_mode=render_mode, disable_env_checker=True)


def make_vec(
    tasks: str | Task | Sequence[str | Task] | TaskGroup,
    num_envs: int,
    num_threads: int = 1,
    *,
    autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
) -> VectorEnv[Any, Any, Any]:
    """Returns a vector environment whose numbers are bit for bit those of the single environments.

    MuJoCo environments that share a model layout and rules, as in a gravity or body group, run in one physics
    batch; others run in one batch each, one after the other. ``gymnasium.make_vec`` of a published id returns
    the same.

    An int seed of ``reset`` gives environment i the seed ``seed + i``, and infos are those of the single
    environments, as in Gymnasium's vector environments.

    Args:
        tasks: as in :func:`make`, a list of them, or a group; environment i has ``tasks[i % len(tasks)]``.
        num_envs: number of environments, at least that of the tasks.
        num_threads: threads that step physics. Results do not depend on it. The default is 1, because
            training processes usually run in parallel, one per core.
        autoreset_mode: when an environment whose episode ended is reset, as in ``SyncVectorEnv``.

    Raises:
        BenchError: a task is unknown, no task is given, a count is not a positive integer or too small, the
            mode is unknown, or the tasks have different observation or action spaces.
    """
    several = tasks.tasks if isinstance(tasks, TaskGroup) else tasks
    requested = [several] if isinstance(several, str | Task) else list(several)
    if not requested:
        raise BenchError("no-tasks", "There is no task.", vector_env.WHERE, "Give at least 1.")
    count = whole_number("num_envs", num_envs, "bad-count", vector_env.WHERE)
    threads = whole_number("num_threads", num_threads, "bad-count", vector_env.WHERE)
    try:
        mode = AutoresetMode(autoreset_mode)
    except ValueError:
        hint = f"Choose one of {', '.join(each.value for each in AutoresetMode)}."
        message = f"autoreset_mode is {autoreset_mode!r}."
        raise BenchError("bad-autoreset-mode", message, vector_env.WHERE, hint) from None
    if count < len(requested):
        message = f"There are {len(requested)} tasks for {count} environments."
        raise BenchError("bad-count", message, vector_env.WHERE, "Give at least one environment per task.")
    distinct = [resolve(task) for task in requested]
    copies = [distinct[index % len(distinct)] for index in range(count)]
    families = {task.body.family for task in distinct}
    if families == {"navigation"}:
        from gym_extensions.envs.navigation.env import NavigationVectorEnv

        return NavigationVectorEnv(copies, mode)
    if families & {"gymnasium", "navigation"}:
        with ExitStack() as opened:
            made = [opened.enter_context(make(task)) for task in copies]
            _check_spaces(dict(zip(copies, made, strict=True)))
            opened.pop_all()
        return SyncVectorEnv([partial(lambda env: env, each) for each in made], autoreset_mode=mode)
    singles = {task: TaskEnv(task) for task in distinct}
    _check_spaces(singles)
    return MujocoVectorEnv([singles[task] for task in copies], threads, mode)


def _check_spaces(environments: Mapping[Task, gym.Env[Any, Any]]) -> None:
    (first, reference), *others = environments.items()
    for task, other in others:
        for name in ("observation_space", "action_space"):
            expected, space = getattr(reference, name), getattr(other, name)
            if expected != space:
                message = f"{first.id} has the {name} {expected}, {task.id} has {space}."
                hint = "Give tasks with equal spaces."
                raise BenchError("different-spaces", message, vector_env.WHERE, hint)


def build(task: Task, **rendering: Any) -> gym.Env[Any, Any]:
    """Returns the environment of exactly this task without wrappers, whatever its id.

    ``rendering`` is ``render_mode``, and for MuJoCo bodies Gymnasium's sizes and camera arguments. Any other
    keyword is a ``TypeError``.
    """
    if task.is_foreign:
        return foreign.build(task, **rendering)
    if task.body.family == "navigation":
        from gym_extensions.envs.navigation.env import Navigation

        return Navigation(task, **rendering)
    return TaskEnv(task, **rendering)


def construct(task: str | Task | Mapping[str, Any], **rendering: Any) -> gym.Env[Any, Any]:
    """Returns ``build`` of a task as ``resolve`` takes it; Gymnasium's registry calls it.

    Raises ``BenchError`` if the task or its base body is unknown, or a variation does not fit the body.
    """
    found = resolve(task)
    if found.body.family == "navigation" and rendering.get("render_mode") == "human":
        return HumanRendering(build(found, render_mode="rgb_array"))  # the metadata below are MuJoCo's
    return build(found, **rendering)


def construct_vec(
    task: str | Task | Mapping[str, Any],
    num_envs: int,
    *,
    max_episode_steps: int | None = None,
    num_threads: int = 1,
    autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
    render_mode: str | None = None,
) -> VectorEnv[Any, Any, Any]:
    """Returns ``make_vec`` of one task, as ``gymnasium.make_vec`` calls it.

    Raises:
        BenchError: as in ``make_vec``; or another time limit, or rendering.
    """
    found = resolve(task)
    if max_episode_steps not in (None, found.max_steps):
        message = f"max_episode_steps is {max_episode_steps}; the task has {found.max_steps}."
        hint = "A task's time limit is fixed. For another task use gym_extensions.envs.customize."
        raise BenchError("changed-task", message, found.id, hint)
    if render_mode is not None:
        message = "Environments that are stepped together do not render."
        hint = 'Use vectorization_mode="sync", or make(task, render_mode=...).'
        raise BenchError("no-rendering", message, found.id, hint)
    return make_vec(found, num_envs, num_threads, autoreset_mode=autoreset_mode)


def resolve(task: str | Task | Mapping[str, Any]) -> Task:
    """Returns the task of an id, a bare name, a Task or a definition.

    Raises ``BenchError`` if the task is unknown, or it has a published id and other content.
    """
    if isinstance(task, str):
        return customize(task)
    found = task if isinstance(task, Task) else from_definition(task)
    if TASKS.get(found.id, found) != found:
        message = "The task has the id of a published task and other content."
        raise BenchError("changed-task", message, found.id, "Give it another name.")
    return found


construct.metadata = TaskEnv.metadata  # type: ignore[attr-defined]  # read by gymnasium.make


def __getattr__(name: str) -> Any:
    """The entry points of published tasks, such as ``Hopper-v0`` and ``Hopper-v0.vector``.

    Each id has its own, with the task as a positional argument, so that no keyword makes another task.
    """
    task = TASKS.get(f"{NAMESPACE}/{name.removesuffix(VECTOR)}")
    if task is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    constructor: Any = partial(construct_vec if name.endswith(VECTOR) else construct, task)
    constructor.metadata = TaskEnv.metadata
    return constructor


def register() -> None:
    """Registers each published id once, for ``gymnasium.make`` and ``gymnasium.make_vec``."""
    for task in TASKS.values():
        if task.id not in gym.registry:
            point, limit = f"{__name__}:{task.id.removeprefix(f'{NAMESPACE}/')}", task.max_steps
            gym.register(task.id, point, vector_entry_point=point + VECTOR, max_episode_steps=limit)
