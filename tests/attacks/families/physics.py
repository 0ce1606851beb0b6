"""Attacks on the physics: altered tasks, actions outside of the action space, and states at seams."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..attack import Attack
from ..forger import Arrays
from ..forgeries.physics import (
    early_end,
    extra_state,
    move_return,
    no_fall,
    not_finite,
    one_segment,
    recorded_on,
    rows_and_traces,
    set_action,
    shift,
    success,
    traces,
    without_noise_of_floats,
    without_velocities,
)
from ..judge import submission

DIFFERS, MALFORMED = "replay: replay-differs", "replay: trace-malformed"


def traced(
    title: str,
    edit: Callable[[Arrays], object],
    stop: str = DIFFERS,
    base: str = "random",
    quick: bool = False,
) -> Attack:
    """An attack that changes traces."""
    return Attack(title, submission(traces(edit, base)), stop, quick=quick)


ATTACKS = (
    Attack(
        "All episodes are recorded with half the gravity.",
        submission(recorded_on("HopperGravityHalf")),
        DIFFERS,
    ),
    Attack(
        "All episodes are recorded with a body of another size.",
        submission(recorded_on("HopperSmallLeg")),
        DIFFERS,
    ),
    Attack(
        "The episodes with motor noise are recorded without it.",
        submission(recorded_on("Hopper", presented="HopperMotorNoise")),
        DIFFERS,
    ),
    traced(
        "An action is ten times the largest one, which switches motor noise off.",
        set_action(10.0),
        quick=True,
    ),
    traced("An action is slightly outside of the action space.", set_action(1.0001)),
    traced("An action is not a number.", set_action(np.nan), MALFORMED),
    traced(
        "Another action is recorded than was applied.",
        lambda arrays: np.negative(arrays["actions"], out=arrays["actions"]),
    ),
    traced("Actions have more digits than float32.", without_noise_of_floats, MALFORMED),
    traced("The body jumps a meter forward at a seam.", shift("qpos", 1.0)),
    traced("The body is a hundredth of a millimeter higher at a seam.", shift("qpos", 1e-5, column=1)),
    traced("The body is pushed at a seam.", shift("qvel", 0.1)),
    traced("The warm start of the solver is changed at a seam.", shift("qacc_warmstart", 1.0)),
    traced("The clock is moved by a nanosecond at a seam.", shift("time", 1e-9)),
    traced("The state is not a number.", not_finite, MALFORMED),
    traced("A state that replay does not know is added.", extra_state),
    traced("The velocities are left out.", without_velocities),
    traced("Reward is moved between segments.", move_return),
    traced("The whole episode is one segment, without seams.", one_segment, MALFORMED),
    Attack("An episode ends one step before the fall.", submission(rows_and_traces(early_end)), DIFFERS),
    Attack("An episode goes on after the fall.", submission(rows_and_traces(no_fall)), DIFFERS),
    traced(
        "Striker's ball is a little struck, so that the reward ignores the tip.",
        shift("struck", 1e-7),
        base="striker",
    ),
    traced("Striker's ball is moved to the goal at a seam.", shift("qpos", 0.1, column=-1), base="striker"),
    traced(
        "Striker's velocities are zero at a seam.",
        lambda arrays: arrays["state_qvel"].fill(0.0),
        base="striker",
    ),
    Attack(
        "Success is claimed of episodes without it.", submission(rows_and_traces(success, "striker")), DIFFERS
    ),
    Attack(
        "Success is claimed in a task that defines none.",
        submission(rows_and_traces(success)),
        "rules: undefined-success",
        quick=True,
    ),
)
