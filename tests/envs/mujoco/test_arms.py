"""Pusher and Striker: resets, rewards and Striker's model."""

import math

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from gym_extensions.catalog.tasks import task
from gym_extensions.envs.mujoco.arms import facing
from gym_extensions.envs.mujoco.env import TaskEnv

from ..resets import assert_uniform, states_after_reset


def test_the_moving_goal_is_drawn_uniformly_and_the_object_away_from_it() -> None:
    rows = states_after_reset("PusherMovingGoal", lambda env: np.concatenate([env.data.qpos, env.data.qvel]))
    objects, goals = rows[:, 7:9], rows[:, 9:11]
    assert_uniform(goals[:, 0], -0.2, 0.0)
    assert_uniform(goals[:, 1], -0.1, 0.3)
    assert (objects >= [-0.3, -0.2]).all()
    assert (objects <= [0, 0.2]).all()
    apart = np.linalg.norm(objects - goals, axis=1)
    assert 0.17 < apart.min() < 0.18
    for joint in range(7):
        assert_uniform(rows[:, 11 + joint], -0.005, 0.005)
    assert not rows[:, 18:].any()
    assert not rows[:, :7].any()


def test_the_object_is_drawn_uniformly_where_the_goal_leaves_room() -> None:
    # Given the goal, what is kept of uniform draws is uniform: compare with rejection done here.
    rows = states_after_reset("PusherMovingGoal", lambda env: env.data.qpos[7:11].copy())
    generator = np.random.default_rng(4)
    expected: list[NDArray[np.float64]] = []
    while len(expected) < 4000:
        goal = generator.uniform([-0.2, -0.1], [0, 0.3])
        start = generator.uniform([-0.3, -0.2], [0, 0.2])
        while np.linalg.norm(start - goal) <= 0.17:
            start = generator.uniform([-0.3, -0.2], [0, 0.2])
        expected.append(start)
    for axis in (0, 1):
        assert stats.ks_2samp(rows[:, axis], np.array(expected)[:, axis]).pvalue > 1e-3


def test_striker_starts_with_a_fixed_ball_and_a_drawn_goal() -> None:
    rows = states_after_reset(
        "Striker", lambda env: np.concatenate([env.data.qpos, env.data.qvel, env.data.mocap_pos[0]])
    )
    assert (rows[:, 7] == -0.175).all()
    assert (rows[:, 8] == 0.5).all()
    assert not rows[:, :7].any()
    for joint in range(7):
        assert_uniform(rows[:, 9 + joint], -0.1, 0.1)
    assert not rows[:, 16:18].any()
    assert_uniform(rows[:, 18], 0.15, 0.7)
    assert_uniform(rows[:, 19], 0.1, 1.0)
    assert (rows[:, 20] == -0.323).all()


def test_strikers_moving_start_draws_the_ball_and_keeps_the_goal_away() -> None:
    rows = states_after_reset(
        "StrikerMovingStart", lambda env: np.concatenate([env.data.qpos[[8, 7]], env.data.mocap_pos[0, :2]])
    )
    assert_uniform(rows[:, 0], 0.43, 0.55)
    assert_uniform(rows[:, 1], -0.3, -0.05)
    assert_uniform(rows[:, 2], 0.15, 0.7)
    assert np.linalg.norm(rows[:, :2] - rows[:, 2:], axis=1).min() >= 0.17


def test_strikers_observation_is_arm_then_tip_ball_goal() -> None:
    env = TaskEnv(task("Striker"))
    seen, _ = env.reset(seed=3)
    assert seen.shape == (23,)
    np.testing.assert_array_equal(seen[:7], np.zeros(7))
    np.testing.assert_array_equal(seen[7:14], env.data.qvel[:7])
    np.testing.assert_allclose(seen[14:17], [0.821, -0.6, 0], atol=1e-9)
    np.testing.assert_allclose(seen[17:20], [0.5, -0.175, -0.27], atol=1e-12)
    np.testing.assert_allclose(seen[20:], [*env.data.mocap_pos[0, :2], -0.323], atol=1e-12)


def test_strikers_reward_is_that_of_the_state_after_the_step() -> None:
    env = TaskEnv(task("Striker"))
    generator = np.random.default_rng(7)
    for seed in range(3):
        env.reset(seed=seed)
        place = {name: env.data.body(name) for name in ("object", "goal", "tips_arm")}
        best = np.linalg.norm(place["object"].xpos - place["goal"].xpos)
        struck = None
        for step in range(60):
            if step == 20:  # the arm reaches down to the ball
                env.data.qpos[:7] = [0.4, 0.38, 0, 0, 0, 0, 0]
                mujoco.mj_forward(env.model, env.data)
                env.data.qpos[7:9] = env.data.body("tips_arm").xpos[[1, 0]] + [0.0, 0.09]
            action = generator.uniform(-3, 3, 7).astype(np.float32)
            reward = env.step(action)[1]
            ball, goal, tip = (place[name].xpos.copy() for name in ("object", "goal", "tips_arm"))
            best = min(best, np.linalg.norm(ball - goal))
            if np.linalg.norm(tip - ball) < 0.1:
                struck = tip
            near = np.linalg.norm(ball - (tip if struck is None else struck))
            expected = -3 * best - 0.1 * np.square(action).sum() - 0.5 * near
            assert reward == pytest.approx(expected, rel=1e-6)
        assert struck is not None


