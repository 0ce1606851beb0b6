"""Our TRPO beside sb3-contrib's, same settings and task: the same learning within five seeds' intervals.

Slow (about five minutes on two cores): ``pytest -m slow tests/baselines/test_against_sb3.py``.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from gym_extensions.baselines.algorithms import factory
from gym_extensions.baselines.training.recorder import Recorder
from gym_extensions.baselines.trpo.settings import HENDERSON_2017
from gym_extensions.envs import make_vec

STEPS, BATCH, LANES, SEEDS = 40_000, 2_000, 8, range(5)
ACTIONS = 3
"""Components of Hopper's action."""
T_975_8 = 2.306
"""Student's t, two-sided 5 %, 8 degrees of freedom."""


def late(recorder: Recorder) -> float:
    """Mean return over the last quarter of training."""
    recorder.flush()
    return float(np.mean([point.return_ for point in recorder.points if point.step > 0.75 * STEPS]))


def recorder_of(seed: int) -> Recorder:
    return Recorder(make_vec("Hopper", LANES), ["Hopper"], steps=STEPS, batch_steps=BATCH, seed=seed)


def ours(seed: int) -> float:
    recorder = recorder_of(seed)
    agent = factory("trpo-2017")(recorder.single_observation_space, recorder.single_action_space, seed)
    agent.learn(recorder, STEPS)
    return late(recorder)


def theirs(seed: int) -> float:
    import torch
    from sb3_contrib import TRPO

    from gym_extensions.baselines.adapters.sb3 import sb3

    make = sb3(
        TRPO,
        n_steps=BATCH // LANES,
        batch_size=125,
        gamma=HENDERSON_2017.discount,
        gae_lambda=HENDERSON_2017.gae_lambda,
        # Its KL is a mean over the action's components too, ours their sum, as in Schulman et al. and rllab.
        target_kl=HENDERSON_2017.trust_region.max_kl / ACTIONS,
        cg_damping=HENDERSON_2017.trust_region.damping,
        cg_max_steps=HENDERSON_2017.trust_region.iterations,
        policy_kwargs={"activation_fn": torch.nn.ReLU, "net_arch": {"pi": [100, 50, 25], "vf": [64, 64]}},
    )
    recorder = recorder_of(seed)
    agent = make(recorder.single_observation_space, recorder.single_action_space, seed)
    agent.learn(recorder, STEPS)
    return late(recorder)


@pytest.mark.slow
def test_it_learns_as_sb3_contribs_does() -> None:
    pytest.importorskip("sb3_contrib")
    mine, other = (np.array([run(seed) for seed in SEEDS]) for run in (ours, theirs))
    gap = mine.mean() - other.mean()
    error = math.sqrt((mine.var(ddof=1) + other.var(ddof=1)) / len(SEEDS))
    summary = f"ours {mine.round(1)}, sb3-contrib's {other.round(1)}, gap {gap:.1f} ± {T_975_8 * error:.1f}"
    assert mine.min() > 100, summary
    assert abs(gap) <= T_975_8 * error, summary
