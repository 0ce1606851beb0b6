"""Rules about policy files: their arrays, and completeness by run, stage and task."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from gym_extensions.catalog.groups import group
from gym_extensions.rollouts.layout import MAX_POLICY_BYTES, policy_names
from gym_extensions.rollouts.policies import Policy
from gym_extensions.rollouts.reader import read

from ..examples import (
    GROUP,
    TOML,
    Change,
    Check,
    CopySubmission,
    Example,
    all_of,
    edit,
    parametrize,
    put,
    remove,
)

FOLDER = f"{GROUP}/policies"
POLICY = f"{FOLDER}/sequential-run0-stage1.npz"
RUNS = (0, 1)
WRITE = "Write it with gym_extensions.rollouts.policies.Policy.to_bytes."
RENAME = "Remove it, or rename it as described in docs/rollout-log.md."
PLAIN = Policy(
    action_offset=np.zeros(3, np.float32),
    action_scale=np.ones(3, np.float32),
    weights=(np.ones((11, 3), np.float32),),
    biases=(np.zeros(3, np.float32),),
    log_sigma=np.zeros(3, np.float32),
)
TASKED = replace(PLAIN, biases=(np.zeros((5, 3), np.float32),))


def complete(protocol: str = "sequential", policy: Policy = PLAIN) -> Change:
    """Adds the policies of every run, stage and task of a log."""
    names = policy_names(protocol, RUNS, group(f"{GROUP}-v0"))
    return all_of(*(put(f"{FOLDER}/{name}", policy.to_bytes()) for name in names))


def with_one(policy: Policy) -> Change:
    """A complete set of policies, of which one is another."""
    return all_of(complete(), put(POLICY, policy.to_bytes()))


EXAMPLES = (
    Example(
        "malformed-policy",
        "not the arrays of a policy",
        all_of(complete(), put(POLICY, replace(PLAIN).to_bytes().replace(b"log_sigma", b"log_sigmb"))),
        ((POLICY, "Unexpected array 'log_sigmb'.", WRITE),),
    ),
    Example(
        "foreign-policy",
        "a run that is not logged",
        all_of(complete(), put(POLICY.replace("run0", "run7"), PLAIN.to_bytes())),
        (
            (
                POLICY.replace("run0", "run7"),
                "sequential.csv has no run 7.",
                "Remove the policy, or add the run to the log.",
            ),
        ),
    ),
    Example(
        "foreign-policy",
        "a stage that does not exist",
        all_of(complete(), put(POLICY.replace("stage1", "stage6"), PLAIN.to_bytes())),
        ((POLICY.replace("stage1", "stage6"), "sequential.csv has no stage 6.", "Remove the policy."),),
    ),
    Example(
        "missing-policy",
        "one stage of one run",
        all_of(complete(), remove(POLICY)),
        ((POLICY, "sequential.csv has other policies, but not this one.", "Add the policy."),),
    ),
    Example(
        "missing-policy",
        "one task of the single protocol",
        all_of(complete("single"), remove(f"{FOLDER}/single-run1-stage1-HopperGravityHalf.npz")),
        (
            (
                f"{FOLDER}/single-run1-stage1-HopperGravityHalf.npz",
                "single.csv has other policies, but not this one.",
                "Add the policy.",
            ),
        ),
    ),
    Example(
        "different-policies",
        "another number of observations",
        with_one(replace(PLAIN, weights=(np.ones((17, 3), np.float32),))),
        (
            (
                POLICY,
                "The policy has 17 observations; the first of the group has 11.",
                "Add the policies of this group.",
            ),
        ),
    ),
    Example(
        "policy-observes-task",
        "arrays per task of an agent that does not observe the task",
        with_one(TASKED),
        (
            (
                POLICY,
                "The policy depends on the task.",
                "Set [observes] task_in_evaluation = true, or use the same arrays for all tasks.",
            ),
        ),
    ),
    Example(
        "policy-observes-task",
        "rows of more tasks than the group has",
        all_of(
            edit("task_in_evaluation = false", "task_in_evaluation = true", TOML),
            with_one(replace(PLAIN, biases=(np.zeros((6, 3), np.float32),))),
        ),
        (
            (
                POLICY,
                "The policy has arrays for 6 tasks of 5.",
                "Store one row per task of the group.",
            ),
        ),
    ),
    Example(
        "sampled-policy",
        "a gaussian policy of an agent that is evaluated deterministically",
        all_of(
            edit('evaluation = "sampled"', 'evaluation = "deterministic"', TOML),
            with_one(replace(PLAIN, head="gaussian")),
        ),
        (
            (
                POLICY,
                "The head of the policy is 'gaussian'.",
                'Store the head that acts in evaluation, or set [protocol] evaluation = "sampled".',
            ),
        ),
    ),
    Example(
        "too-large",
        "a policy file above its limit",
        all_of(complete(), put(POLICY, bytes(MAX_POLICY_BYTES + 1))),
        (
            (
                POLICY,
                "The file has 2097153 bytes; the limit is 2097152.",
                "Leave out everything that the format does not need.",
            ),
        ),
    ),
    *(
        Example(
            "unexpected-name",
            title,
            put(f"{FOLDER}/{name}.npz", PLAIN.to_bytes()),
            ((f"{FOLDER}/{name}.npz", "Unexpected file.", RENAME),),
            also=tuple(also),
        )
        for title, name, *also in (
            ("a policy of no run", "policy"),
            ("the task in the sequential protocol", "sequential-run0-stage1-Hopper", "missing-policy"),
            ("the single protocol without a task", "single-run0-stage1", "missing-policy"),
            ("a task of another group", "single-run0-stage1-Walker2d", "missing-policy"),
        )
    ),
)


@parametrize(EXAMPLES)
def test_the_rule_reports_these_problems_and_no_other(example: Example, check: Check) -> None:
    check(example)


def test_complete_policies_of_any_logs_break_no_rule(good: CopySubmission, tmp_path: Path) -> None:
    folder = good(GROUP, tmp_path)
    complete()(folder)
    assert read(folder).problems == ()
    complete("single", replace(PLAIN, head="gaussian"))(folder)
    assert read(folder).problems == ()


def test_an_agent_that_observes_the_task_may_have_arrays_per_task(
    submission: Callable[..., Path],
) -> None:
    folder = submission()
    edit("task_in_evaluation = false", "task_in_evaluation = true", TOML)(folder)
    complete(policy=TASKED)(folder)
    assert read(folder).problems == ()
