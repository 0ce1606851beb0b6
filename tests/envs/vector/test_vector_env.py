"""make_vec: seeds, ends of episodes, states, and what it refuses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from gym_extensions.catalog.registry import task
from gym_extensions.envs import make, make_vec
from gym_extensions.envs.seeding import spawn_seeds
from gym_extensions.errors import BenchError

HOPPERS = ["HopperGravityHalf", "Hopper", "HopperGravityOneAndHalf"]


def actions(env: Any, steps: int, seed: int = 0) -> Any:
    """Random actions, (steps, lanes, act), float32."""
    space = env.single_action_space
    drawn = np.random.default_rng(seed).uniform(space.low, space.high, (steps, env.num_envs, *space.shape))
    return drawn.astype(np.float32)


def played(env: Any, given: Any) -> list[Any]:
    """Everything that the steps gave, as arrays."""
    return [np.concatenate([np.ravel(part) for part in env.step(row)[:4]]) for row in given]


def test_lane_i_holds_task_i_modulo_the_number_of_tasks() -> None:
    held = make_vec(HOPPERS, 5).call("task")
    assert [row.name for row in held] == [*HOPPERS, *HOPPERS[:2]]


def test_the_batch_says_how_it_resets_and_what_its_spaces_are() -> None:
    env = make_vec(HOPPERS, 4)
    assert env.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
    assert env.observation_space.shape == (4, 11)
    assert env.action_space.shape == (4, 3)
    observations, infos = env.reset(seed=1)
    assert env.observation_space.contains(observations)
    assert infos == {} == env.step(actions(env, 1)[0])[4]


def test_an_int_seed_is_spawned_so_that_neighbouring_seeds_share_no_lane() -> None:
    assert not set(spawn_seeds(7, 100)) & set(spawn_seeds(8, 100))
    env = make_vec("Hopper", 3)
    spawned, _ = env.reset(seed=7)
    listed, _ = env.reset(seed=spawn_seeds(7, 3))
    assert np.array_equal(spawned, listed)
    assert env.call("np_random_seed") == tuple(spawn_seeds(7, 3))


def test_a_listed_seed_starts_its_lane_as_the_single_environment_does() -> None:
    observations, _ = make_vec(HOPPERS, 3).reset(seed=[5, 9, 2**32 + 1])
    singles = [make(name).reset(seed=seed)[0] for name, seed in zip(HOPPERS, (5, 9, 2**32 + 1), strict=True)]
    assert np.array_equal(observations, singles)


def test_a_lane_without_a_seed_goes_on_with_its_generator() -> None:
    env, single = make_vec("Walker2d", 2), make("Walker2d")
    env.reset(seed=[3, 4])
    single.reset(seed=4)
    assert np.array_equal(env.reset(seed=[8, None])[0][1], single.reset()[0])
    assert np.array_equal(env.reset()[0][1], single.reset()[0])


def test_a_batch_that_was_never_seeded_draws_lanes_apart() -> None:
    first, second = make_vec("Hopper", 2).reset()[0]
    assert not np.array_equal(first, second)


@pytest.mark.parametrize("names", [HOPPERS, ["Humanoid"], ["HalfCheetah", "Walker2d"]])
def test_results_do_not_depend_on_the_number_of_threads(names: list[str]) -> None:
    results = []
    for threads in (1, 2, 5):
        env = make_vec(names, 6, num_threads=threads)
        env.reset(seed=2)
        results.append(played(env, actions(env, 60)))
        env.close()
    assert np.array_equal(results[0], results[1])
    assert np.array_equal(results[0], results[2])


def test_lanes_of_different_layouts_run_side_by_side_where_spaces_are_the_same() -> None:
    names = ["HalfCheetah", "Walker2dGravityHalf", "Walker2d"]
    mixed = make_vec(names, 6)
    apart = {name: make_vec(name, 2) for name in names}
    mixed.reset(seed=[1, 2, 3, 4, 5, 6])
    for lane, name in enumerate(names):
        apart[name].reset(seed=[lane + 1, lane + 4])
    for row in actions(mixed, 120):
        together = mixed.step(row)[:4]
        for lane, name in enumerate(names):
            alone = apart[name].step(row[lane::3])[:4]
            assert all(np.array_equal(a[lane::3], b) for a, b in zip(together, alone, strict=True))


def test_an_episode_is_cut_off_at_its_own_limit_and_starts_again_in_the_step_after() -> None:
    rows = [replace(task("HalfCheetah"), name="HalfCheetahShort", max_steps=limit) for limit in (3, 5)]
    env = make_vec(rows, 2)
    env.reset(seed=0)
    cuts, rewards = [], []
    for row in actions(env, 9):
        _, reward, terminated, truncated, _ = env.step(row)
        assert not terminated.any()
        cuts.append(truncated.tolist())
        rewards.append((reward == 0).tolist())
    assert [step for step, (first, _) in enumerate(cuts, 1) if first] == [3, 7]
    assert [step for step, (_, second) in enumerate(cuts, 1) if second] == [5]
    assert [step for step, (first, _) in enumerate(rewards, 1) if first] == [4, 8]
    assert [step for step, (_, second) in enumerate(rewards, 1) if second] == [6]


def test_observations_of_earlier_steps_stay_as_they_were() -> None:
    env = make_vec("Humanoid", 2)
    first, _ = env.reset(seed=0)
    kept = first.copy()
    second = env.step(actions(env, 1)[0])[0]
    assert np.array_equal(first, kept)
    assert not np.array_equal(first, second)


def test_a_reset_mask_restarts_its_lanes_alone() -> None:
    env, twin = make_vec("Hopper", 3), make_vec("Hopper", 3)
    for one in (env, twin):
        one.reset(seed=0)
        for row in actions(one, 5):
            before = one.step(row)[0]
    observations, _ = env.reset(seed=[9, 9, 9], options={"reset_mask": np.array([False, True, False])})
    assert np.array_equal(observations[[0, 2]], before[[0, 2]])
    assert np.array_equal(observations[1], make("Hopper").reset(seed=9)[0])
    row = actions(env, 1, seed=1)[0]
    assert np.array_equal(env.step(row)[0][[0, 2]], twin.step(row)[0][[0, 2]])


def test_states_come_as_arrays_over_lanes_or_lane_by_lane() -> None:
    env = make_vec("Humanoid", 3)
    env.reset(seed=0)
    env.step(actions(env, 1)[0])
    arrays, rows = env.save_states(), env.call("save_state")
    assert set(arrays) == {"qpos", "qvel", "qacc_warmstart", "time", "derived_xipos"}
    assert arrays["qpos"].shape == (3, 24)
    assert all(np.array_equal(arrays[name][lane], rows[lane][name]) for name in arrays for lane in range(3))
    assert all(value.dtype == np.float64 for value in rows[0].values())


CARRYING = ["Hopper", "HalfCheetahNoisyWall", "HumanoidMotorNoise", "HumanoidStandupAndRunWall"]


@pytest.mark.parametrize("name", [*CARRYING, "Pusher", "PusherTrackingGoal", "StrikerTrackingGoal"])
def test_a_restored_lane_goes_on_bit_for_bit_in_any_lane(name: str) -> None:
    env, other = make_vec(name, 3), make_vec(name, 4)
    env.reset(seed=0)
    other.reset(seed=1)
    given = actions(env, 12)
    for row in given[:8]:
        env.step(row)
    states = env.save_states()
    other.restore_states({key: rows[[2, 0]] for key, rows in states.items()}, indices=[1, 3])
    for row in given[8:]:
        wide = np.zeros((4, row.shape[1]), np.float32)
        wide[[1, 3]] = row[[2, 0]]
        for mine, theirs in zip(other.step(wide)[:3], env.step(row)[:3], strict=True):
            assert np.array_equal(mine[[1, 3]], theirs[[2, 0]])


def test_a_state_of_the_batch_goes_on_in_the_single_environment() -> None:
    env, single = make_vec("Humanoid", 2), make("Humanoid")
    env.reset(seed=0)
    single.reset(seed=5)
    given = actions(env, 6)
    for row in given[:3]:
        env.step(row)
    single.unwrapped.restore_state(env.call("save_state")[1])  # type: ignore[attr-defined]
    for row in given[3:]:
        batched, alone = env.step(row), single.step(row[1])
        assert np.array_equal(batched[0][1], alone[0])
        assert batched[1][1] == alone[1]


def restored(change: Callable[[dict[str, Any]], object]) -> None:
    """Puts a state back that was tampered with."""
    env: Any = make_vec("Hopper", 2)
    env.reset(seed=0)
    states = env.save_states()
    change(states)
    env.restore_states(states)


REFUSED: list[tuple[Callable[[], object], str]] = [
    (
        lambda: make_vec("Hoper", 2),
        "There is no task 'Hoper'. Did you mean 'Hopper'?",
    ),
    (lambda: make_vec([], 2), "make_vec: tasks is 0. Give at least 1."),
    (lambda: make_vec("Hopper", 0), "make_vec: num_envs is 0. Give at least 1."),
    (lambda: make_vec("Hopper", 1, num_threads=-1), "make_vec: num_threads is -1. Give at least 1."),
    (
        lambda: make_vec(["Hopper", "Walker2d"], 2),
        "make_vec: gym_extensions/Hopper-v0 has the observation_space Box(-inf, inf, (11,), float64), "
        "gym_extensions/Walker2d-v0 has Box(-inf, inf, (17,), float64). Give tasks that share their spaces.",
    ),
    (
        lambda: make_vec(["Pusher", "State-Based-Navigation-2d-Map0-Goal0"], 2),
        "make_vec: gym_extensions/Pusher-v0 has the observation_space Box(-inf, inf, (23,), float64), "
        "gym_extensions/State-Based-Navigation-2d-Map0-Goal0-v0 has "
        f"{make('State-Based-Navigation-2d-Map0-Goal0').observation_space}. "
        "Give tasks that share their spaces.",
    ),
    (
        lambda: make_vec("Hopper", 2).reset(seed=[1, 2, 3]),
        "make_vec: There are 3 seeds for 2 lanes. Give one seed a lane, or one int for all.",
    ),
    (
        lambda: make_vec("Hopper", 2).reset(options={"reset_mask": np.array([False, False])}),
        "make_vec: reset_mask is array([False, False]). Give 2 booleans, at least one of them true.",
    ),
    (
        lambda: make_vec("Hopper", 2).call("fly"),
        "make_vec: Lanes do not answer 'fly'. They answer save_state, task, np_random, np_random_seed, "
        "without arguments.",
    ),
    (lambda: restored(lambda states: states.pop("qvel")), "make_vec: The states lack 'qvel'."),
    (
        lambda: restored(lambda states: states.update(wind=np.zeros(2))),
        "make_vec: The states hold an unknown 'wind'.",
    ),
    (
        lambda: restored(lambda states: states.update(qpos=np.zeros((2, 7)))),
        "make_vec: The states' 'qpos' has shape (2, 7), not (lanes, 6).",
    ),
    (
        lambda: restored(lambda states: states.update(qpos=np.full((2, 6), np.inf))),
        "make_vec: The states' 'qpos' holds a value that is not finite.",
    ),
    (
        lambda: make_vec("Hopper", 2).step(np.zeros((2, 4), np.float32)),
        "make_vec: The action has shape (2, 4), not (2, 3). Give one number per actuator.",
    ),
    (
        lambda: make_vec("Hopper", 2).step(np.array([[0, 0, 0], [0, np.nan, 0]], np.float32)),
        "make_vec: action[1, 1] is nan. Give finite numbers.",
    ),
]


@pytest.mark.parametrize(("mistake", "said"), REFUSED, ids=[said for _, said in REFUSED])
def test_a_mistake_is_answered_by_what_was_given_and_what_is_allowed(
    mistake: Callable[[], object], said: str
) -> None:
    with pytest.raises(BenchError) as refused:
        mistake()
    assert str(refused.value) == said
