"""Attacks with picked, copied and renamed runs, and with training that is not what the manifest says."""

from __future__ import annotations

from ..attack import NOT_DETECTED, REEVALUATED, REPRODUCED, Attack
from ..forgeries.runs import (
    another_episode,
    as_runs,
    declared,
    other_settings,
    picked,
    renumbered,
    retrained,
    trainable,
    trained_longer,
    with_curve,
)
from ..judge import submission

PICKED = (
    "Retraining of a run that is chosen after the submission; only reference agents can be retrained so far."
)
ATTACKS = (
    Attack(
        "The best five of 50 runs, with their numbers.",
        submission(renumbered((3, 7, 20, 31, 44))),
        "rules: foreign-policy, foreign-trace, gaps-in-runs, missing-policy",
        quick=True,
    ),
    Attack(
        "Runs with the numbers of the reference agents.",
        submission(renumbered((1000, 1001, 1002, 1003, 1004))),
        "rules: gaps-in-runs, reserved-run",
        quick=True,
    ),
    Attack(
        "Run 0 of TRPO is that of a policy that was trained longer.",
        retrained(trained_longer),
        "retraining: differs",
        REEVALUATED,
        REEVALUATED,
    ),
    Attack(
        "Run 0 of TRPO is another run, whose returns are the same within noise.",
        retrained(picked),
        NOT_DETECTED,
        REPRODUCED,
        REPRODUCED,
        "The same bytes, which only the same processor gives; the gain is within the noise of evaluation.",
    ),
    Attack(
        "The best runs of an agent that is not a reference agent are renumbered.",
        submission(as_runs((3, 1, 4, 0, 2), base="gaussian")),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
        PICKED,
    ),
    Attack(
        "TRPO was trained with other settings than the manifest states.",
        retrained(other_settings),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
    ),
    Attack(
        "Four runs.",
        submission(as_runs((0, 1, 2, 3))),
        "board: Fewer than 5 runs.",
    ),
    Attack(
        "One run five times, of an agent with parameters.",
        submission(as_runs((0,) * 5, edit=trainable)),
        "rules: identical-runs",
        quick=True,
    ),
    Attack(
        "One run five times, of an agent that is said to have no parameters.",
        submission(as_runs((0,) * 5)),
        "board: Fewer than 5 runs.",
    ),
    Attack(
        "One run five times, with differences that replay tolerates.",
        submission(as_runs((0,) * 5, noise=1e-7, edit=trainable)),
        "rules: identical-runs",
        quick=True,
    ),
    Attack(
        "One run five times, with one other episode per cell.",
        submission(as_runs((0,) * 5, base="gaussian", edit=another_episode)),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
        PICKED + " The scorer notes runs that share most episodes.",
    ),
    Attack(
        "The budget is said to be 1M instead of 100k.",
        submission(declared("budget", '"1M"')),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
        PICKED,
    ),
    Attack("A budget that does not exist.", submission(declared("budget", '"2M"')), "rules: bad-value"),
    Attack(
        "The smallest budget, to be alone on a board.",
        submission(declared("budget", '"smoke"')),
        "board: not on a board",
    ),
    Attack("A training curve goes beyond the budget.", submission(with_curve(110_000)), "rules: over-budget"),
    Attack(
        "Training goes on after the budget, and the curve is cut.",
        submission(with_curve(100_000)),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
        PICKED,
    ),
    Attack(
        "Training curves are invented, which raises the forward transfer.",
        submission(with_curve(100_000, gain=500.0)),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
        "Retraining. Curves have no traces; the scorer notes sampled returns that are far above a curve.",
    ),
    Attack("Another version of MuJoCo.", submission(declared("mujoco", '"9.9"')), "rules: foreign-version"),
    Attack(
        "Another version of Gymnasium.",
        submission(declared("gymnasium", '"1.3.0"')),
        "rules: foreign-version",
    ),
    Attack(
        "Another version of numpy than the one that was used.",
        submission(declared("numpy", '"9.9"', base="random")),
        NOT_DETECTED,
        REPRODUCED,
        REPRODUCED,
        "Nothing: no step depends on it.",
    ),
    Attack(
        "An agent of the author's own is said to be the reference agent `random`.",
        submission(declared("algorithm", '"random"')),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
    ),
)
