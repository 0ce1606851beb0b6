"""Attacks with chosen episodes: other seeds, the best of several evaluations, and actions per seed."""

from __future__ import annotations

from ..attack import REEVALUATED, REPLAYED, REPRODUCED, Attack
from ..forgeries.seeds import (
    always_forward,
    best_cell,
    best_episodes,
    best_evaluation,
    lucky_seeds,
    open_loop,
    real_seeds,
    selected_policies,
    wide,
    with_episodes,
    with_policy_file,
)
from ..judge import submission

ATTACKS = (
    Attack(
        "The best 20 of 60 seeds, logged with their numbers.", submission(real_seeds), "rules: wrong-seed"
    ),
    Attack(
        "The best 20 of 60 seeds, logged with the prescribed numbers.",
        submission(with_episodes(lucky_seeds)),
        "replay: replay-differs",
    ),
    Attack(
        "The better of two evaluations of every episode.",
        submission(with_episodes(best_episodes(2))),
        "new seeds: reevaluation-differs",
        REPLAYED,
        REPLAYED,
    ),
    Attack(
        "The best of five evaluations of every episode.",
        submission(with_episodes(best_episodes(5))),
        "new seeds: reevaluation-differs",
        REPLAYED,
        REPLAYED,
    ),
    Attack(
        "The best of ten evaluations of every cell.",
        submission(with_episodes(best_evaluation)),
        "new seeds: reevaluation-differs",
        REPLAYED,
        REPLAYED,
    ),
    Attack(
        "The best of five evaluations of one cell.",
        submission(best_cell),
        "not detected",
        REPRODUCED,
        REPRODUCED,
        "More new seeds. The test of a single cell finds gains above about one standard deviation; the bytes "
        "of a retrained run show the difference.",
    ),
    Attack(
        "The best of five evaluations of every episode, without policies.",
        submission(with_episodes(best_episodes(5), policies=False)),
        "new seeds: no policies",
        REPLAYED,
        REPLAYED,
    ),
    Attack(
        "Actions are searched for every prescribed seed; no policies.",
        submission(with_episodes(open_loop, policies=False)),
        "new seeds: no policies",
        REPLAYED,
        REPLAYED,
    ),
    Attack(
        "Searched actions, with a deterministic policy as a pretext.",
        submission(with_policy_file(open_loop, always_forward)),
        "replay: actions-differ",
    ),
    Attack(
        "Searched actions, with a uniform policy, which any action agrees with.",
        submission(with_episodes(open_loop)),
        "new seeds: reevaluation-differs",
        REPLAYED,
        REPLAYED,
    ),
    Attack(
        "Searched actions, with a Gaussian policy of ten half widths, which any action agrees with.",
        submission(with_policy_file(open_loop, wide)),
        "new seeds: reevaluation-differs",
        REPLAYED,
        REPLAYED,
    ),
    Attack(
        "The best of ten policies on the prescribed seeds, for every run and task.",
        submission(selected_policies),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
        "Retraining from committed code. The policies are as good on new seeds, so that the level is true.",
    ),
)
