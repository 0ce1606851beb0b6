"""Bodies that move: Gymnasium's without variations, gravity, and standing up and running."""

from pathlib import Path
from typing import Any

import gymnasium as gym
import mujoco
import numpy as np
import pytest

from gym_extensions.catalog.tasks import task
from gym_extensions.envs import make
from gym_extensions.envs.mujoco.env import TaskEnv

BODIES = ("Hopper", "Walker2d", "HalfCheetah", "Humanoid")


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("body", [*BODIES, "HumanoidStandup", "Pusher"])
def test_a_body_without_variations_equals_gymnasiums_bit_for_bit(
    body: str, dtype: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)  # Gymnasium's HalfCheetah has MuJoCo write a log of its deprecation here.
    # Gymnasium has lengths from the BLAS library, whose last bit depends on the processor.
    monkeypatch.setattr(np.linalg, "norm", lambda vector, **_: np.sqrt(np.square(vector).sum()))
    ours: Any = make(body)
    theirs: Any = gym.make(f"{body}-v5")
    assert ours.action_space == theirs.action_space
    assert ours.observation_space == theirs.observation_space
    assert ours.unwrapped.metadata == theirs.unwrapped.metadata
    generator, ended = np.random.default_rng(5), True
    seed: int | None = 11
    for step in range(400):
        if ended:
            (seen, infos), (expected, other_infos) = ours.reset(seed=seed), theirs.reset(seed=seed)
            ended, seed = False, None
        else:
            action = generator.uniform(1.2 * ours.action_space.low, ours.action_space.high).astype(dtype)
            seen, reward, terminated, truncated, infos = ours.step(action)
            expected, *others, other_infos = theirs.step(action)
            assert [reward, terminated, truncated] == others
            ended = terminated or truncated
        np.testing.assert_array_equal(seen, expected, err_msg=f"step {step}")
        infos.pop("is_success", None)
        assert infos.keys() == other_infos.keys()
        for name, value in infos.items():
            np.testing.assert_array_equal(value, other_infos[name], err_msg=f"{name}, step {step}")


GRAVITY = {"Half": -4.905, "ThreeQuarters": -7.3575, "OneAndQuarter": -12.2625, "OneAndHalf": -14.715}


@pytest.mark.parametrize("suffix", GRAVITY)
def test_gravity_is_exactly_as_specified(suffix: str) -> None:
    assert TaskEnv(task(f"HopperGravity{suffix}")).model.opt.gravity.tolist() == [0, 0, GRAVITY[suffix]]


@pytest.mark.parametrize("body", BODIES)
def test_a_gravity_task_differs_from_its_base_only_in_gravity(body: str) -> None:
    base, varied = (TaskEnv(task(name)).model for name in (body, f"{body}GravityOneAndHalf"))
    varied.opt.gravity = base.opt.gravity
    binary = [np.zeros(mujoco.mj_sizeModel(model), np.uint8) for model in (base, varied)]
    for model, buffer in zip((base, varied), binary, strict=True):
        mujoco.mj_saveModel(model, None, buffer)
    np.testing.assert_array_equal(binary[0], binary[1])


def center(env: TaskEnv) -> float:
    masses = env.model.body_mass
    return float(masses @ env.data.xipos[:, 0] / masses.sum())


def costs(env: TaskEnv) -> float:
    contact = min(0.5e-6 * float(np.square(env.data.cfrc_ext[:14]).sum()), 10)
    return 0.1 * float(np.square(env.data.ctrl).sum()) + contact


@pytest.mark.parametrize("suffix", ["", "WithSensor", "Wall"])
def test_the_reward_of_standing_up_and_running_has_speed_height_and_health(suffix: str) -> None:
    env = TaskEnv(task(f"HumanoidStandupAndRun{suffix}"))
    generator = np.random.default_rng(2)
    env.reset(seed=9)
    heights = []
    for step in range(120):
        if step == 60:  # stand it up
            qpos = env.data.qpos.copy()
            qpos[2] = 1.3
            env.set_state(qpos, env.data.qvel.copy())
        before = center(env)
        _, reward, terminated, truncated, _ = env.step(generator.uniform(-0.4, 0.4, 17).astype(np.float32))
        z = env.data.qpos[2]
        expected = 1.25 * (center(env) - before) / 0.015 + z / 0.003 - costs(env) + (5 if 1 < z < 2 else 1)
        assert reward == pytest.approx(expected, rel=1e-12)
        assert not terminated
        assert not truncated
        heights.append(z)
    assert max(heights[:60]) < 1 < heights[60]


def test_standing_up_and_running_moves_like_standing_up_and_observes_like_humanoid() -> None:
    run, up = make("HumanoidStandupAndRun"), make("HumanoidStandup")
    np.testing.assert_array_equal(run.reset(seed=3)[0], up.reset(seed=3)[0])
    action = np.full(17, 0.2, np.float32)
    for _ in range(20):
        np.testing.assert_array_equal(run.step(action)[0], up.step(action)[0])
    assert run.observation_space.shape == make("Humanoid").observation_space.shape == (348,)
