"""make_vec: seeds, ends of episodes, threads and forks, copies, and mistakes."""

import contextlib
import copy
import os
import pickle
import signal
import time
import warnings
from collections.abc import Callable
from functools import partial
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from gym_extensions.catalog.tasks import FAMILIES, customize
from gym_extensions.envs import Wall, make, make_vec as typed_make_vec
from gym_extensions.errors import BenchError

from ..conftest import refused

HOPPERS = ["HopperGravityHalf", "Hopper", "HopperGravityOneAndHalf"]
MAPS = [pattern.format(map=0, goal=0) for pattern in FAMILIES.values()]


def make_vec(*args: Any, **kwargs: Any) -> Any:
    """``make_vec`` without its type: Gymnasium's VectorEnv declares neither ``call`` nor lists of seeds."""
    return typed_make_vec(*args, **kwargs)


def actions(env: Any, steps: int, seed: int = 0) -> Any:
    """Random actions, (steps, num_envs, act), float32."""
    space = env.single_action_space
    drawn = np.random.default_rng(seed).uniform(space.low, space.high, (steps, env.num_envs, *space.shape))
    return drawn.astype(np.float32)


def plain(result: Any) -> Any:
    """A result with its arrays as types and bytes, which ``==`` compares."""
    if isinstance(result, dict):
        return {key: plain(value) for key, value in result.items()}
    if isinstance(result, np.ndarray) and result.dtype == object:
        return [None if value is None else plain(value) for value in result]
    if isinstance(result, tuple):
        return [plain(part) for part in result]
    return np.asarray(result).dtype, np.asarray(result).tobytes()


def play(env: Any, actions: Any) -> list[Any]:
    """Everything that the steps return."""
    return [plain(env.step(row)) for row in actions]


def test_a_seed_in_a_list_starts_its_environment_like_the_single_one() -> None:
    observations, _ = make_vec(HOPPERS, 3).reset(seed=[5, 9, 2**32 + 1])
    singles = [make(name).reset(seed=seed)[0] for name, seed in zip(HOPPERS, (5, 9, 2**32 + 1), strict=True)]
    assert np.array_equal(observations, singles)


@pytest.mark.parametrize("name", ["Walker2d", MAPS[0]])
def test_an_environment_without_a_seed_continues_with_its_generator(name: str) -> None:
    env, single = make_vec(name, 2), make(name)
    env.reset(seed=[3, 4])
    single.reset(seed=4)
    assert np.array_equal(env.reset(seed=[8, None])[0][1], single.reset()[0])
    assert np.array_equal(env.reset()[0][1], single.reset()[0])
    first, second = make_vec(name, 2).reset()[0]
    assert not np.array_equal(first, second)


@pytest.mark.parametrize("mode", list(AutoresetMode))
@pytest.mark.parametrize("name", ["Hopper", "HalfCheetah", "Pusher", MAPS[0], MAPS[4]])
def test_every_autoreset_mode_is_that_of_gymnasiums_vector(name: str, mode: AutoresetMode) -> None:
    tasks = [customize(name, max_steps=limit) for limit in (3, 5, 11)]
    ours = make_vec(tasks, 3, autoreset_mode=mode)
    theirs: Any = SyncVectorEnv([partial(make, task) for task in tasks], autoreset_mode=mode)
    assert ours.autoreset_mode is ours.metadata["autoreset_mode"] is mode
    assert plain(ours.reset(seed=1)) == plain(theirs.reset(seed=1))
    for row in actions(ours, 25):
        result, expected = ours.step(row), theirs.step(row)
        assert result[4].keys() == expected[4].keys()
        assert plain(result) == plain(expected)
        ended = result[2] | result[3]
        if mode is AutoresetMode.DISABLED and ended.any():
            with pytest.raises(gym.error.ResetNeeded):
                ours.step(row)
            mask = {"reset_mask": ended}
            assert plain(ours.reset(options=mask)[0]) == plain(theirs.reset(options=mask)[0])
    made = gym.make_vec(f"gym_extensions/{name}-v0", 2, autoreset_mode=mode)
    assert made.metadata["autoreset_mode"] is mode


