"""What holds for every group: vector environments agree, tasks differ, spaces hold what occurs."""

from __future__ import annotations

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv

from gym_extensions.catalog.groups import GROUPS, PAPER_GROUPS
from gym_extensions.catalog.registry import TASKS, task
from gym_extensions.envs import TaskId, VectorTaskId, group, make, make_vec
from gym_extensions.errors import BenchError

BODY_GROUPS = [name for name, row in GROUPS.items() if row.tasks[0].base != "Navigation"]
VARIED = [row.id for row in TASKS.values() if row.base != "Navigation" and row.variations]
RUNNING = ("hopper", "walker2d", "halfcheetah", "humanoid")
PAPER = [
    *(f"{body}-{kind}" for kind in ("gravity", "body", "wall") for body in RUNNING),
    *("humanoid-standup-run", "humanoid-standup-run-wall", "striker", "pusher"),
]
EXTRAS = [
    *(f"{body}-{kind}" for kind in ("motor-noise", "noisy-wall") for body in RUNNING),
    *("pusher-tracking", "striker-tracking"),
]


def test_there_are_75_body_tasks_in_the_papers_16_groups_and_12_extras() -> None:
    assert [row.name for row in PAPER_GROUPS][:16] == PAPER
    assert len({row.id for name in PAPER for row in GROUPS[name].tasks}) == 75
    assert [name for name in BODY_GROUPS if name not in PAPER] == EXTRAS
    assert len([row for row in TASKS.values() if row.base != "Navigation"]) == 87


def test_groups_hold_the_papers_tasks_in_the_papers_order() -> None:
    names = {name: [row.name for row in GROUPS[name].tasks] for name in BODY_GROUPS}
    assert names["walker2d-body"] == [
        *("Walker2dSmallFoot", "Walker2dSmallLeg", "Walker2dSmallThigh", "Walker2dSmallTorso"),
        *("Walker2dBigFoot", "Walker2dBigLeg", "Walker2dBigThigh", "Walker2dBigTorso"),
    ]
    assert names["humanoid-body"][8:] == [
        *("HumanoidSmallHead", "HumanoidBigHead", "HumanoidSmallArm"),
        *("HumanoidBigArm", "HumanoidSmallHand", "HumanoidBigHand"),
    ]
    assert names["humanoid-wall"] == ["HumanoidWithSensor", "HumanoidWall"]
    assert names["humanoid-standup-run"] == ["Humanoid", "HumanoidStandup", "HumanoidStandupAndRun"]
    assert names["humanoid-standup-run-wall"] == [
        *("HumanoidWithSensor", "HumanoidStandupWithSensor"),
        *("HumanoidStandupAndRunWithSensor", "HumanoidStandupAndRunWall"),
    ]
    assert names["striker"] == ["Striker", "StrikerMovingStart"]
    assert names["pusher"] == ["Pusher", "PusherMovingGoal"]


def test_arm_tasks_last_100_steps_and_all_others_1000() -> None:
    for row in TASKS.values():
        assert row.max_steps == (100 if row.base in ("Pusher", "Striker") else 1000)


@pytest.mark.parametrize("name", BODY_GROUPS)
def test_a_groups_tasks_agree_in_sync_async_and_single_environments(name: str) -> None:
    rows = group(name).tasks
    makers = [lambda row=row: make(row) for row in rows]
    singles = [make(row) for row in rows]
    space = singles[0].action_space
    shape = (6, len(rows), *space.shape)
    actions = np.random.default_rng(1).uniform(space.low, space.high, shape).astype(np.float32)
    seeds = list(range(len(rows)))
    expected = [[env.reset(seed=seed)[0] for env, seed in zip(singles, seeds, strict=True)]]
    expected += [[env.step(a)[0] for env, a in zip(singles, step, strict=True)] for step in actions]
    for vector in (SyncVectorEnv(makers), AsyncVectorEnv(makers)):
        np.testing.assert_array_equal(vector.reset(seed=seeds)[0], expected[0])
        for step, row in zip(actions, expected[1:], strict=True):
            np.testing.assert_array_equal(vector.step(step)[0], row)
        vector.close()


