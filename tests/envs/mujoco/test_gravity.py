"""The gravity tasks: gravity differs, and nothing else."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium as gym
import mujoco
import numpy as np
import pytest

from gym_extensions.catalog.custom import customize
from gym_extensions.envs import Gravity, make
from gym_extensions.envs.make import construct_mujoco
from gym_extensions.errors import BenchError

BODIES = ("Hopper", "Walker2d", "HalfCheetah", "Humanoid")
Z_GRAVITY = {
    "GravityHalf": -4.905,
    "GravityThreeQuarters": -7.3575,
    "": -9.81,
    "GravityOneAndQuarter": -12.2625,
    "GravityOneAndHalf": -14.715,
}


@pytest.mark.parametrize("body", BODIES)
def test_a_body_without_variations_equals_gymnasiums_bit_for_bit(
    body: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)  # Gymnasium's HalfCheetah has MuJoCo write a log of its deprecation here.
    ours, theirs = make(body), gym.make(f"{body}-v5")
    space = construct_mujoco(body).action_space
    seen, expected = ours.reset(seed=11)[0], theirs.reset(seed=11)[0]
    generator = np.random.default_rng(5)
    for step in range(1000):
        np.testing.assert_array_equal(seen, expected, err_msg=f"step {step}")
        action = generator.uniform(space.low, space.high, space.shape).astype(np.float32)
        seen, *ours_rest, _ = ours.step(action)
        expected, *theirs_rest, _ = theirs.step(action)
        assert ours_rest == theirs_rest
        if any(ours_rest[1:]):
            seen, expected = ours.reset()[0], theirs.reset()[0]


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("suffix", Z_GRAVITY)
def test_gravity_is_exactly_as_specified(body: str, suffix: str) -> None:
    gravity = construct_mujoco(body + suffix).model.opt.gravity
    assert gravity.tolist() == [0.0, 0.0, Z_GRAVITY[suffix]]


@pytest.mark.parametrize("body", BODIES)
def test_a_gravity_task_differs_from_its_base_only_in_gravity(body: str) -> None:
    base, varied = (construct_mujoco(name).model for name in (body, f"{body}GravityOneAndHalf"))
    varied.opt.gravity = base.opt.gravity
    binary = [np.zeros(mujoco.mj_sizeModel(model), np.uint8) for model in (base, varied)]
    for model, buffer in zip((base, varied), binary, strict=True):
        mujoco.mj_saveModel(model, None, buffer)
    np.testing.assert_array_equal(binary[0], binary[1])


def test_a_hopper_in_free_fall_at_half_gravity_loses_4_905_metres_per_second_in_a_second() -> None:
    env = construct_mujoco("HopperGravityHalf")
    env.reset(seed=0)
    env.set_state(env.init_qpos + np.array([0, 50, 0, 0, 0, 0]), np.zeros(6))
    for _ in range(125):
        env.do_simulation(np.zeros(3), env.frame_skip)
    assert env.data.time == pytest.approx(1.0)
    assert env.data.qvel[1] == pytest.approx(-4.905, abs=1e-9)


def test_any_positive_factor_is_accepted() -> None:
    env: Any = make("Hopper", [Gravity(0.8)]).unwrapped
    assert env.model.opt.gravity[2] == -7.848
    assert env.task.id == "gym_extensions/Hopper.Gravity-0.8-v0"


def test_a_published_factor_gives_the_published_task() -> None:
    assert (
        construct_mujoco(customize("Hopper", [Gravity(0.5)])).task.id == "gym_extensions/HopperGravityHalf-v0"
    )


@pytest.mark.parametrize("factor", [0, -1.0, float("nan"), float("inf"), "half"])
def test_the_factor_must_be_a_finite_number_above_0(factor: Any) -> None:
    with pytest.raises(BenchError) as caught:
        Gravity(factor)
    assert str(caught.value) == f"Gravity's factor is {factor!r}. Give a finite number above 0."
