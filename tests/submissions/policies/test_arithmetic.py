"""The bits of a policy's actions: those of docs/rollout-log.md#arithmetic, on every processor."""

import hashlib
import itertools
import math
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gym_extensions.submissions.policies.mlp import Policy
from gym_extensions.submissions.policies.mlp_arrays import ACTIVATIONS

from .specified import specified_action

PROCESSORS = ("nehalem", "sandybridge", "haswell", "znver2")


def policy_of(seed: int, activation: str, dtype: Any = np.float32, **changes: Any) -> Policy:
    """A policy with 11 observations, 3 actions, and widths that are no multiples of four."""
    rng, sizes = np.random.default_rng(seed), (11, 7, 6, 3)
    layers = itertools.pairwise(sizes)
    return Policy(
        action_offset=rng.normal(size=3).astype(dtype),
        action_scale=rng.uniform(0.5, 2, 3).astype(dtype),
        weights=tuple(rng.normal(size=shape).astype(dtype) for shape in layers),
        biases=tuple(rng.normal(size=size).astype(dtype) for size in sizes[1:]),
        activation=activation,
        **changes,
    )


def policies() -> dict[str, Policy]:
    """A policy of every kind, by name."""
    rng = np.random.default_rng(9)
    kinds = {name: policy_of(1, name, output_activation=name) for name in ACTIVATIONS}
    normalized: dict[str, Any] = {
        "observation_mean": rng.normal(size=11),
        "observation_scale": rng.uniform(0.1, 3, 11).astype("f4"),
        "observation_clip": 1.5,
    }
    plain = kinds["tanh"]
    tasks: dict[str, Any] = {
        "weights": (plain.weights[0], plain.weights[1], rng.normal(size=(2, 6, 3))),
        "biases": (plain.biases[0], plain.biases[1], rng.normal(size=(2, 3))),
        "masks": (rng.random((2, 11, 7)) < 0.5, None, None),
    }
    return kinds | {
        "float64": policy_of(2, "tanh", np.float64, observation_dtype="float64", squash="tanh"),
        "normalized": policy_of(3, "tanh", **normalized),
        "tasks": replace(plain, **tasks),
        "no layers": Policy(np.ones(3), np.ones(3)),
    }


def seen(rows: int) -> Any:
    """Observations from tiny to huge, so that every branch is taken."""
    rng = np.random.default_rng(4)
    return rng.normal(size=(rows, 11)) * 10.0 ** rng.integers(-9, 4, (rows, 1))


@pytest.mark.parametrize("name", policies())
def test_actions_are_those_of_the_specification_to_the_last_bit(name: str) -> None:
    policy, observations = policies()[name], seen(200)
    for task in (0, 1, 4):
        actions = policy.act(observations, task=task)
        for observation, action in zip(observations, actions, strict=True):
            assert specified_action(policy.arrays(), observation, task) == action.tolist()


def test_an_action_does_not_depend_on_the_other_rows_of_the_batch() -> None:
    policy, observations = policies()["silu"], seen(33)
    one_by_one = [policy.act(observation) for observation in observations]
    assert np.array_equal(policy.act(observations), one_by_one)


@pytest.mark.parametrize("name", ACTIVATIONS[1:])
def test_activations_are_those_of_the_library_up_to_rounding(name: str) -> None:
    unit = Policy(
        np.zeros(1), np.ones(1), (np.ones((1, 1)),), (np.zeros(1),), observation_dtype="float64",
        output_activation=name,
    )  # fmt: skip
    x = np.concatenate([np.linspace(-50, 50, 2001), [-1e300, -1e-300, 0.0, 1e300]])
    with np.errstate(over="ignore"):
        expected = {
            "tanh": np.tanh(x),
            "relu": np.maximum(x, 0),
            "leaky_relu": np.where(x < 0, 0.01 * x, x),
            "elu": np.where(x < 0, np.expm1(np.minimum(x, 0)), x),
            "silu": x / (1 + np.exp(-x)),
        }
    np.testing.assert_allclose(unit.act(x[:, None])[:, 0], expected[name], rtol=1e-14, atol=1e-14)


def test_a_number_that_is_none_stays_none() -> None:
    for name in ACTIVATIONS:
        assert np.isnan(policies()[name].act(np.full((1, 11), math.nan))).all()


def digest() -> str:
    """The digest of the actions of all policies."""
    found = hashlib.sha256()
    for policy in policies().values():
        found.update(policy.act(seen(100), task=1).tobytes())
    return found.hexdigest()


@pytest.mark.parametrize(
    "processor", ["generic", *(pytest.param(name, marks=pytest.mark.slow) for name in PROCESSORS)]
)
def test_code_for_another_processor_gives_the_same_bits(processor: str) -> None:
    variables = {**os.environ, "NUMBA_CPU_NAME": processor, "NUMBA_CPU_FEATURES": ""}
    variables |= {"OPENBLAS_CORETYPE": "Prescott", "PYTHONPATH": str(Path(__file__).parents[2])}
    code = "from submissions.policies.test_arithmetic import digest; print(digest())"
    done = subprocess.run(
        [sys.executable, "-c", code], env=variables, capture_output=True, text=True, check=False
    )
    assert done.stdout.strip() == digest(), done.stderr
