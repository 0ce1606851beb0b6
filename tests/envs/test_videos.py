"""Gymnasium's RecordVideo without a screen."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

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
    if subprocess.run(
        [sys.executable, "-c", RENDERS], env=settings, capture_output=True, check=False
    ).returncode:
        pytest.skip(f"the library of {backend} is not installed, or has no device")
    command = [sys.executable, "-c", RECORD, str(tmp_path)]
    subprocess.run(command, env=settings, check=True, capture_output=True)
    assert [path.suffix for path in tmp_path.iterdir()] == [".mp4"]
