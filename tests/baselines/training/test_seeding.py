"""Training seeds."""

from __future__ import annotations

from gym_extensions.baselines.training.jobs import training_seed


def test_seeds_differ_by_run_and_by_purpose() -> None:
    purposes = [
        ("hopper-gravity-v0", "agent"),
        ("hopper-gravity-v0", "training"),
        ("hopper-gravity-v0/agent", ""),
    ]
    seeds = {training_seed(run, *purpose) for run in range(5) for purpose in purposes}
    assert len(seeds) == 15
    assert all(0 <= seed < 2**32 for seed in seeds)


def test_the_seed_of_a_run_and_purpose_is_fixed() -> None:
    assert training_seed(0, "hopper-gravity-v0", "agent") == training_seed(0, "hopper-gravity-v0", "agent")
    assert training_seed(1000, "reference", "gym_extensions/HopperGravityHalf-v0", "random") == 3190986840