@pytest.mark.parametrize("names", [HOPPERS, ["Humanoid"], ["HalfCheetah", "Walker2d"]])
def test_results_do_not_depend_on_the_number_of_threads(names: list[str]) -> None:
    results = []
    for threads in (1, 2, 5):
        env = make_vec(names, 6, num_threads=threads)
        env.reset(seed=2)
        results.append(play(env, actions(env, 60)))
        env.close()
    assert results[0] == results[1] == results[2]


@pytest.mark.parametrize("use", ["step", "reset", "states", "close", "nothing"])
@pytest.mark.parametrize("name", ["Hopper", "Humanoid"])
def test_a_forked_process_ends_and_says_that_threads_are_lost(name: str, use: str) -> None:
    closed = [make_vec(name, 2, num_threads=2) for _ in range(6)]
    for each in closed:
        each.close()
    env = make_vec(name, 4, num_threads=2)
    env.reset(seed=0)
    row = actions(env, 1)[0]
    env.step(row)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Python's own, about forks with threads
        child = os.fork()
    if child == 0:
        status = 1
        try:
            with refused("forked") if use in ("step", "reset") else contextlib.nullcontext():
                if use != "nothing":
                    getattr(env, use)(*([row] if use == "step" else []))
            del env
            status = 0
        finally:
            os._exit(status)
    deadline = time.monotonic() + 20
    while (ended := os.waitpid(child, os.WNOHANG)) == (0, 0):
        if time.monotonic() > deadline:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            pytest.fail("the child hangs")
        time.sleep(0.01)
    assert ended[1] == 0
    env.step(row)
    env.close()


@pytest.mark.parametrize("name", ["Hopper", MAPS[0]])
def test_a_reset_mask_resets_only_its_environments(name: str) -> None:
    env, twin = make_vec(name, 3), make_vec(name, 3)
    for each in (env, twin):
        each.reset(seed=0)
        for row in actions(each, 5):
            before = each.step(row)[0]
    observations, _ = env.reset(seed=[9, 9, 9], options={"reset_mask": np.array([False, True, False])})
    assert np.array_equal(observations[[0, 2]], before[[0, 2]])
    assert np.array_equal(observations[1], make(name).reset(seed=9)[0])
    row = actions(env, 1, seed=1)[0]
    assert np.array_equal(env.step(row)[0][[0, 2]], twin.step(row)[0][[0, 2]])


def test_states_are_copies_of_the_coordinates_of_the_simulations() -> None:
    env, single = make_vec(["HopperWall", "HopperWithSensor"], 2), make("HopperWithSensor").unwrapped
    env.reset(seed=4)
    single.reset(seed=5)
    states = env.states()
    assert np.array_equal(states["qpos"][1], single.data.qpos)  # type: ignore[attr-defined]
    assert np.array_equal(states["mocap_pos"][1], single.data.mocap_pos)  # type: ignore[attr-defined]
    states["qpos"][:] = 0
    assert env.states()["qpos"].any()
    mixed = make_vec(["Hopper", customize("Hopper", [Wall()])], 2)
    mixed.reset(seed=0)
    assert np.isnan(mixed.states()["mocap_pos"]).all(axis=(1, 2)).tolist() == [True, False]


WAYS: dict[str, Callable[[Any], Any]] = {
    "deepcopy": copy.deepcopy,
    "pickle": lambda env: pickle.loads(pickle.dumps(env)),  # noqa: S301
}
COPIED = ["HopperNoisyWall", "HalfCheetahMotorNoise", "Humanoid", "HumanoidStandupAndRunWall"]
COPIED += ["PusherTrackingGoal", "StrikerTrackingGoal", *MAPS]


@pytest.mark.parametrize("name", COPIED)
def test_copies_continue_exactly(name: str) -> None:
    single: Any = make(name)
    single.reset(seed=0)
    space = single.action_space
    drawn = np.random.default_rng(0).uniform(space.low, space.high, (12, *space.shape)).astype(np.float32)
    play(single, drawn[:6])
    copies = [way(single) for way in WAYS.values()]
    results = [
        [*play(each, drawn[6:]), plain(each.reset()), plain(each.reset())] for each in (single, *copies)
    ]
    assert all(result == results[0] for result in results)


@pytest.mark.parametrize("way", WAYS)
def test_mujoco_vector_environments_are_not_copied(way: str) -> None:
    with pytest.raises(BenchError, match="reset them with the same seeds"):
        WAYS[way](make_vec("Hopper", 2))


