"""The task in the observation, and Gymnasium's RecordVideo without a screen."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from gym_extensions.catalog.tasks import task
from gym_extensions.envs import TaskId, VectorTaskId, group, make, make_vec

from ..conftest import refused


def test_the_observation_ends_with_a_one_hot_vector_of_the_task() -> None:
    members = group("hopper-gravity")
    for position, row in enumerate(members.tasks):
        env = TaskId(make(row), [each.name for each in members.tasks] if position % 2 else members)
        seen, _ = env.reset(seed=0)
        assert seen in env.observation_space
        assert seen[-5:].tolist() == [float(position == index) for index in range(5)]
        np.testing.assert_array_equal(seen[:-5], make(row).reset(seed=0)[0])
        assert env.step(env.action_space.sample())[0].shape == (16,)


@pytest.mark.parametrize("num_envs", [5, 7])
def test_every_environment_of_a_vector_environment_has_the_vector_of_its_task(num_envs: int) -> None:
    members = group("hopper-gravity")
    env = VectorTaskId(make_vec(members.tasks, num_envs), "hopper-gravity")
    seen, _ = env.reset(seed=0)
    assert seen in env.observation_space
    assert seen[:, -5:].argmax(axis=1).tolist() == [index % 5 for index in range(num_envs)]
    assert env.step(env.action_space.sample())[0].shape == (num_envs, 16)
    env.close()


def test_a_task_outside_the_list_raises_an_error() -> None:
    for others in (group("striker"), ["Striker", "StrikerMovingStart"]):
        with refused("foreign-task", "not one of Striker, StrikerMovingStart"):
            TaskId(make("Hopper"), others)


def test_a_picture_observation_raises_an_error() -> None:
    class Picture(gym.Env[Any, Any]):
        observation_space = gym.spaces.Box(0, 255, (4, 4, 3), np.uint8)
        action_space = gym.spaces.Box(-1, 1, (1,))
        task = task("Hopper")

    with refused("no-vector"):
        TaskId(Picture(), group("hopper-gravity"))


RECORD = """
import sys
import gymnasium as gym
import gym_extensions.envs

env = gym.make("gym_extensions/HopperGravityHalf-v0", render_mode="rgb_array", width=64, height=64)
env = gym.wrappers.RecordVideo(env, sys.argv[1], video_length=5)
env.reset(seed=0)
for _ in range(6):
    env.step(env.action_space.sample())
env.close()
"""
RENDERS = """
import mujoco
mujoco.GLContext(8, 8).make_current()
"""


@pytest.mark.parametrize("backend", ["egl", "osmesa"])
def test_record_video_works_without_a_screen(backend: str, tmp_path: Path) -> None:
    pytest.importorskip("moviepy", reason="RecordVideo needs moviepy: the extra `examples`")
    if sys.platform != "linux":
        pytest.skip("EGL and OSMesa are libraries of Linux")
    settings = os.environ | {"MUJOCO_GL": backend, "PYOPENGL_PLATFORM": backend}
    probe = [sys.executable, "-c", RENDERS]
    if subprocess.run(probe, env=settings, capture_output=True, check=False).returncode:
        pytest.skip(f"the library of {backend} is not installed, or has no device")
    command = [sys.executable, "-c", RECORD, str(tmp_path)]
    subprocess.run(command, env=settings, check=True, capture_output=True)
    assert [path.suffix for path in tmp_path.iterdir()] == [".mp4"]
