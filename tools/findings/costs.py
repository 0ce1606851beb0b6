"""What a submission costs to train, from measured processor times."""

from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import FULL_SUBMISSION_RUNS, STANDARD_BUDGET, budget

CPU_SECONDS = {
    "Hopper": 108,
    "Walker2d": 146,
    "HalfCheetah": 63,
    "Humanoid": 403,
    "HumanoidStandup": 636,
    "HumanoidStandupAndRun": 636,
    "Pusher": 67,
    "Striker": 59,
    "nav-state": 29,
    "nav-state-goal": 29,
    "nav-range": 45,
    "nav-range-known": 45,
    "nav-image": 17_000,
}
"""Processor seconds of ``trpo`` per million training steps, by body, and in navigation by group.

Measured at the standard budget on a busy machine of two cores, in 60,000 steps from the start of training
(4,000 of images, 160 × 120 × 3 inputs)::

    python -m tools.tuning.measure_learners --seeds 10 --steps 60000 --num-envs 25 \\
        --tasks Hopper,Walker2d,HalfCheetah,Humanoid,HumanoidStandupAndRun,Pusher,Striker

and with the first tasks of nav-state, nav-range and nav-image. HumanoidStandup and the two other families of
navigation were not measured: they have the figure of the row beside them.
"""


def hours(group_name: str) -> str:
    """The CPU hours of one submission of five sequential runs on the group, without evaluation, as text."""
    steps = budget(STANDARD_BUDGET).steps_for(group_name)
    rates = [CPU_SECONDS.get(task.body.name) or CPU_SECONDS[group_name] for task in group(group_name).tasks]
    value = sum(rates) * steps / 1e6 * FULL_SUBMISSION_RUNS / 3600
    return f"{value:.2f}" if value < 10 else f"{value:.0f}"
