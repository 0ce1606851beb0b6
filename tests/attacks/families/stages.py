"""Attacks with policies of other stages, tasks and runs, and with policy files of other policies."""

from __future__ import annotations

import numpy as np

from gym_extensions.rollouts.policies import Policy

from ..attack import REEVALUATED, REPLAYED, Attack
from ..forgeries.stages import (
    declared_rows,
    files,
    hand_written,
    of_another_run,
    present,
    replaced,
    rows_per_task,
    sampled,
    without,
    worse,
)
from ..judge import submission

UNIFORM = Policy(np.zeros(3), np.ones(3), head="uniform")
WIDE = Policy(np.zeros(3), np.ones(3), head="gaussian", log_sigma=np.full(3, 3.0))
LAST, FIRST, SINGLE = ("sequential", 2), ("sequential", 1), ("single", 1)
RETRAINING = "Retraining from committed code, which only reference agents have so far."

ATTACKS = (
    Attack(
        "The best stage is logged as the last one; no policies.",
        submission(present(FIRST, LAST, "none")),
        "new seeds: no policies",
        REPLAYED,
        REPLAYED,
    ),
    Attack(
        "The best stage is logged as the last one, with the policies of the stated stages.",
        submission(present(FIRST, LAST, "stated")),
        "replay: actions-differ",
    ),
    Attack(
        "The best stage is logged as the last one, with its policies.",
        submission(present(FIRST, LAST, "swapped")),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
        RETRAINING,
    ),
    Attack(
        "Experts of single tasks are logged as the last stage; no policies.",
        submission(present(SINGLE, LAST, "none")),
        "new seeds: no policies",
        REPLAYED,
        REPLAYED,
    ),
    Attack(
        "Experts of single tasks are logged as the last stage, with the policies of the stages.",
        submission(present(SINGLE, LAST, "stated")),
        "replay: actions-differ",
    ),
    Attack(
        "The untrained stage is logged as the one after training, to forget nothing.",
        submission(present(("sequential", 0), FIRST, "stated")),
        "replay: actions-differ",
    ),
    Attack(
        "Experts are packed as one policy with weights per task.",
        submission(files(rows_per_task)),
        "rules: policy-observes-task",
    ),
    Attack(
        "Experts are packed as one policy with weights per task, and the manifest says so.",
        submission(files(declared_rows)),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
        "Nothing: such entries have a board of their own.",
    ),
    Attack(
        "A policy that falls at once is evaluated as the untrained one, which raises zero-shot transfer.",
        submission(worse("sequential", 0)),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
        RETRAINING + " New seeds find logs that are too high, not policies that are too weak.",
    ),
    Attack(
        "Policies that fall at once are evaluated in single.csv, which raises asymptotic transfer.",
        submission(worse("single", 1)),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
        RETRAINING + " The single-task scores of the entry are beside its transfer.",
    ),
    Attack(
        "The policy files of one run are those of another.",
        submission(files(of_another_run)),
        "replay: actions-differ",
    ),
    Attack(
        "The policy files are uniform, of a log that says deterministic.",
        submission(files(replaced(UNIFORM))),
        "rules: sampled-policy",
    ),
    Attack(
        "The policy files are uniform, and the manifest says sampled.",
        submission(files(sampled(UNIFORM))),
        "new seeds: reevaluation-differs",
        REPLAYED,
        REPLAYED,
    ),
    Attack(
        "The policy files are Gaussians that any action agrees with.",
        submission(files(sampled(WIDE))),
        "new seeds: reevaluation-differs",
        REPLAYED,
        REPLAYED,
    ),
    Attack(
        "The policy files of one run are missing.",
        submission(files(without("*-run3-*"))),
        "rules: missing-policy",
    ),
    Attack(
        "Only single.csv has policies.",
        submission(files(without("sequential*"))),
        "new seeds: no policies for some logs",
        REPLAYED,
        REPLAYED,
    ),
    Attack(
        "A hand-written controller is packed as a trained policy.",
        submission(hand_written),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
        RETRAINING,
    ),
)
