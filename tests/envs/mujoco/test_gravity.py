"""The gravity tasks: gravity differs, and nothing else."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from gym_extensions.envs.make import construct_mujoco

BODIES = ("Hopper", "Walker2d", "HalfCheetah", "Humanoid")
Z_GRAVITY = {
    "GravityHalf": -4.905,
    "GravityThreeQuarters": -7.3575,
    "": -9.81,
    "GravityOneAndQuarter": -12.2625,
    "GravityOneAndHalf": -14.715,
}


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