@pytest.mark.parametrize("name", ["Hopper", "Humanoid", MAPS[0]])
def test_a_reset_comes_first_and_nothing_after_close(name: str) -> None:
    env = make_vec(name, 2)
    uses: list[Callable[[], object]] = [
        lambda: env.step(np.zeros(env.action_space.shape, np.float32)),
        env.states,
        lambda: env.reset(options={"reset_mask": np.array([True, False])}),
    ]
    for use in uses:
        with pytest.raises(gym.error.ResetNeeded) as caught:
            use()
        assert isinstance(caught.value, BenchError)
    env.reset(seed=0)
    for use in uses:
        use()
    env.close()
    env.close()
    for use in (*uses, env.reset):
        with pytest.raises(gym.error.ClosedEnvironmentError) as closed:
            use()
        assert isinstance(closed.value, BenchError)


def after_reset() -> Any:
    """A vector environment after its reset."""
    env = make_vec("Hopper", 2)
    env.reset(seed=0)
    return env


MISTAKES: list[tuple[Callable[[], object], str, str]] = [
    (lambda: make_vec("Hoper", 2), "unknown-task", "Did you mean 'Hopper'?"),
    (lambda: make_vec([], 2), "no-tasks", "Give at least 1."),
    *(
        (lambda count=count: make_vec("Hopper", count), "bad-count", f"num_envs is {count!r}")
        for count in (0, "3", 2.0, True)
    ),
    (lambda: make_vec(["Hopper", "HopperWall"], 1), "bad-count", "2 tasks for 1 environments"),
    (lambda: make_vec("Hopper", 1, num_threads=-1), "bad-count", "num_threads is -1"),
    (lambda: make_vec("Hopper", 1, autoreset_mode="never"), "bad-autoreset-mode", "SameStep"),
    (lambda: make_vec(["Hopper", "Walker2d"], 2), "different-spaces", "(17,)"),
    (lambda: make_vec(["Pusher", MAPS[0]], 2), "different-spaces", "observation_space"),
    (lambda: make_vec([MAPS[0], MAPS[4]], 2), "different-spaces", "image, state"),
    (lambda: make_vec("Hopper", 2).reset(seed=[1, 2, 3]), "bad-seeds", "a list of 2"),
    (lambda: make_vec("Hopper", 2).reset(seed=1.5), "bad-seeds", "1.5"),
    (lambda: make_vec("Hopper", 2).reset(seed=[0, -1]), "bad-seeds", "-1"),
    (lambda: make_vec("Hopper", 2).reset(seed=[True, 2]), "bad-seeds", "True"),
    (lambda: after_reset().reset(options={"reset_mask": np.zeros(2, bool)}), "bad-reset-mask", "2 booleans"),
    (lambda: make_vec("Hopper", 2).call("fly"), "unknown-call", "no 'fly'"),
    (lambda: after_reset().step(np.zeros((2, 4))), "bad-action", "of the shape (2, 3)"),
    (lambda: after_reset().step(np.array([[0, 0, 0], [0, np.nan, 0]])), "bad-action", "action[1, 1] is nan"),
]


@pytest.mark.parametrize(("mistake", "code", "fact"), MISTAKES)
def test_a_mistake_is_named(mistake: Callable[[], object], code: str, fact: str) -> None:
    with refused(code, fact):
        mistake()


@pytest.mark.parametrize("name", ["Hopper", MAPS[0]])
def test_reset_seeds_the_generator_for_own_draws_which_environments_do_not_use(name: str) -> None:
    env, twin = make_vec(name, 2), make_vec(name, 2)
    env.reset(seed=3)
    twin.reset(seed=[3, 4])
    draws = env.np_random.random(5)
    assert env.np_random_seed == 3
    assert np.array_equal(draws, twin.np_random.random(5))
    twin.reset(seed=[3, 4])
    assert play(env, actions(env, 5)) == play(twin, actions(env, 5))
    assert plain(env.reset()) == plain(twin.reset())


def test_observations_of_earlier_steps_do_not_change() -> None:
    env = make_vec("Humanoid", 2)
    first, _ = env.reset(seed=0)
    kept = first.copy()
    second = env.step(actions(env, 1)[0])[0]
    assert np.array_equal(first, kept)
    assert not np.array_equal(first, second)
