"""TRPO and sb3-contrib's TRPO with the same settings learn the same within the interval of five seeds.

Slow (about five minutes on two cores): ``pytest -m slow tests/baselines/trust_region/test_against_sb3.py``.
"""

import math

import numpy as np
import pytest

from gym_extensions.baselines import Factory
from gym_extensions.baselines.algorithms import factory
from gym_extensions.baselines.algorithms.trpo import HENDERSON_2017
from gym_extensions.baselines.training.environment import Report, TrainingEnv
from gym_extensions.envs import make_vec

STEPS, BATCH, NUM_ENVS, SEEDS = 40_000, 2_000, 8, range(5)
ACTIONS = 3
"""Components of Hopper's action."""
T_975_8 = 2.306
"""Student's t, two-sided 5 %, 8 degrees of freedom."""


def late(make: Factory, seed: int) -> float:
    """Mean return over the last quarter of training."""
    batches: list[Report] = []
    recorder = TrainingEnv(
        make_vec("Hopper", NUM_ENVS),
        ["Hopper"],
        steps=STEPS,
        batch_steps=BATCH,
        seed=seed,
        report=batches.append,
    )
    make(recorder.single_observation_space, recorder.single_action_space, seed).learn(recorder, STEPS)
    recorder.flush()
    values = (value for batch in batches if batch.step > 0.75 * STEPS for value in batch.returns.values())
    return float(np.mean(list(values)))


def ours(seed: int) -> float:
    return late(factory("trpo-2017"), seed)


def theirs(seed: int) -> float:
    import torch
    from sb3_contrib import TRPO

    from gym_extensions.baselines.adapters.sb3 import sb3

    make = sb3(
        TRPO,
        n_steps=BATCH // NUM_ENVS,
        batch_size=125,
        gamma=HENDERSON_2017.discount,
        gae_lambda=HENDERSON_2017.gae_lambda,
        # Its KL is a mean over the action's components, not their sum as in Schulman et al. and rllab.
        target_kl=HENDERSON_2017.trust_region.max_kl / ACTIONS,
        cg_damping=HENDERSON_2017.trust_region.damping,
        cg_max_steps=HENDERSON_2017.trust_region.iterations,
        policy_kwargs={"activation_fn": torch.nn.ReLU, "net_arch": {"pi": [100, 50, 25], "vf": [64, 64]}},
    )
    return late(make, seed)


@pytest.mark.slow
def test_it_learns_as_sb3_contribs_does() -> None:
    pytest.importorskip("sb3_contrib")
    numpy_returns, sb3_returns = (np.array([run(seed) for seed in SEEDS]) for run in (ours, theirs))
    gap = numpy_returns.mean() - sb3_returns.mean()
    error = math.sqrt((numpy_returns.var(ddof=1) + sb3_returns.var(ddof=1)) / len(SEEDS))
    summary = (
        f"{numpy_returns.round(1)}, sb3-contrib {sb3_returns.round(1)}, gap {gap:.1f} ± {T_975_8 * error:.1f}"
    )
    assert numpy_returns.min() > 100, summary
    assert abs(gap) <= T_975_8 * error, summary