@pytest.mark.parametrize("task_id", VARIED)
def test_a_varied_task_differs_from_its_base(task_id: str) -> None:
    row = task(task_id)
    varied, base = make(row), make(row.base)
    starts = [env.reset(seed=1)[0] for env in (varied, base)]
    if starts[0].shape != starts[1].shape or not np.array_equal(*starts):
        return
    differs = False
    for action in np.random.default_rng(2).uniform(-1, 1, (30, *base.action_space.shape)):
        seen = [env.step(action.astype(np.float32))[:2] for env in (varied, base)]
        differs = differs or not np.array_equal(seen[0][0], seen[1][0]) or seen[0][1] != seen[1][1]
    assert differs


FAMILIES = ("HopperWall", "Walker2dNoisyWall", "HalfCheetahWall", "HumanoidNoisyWall", "Pusher", "Striker")


@pytest.mark.parametrize("name", FAMILIES)
def test_the_observation_space_holds_what_occurs(name: str) -> None:
    env = make(name)
    env.action_space.seed(0)
    assert env.reset(seed=0)[0] in env.observation_space
    for _ in range(1500):
        seen, _, terminated, truncated, _ = env.step(env.action_space.sample())
        assert seen in env.observation_space
        assert np.isfinite(seen).all()
        if terminated or truncated:
            env.reset()


@pytest.mark.slow
@pytest.mark.parametrize("name", FAMILIES)
def test_the_observation_space_holds_what_occurs_in_100000_steps(name: str) -> None:
    lanes = make_vec(name, 50)
    lanes.action_space.seed(0)
    lanes.reset(seed=0)
    low, high = lanes.single_observation_space.low, lanes.single_observation_space.high
    for _ in range(2000):
        seen = lanes.step(lanes.action_space.sample())[0]
        assert np.isfinite(seen).all()
        assert ((seen >= low) & (seen <= high)).all()
    lanes.close()


def test_a_task_id_is_a_one_hot_vector_at_the_observations_end() -> None:
    members = group("hopper-gravity")
    for place, row in enumerate(members.tasks):
        env = TaskId(make(row), members)
        seen, _ = env.reset(seed=0)
        assert seen in env.observation_space
        assert seen[-5:].tolist() == [float(place == index) for index in range(5)]
        np.testing.assert_array_equal(seen[:-5], make(row).reset(seed=0)[0])
        assert env.step(env.action_space.sample())[0].shape == (16,)


@pytest.mark.parametrize("lanes", [5, 7])
def test_lanes_of_a_vector_environment_carry_their_tasks_vectors(lanes: int) -> None:
    members = group("hopper-gravity")
    env = VectorTaskId(make_vec(members.tasks, lanes), members)
    seen, _ = env.reset(seed=0)
    assert seen in env.observation_space
    assert seen[:, -5:].argmax(axis=1).tolist() == [lane % 5 for lane in range(lanes)]
    assert env.step(env.action_space.sample())[0].shape == (lanes, 16)
    env.close()


def test_a_task_id_of_a_foreign_task_is_refused() -> None:
    with pytest.raises(BenchError) as caught:
        TaskId(make("Hopper"), group("striker"))
    assert str(caught.value) == "TaskId: gym_extensions/Hopper-v0 is not among Striker, StrikerMovingStart."


def test_a_picture_carries_no_task_id() -> None:
    class Picture(gym.Env):
        observation_space = gym.spaces.Box(0, 255, (4, 4, 3), np.uint8)
        action_space = gym.spaces.Box(-1, 1, (1,))
        task = task("Hopper")

    with pytest.raises(BenchError) as caught:
        TaskId(Picture(), group("hopper-gravity"))
    assert str(caught.value) == (
        "TaskId: The observation space Box(0, 255, (4, 4, 3), uint8) is no vector to append to. "
        "Give the task another way, as an input of its own."
    )


def test_stable_baselines_vector_environments_take_the_tasks() -> None:
    vec = pytest.importorskip("stable_baselines3.common.vec_env")
    lanes = vec.DummyVecEnv([lambda: make("HopperWall"), lambda: make("HopperWithSensor")])
    lanes.seed(0)
    assert lanes.reset().shape == (2, 21)
    assert lanes.step(np.zeros((2, 3), np.float32))[0].shape == (2, 21)
    lanes.close()