def test_the_smallest_distance_includes_the_one_at_reset() -> None:
    env = TaskEnv(task("Striker"))
    env.reset(seed=1)
    start = float(np.linalg.norm(env.data.body("object").xpos - env.data.body("goal").xpos))
    env.data.qvel[7] = -3  # the ball rolls away
    for _ in range(10):
        info = env.step(np.zeros(7, np.float32))[4]
    assert info["reward_dist"] == pytest.approx(-3 * start)


@pytest.mark.parametrize(
    ("ball", "goal", "turn"),
    [
        ((0.5, -0.175), (0.5, 0.5), 0),  # straight ahead, the cup opens towards −y
        ((1.0, 0.0), (0.0, 0.0), 90),  # the ball lies in +x
        ((-1.0, 0.0), (0.0, 0.0), -90),
        ((1.0, -1.0), (0.0, 0.0), 45),
    ],
)
def test_the_cup_opens_to_the_ball(ball: tuple[float, float], goal: tuple[float, float], turn: float) -> None:
    w, _, _, z = facing(np.array(ball), np.array(goal))
    assert math.degrees(2 * math.atan2(z, w)) == pytest.approx(turn)


def test_a_ball_shot_at_the_open_side_stays_in_the_cup_and_the_cup_stays_in_place() -> None:
    env = TaskEnv(task("Striker"))
    for seed in range(5):
        env.reset(seed=seed)
        cup = env.data.mocap_pos[0].copy()
        ball = env.data.qpos[[8, 7]]
        env.data.qvel[[8, 7]] = 3.0 * (cup[:2] - ball) / np.linalg.norm(cup[:2] - ball) + 1e-6
        nearest = min(_distance_after_step(env) for _ in range(60))
        np.testing.assert_array_equal(env.data.mocap_pos[0], cup)
        assert nearest < 0.06, seed
        passed = np.linalg.norm(env.data.qpos[[8, 7]] - ball) - np.linalg.norm(cup[:2] - ball)
        assert passed < 0.05, seed


def _distance_after_step(env: TaskEnv) -> float:
    env.step(np.zeros(7, np.float32))
    return float(np.linalg.norm(env.data.body("object").xpos[:2] - env.data.body("goal").xpos[:2]))


def test_strikers_model_has_the_numbers_of_2017() -> None:
    model = TaskEnv(task("Striker")).model
    assert (model.nq, model.nv, model.nu, model.nmocap) == (9, 9, 7, 1)
    assert model.opt.timestep == 0.01
    assert not model.opt.gravity.any()
    np.testing.assert_array_equal(model.actuator_ctrlrange, np.tile([-3.0, 3.0], (7, 1)))
    np.testing.assert_array_equal(model.dof_damping, [1, 1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.5, 0.5])
    np.testing.assert_array_equal(model.dof_armature, [0.04] * 7 + [0.1] * 2)
    np.testing.assert_array_equal(model.jnt_range[7:], [[-10.3, 10.3]] * 2)
    assert not model.geom_friction.any()
    assert model.body("object").mass[0] == pytest.approx(300 * 4 / 3 * math.pi * 0.05**3)
    paddle = model.geom("paddle")
    np.testing.assert_array_equal(paddle.size, [0.003, 0.12, 0.05])
    np.testing.assert_array_equal(paddle.pos, [0.017, 0, 0])
    masks = {
        name: (model.geom(name).contype[0], model.geom(name).conaffinity[0])
        for name in ("paddle", "ball", "coaster", "plate0", "plate1", "plate2")
    }
    assert masks == {
        "paddle": (1, 1),
        "ball": (1, 0),
        "coaster": (0, 0),
        "plate0": (0, 1),
        "plate1": (0, 1),
        "plate2": (0, 1),
    }
    for index, turn in enumerate((0, 0.785, -0.785)):
        plate = model.geom(f"plate{index}")
        np.testing.assert_array_equal(plate.size, [0.032, 0.001, 0.04])
        expected = [-0.075 * math.sin(turn), 0.075 * math.cos(turn), 0.04]
        np.testing.assert_allclose(plate.pos, expected, atol=1e-12)
