"""Every rule about policies reports its mistake."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gym_extensions.catalog.groups import group
from gym_extensions.submissions.policies.files import (
    Key,
    content_sha256,
    npz_arrays,
    policy_keys,
    run_arrays,
    write_policies,
)
from gym_extensions.submissions.policies.mlp import Policy
from gym_extensions.submissions.reader import read

from ..examples import DOCUMENT, POLICIES, TOML, Change, Example, all_of, arrays, document, edit, put

NOT_A_ZIP = b"PK" * 500
RUN = POLICIES.removesuffix(".npz")
PLAIN = Policy(np.zeros(3), np.ones(3), weights=(np.ones((11, 3)),), biases=(np.zeros(3),))
WIDE = Policy(np.zeros(3), np.ones(3), weights=(np.ones((12, 3)),), biases=(np.zeros(3),))
FEW = Policy(np.zeros(2), np.ones(2), weights=(np.ones((11, 2)),), biases=(np.zeros(2),))
RANDOM = np.random.default_rng(0)
DRAWN = Policy(np.zeros(3), np.ones(3), weights=(RANDOM.normal(size=(11, 3)),), biases=(np.zeros(3),))
NOISE = 1e-3 * RANDOM.normal(size=(11, 3))
NOISY = Policy(np.zeros(3), np.ones(3), weights=(DRAWN.weights[0] + NOISE,), biases=(np.ones(3),))
TASKED = Policy(np.zeros(3), np.ones(3), weights=(np.ones((2, 11, 3)),), biases=(np.zeros(3),))
FULL = Policy(np.zeros(3), np.ones(3), weights=(np.ones((5, 11, 3)),), biases=(np.zeros(3),))
MANY = Policy(np.zeros(3), np.ones(3), weights=(np.ones((9, 11, 3)),), biases=(np.zeros(3),))


def policies(policy: Policy, run: str = "run0", **others: Policy) -> Change:
    """Writes a policy for every stage but those that are named (``stage3``), and its digest."""
    path = POLICIES.replace("run0", run)

    def change(folder: Path) -> None:
        keys = policy_keys("sequential", group("hopper-gravity"))
        by_key: dict[Key, Policy] = {key: others.get(f"stage{key[0]}", policy) for key in keys}
        write_policies(folder / path, by_key)
        digest = content_sha256(run_arrays(by_key))
        document(path.replace(".npz", ".json"), policies__sha256=digest)(folder)

    return change


def without(name: str) -> Change:
    """Writes the policies without an array."""

    def change(folder: Path) -> None:
        content = npz_arrays((folder / POLICIES).read_bytes())
        kept = {full: values for full, values in content.items() if not full.startswith(name)}
        put(POLICIES, arrays(**kept))(folder)
        document(policies__sha256=content_sha256(kept))(folder)

    return change


OBSERVED = edit("task_in_evaluation = false", "task_in_evaluation = true", TOML)
DETERMINISTIC = edit('evaluation = "sampled"', 'evaluation = "deterministic"', TOML)

EXAMPLES = (
    Example("malformed-policies", "not a zip", put(POLICIES, NOT_A_ZIP), POLICIES, "cannot be read"),
    Example("malformed-policy", "a stage is missing", without("stage3/"), POLICIES, "stage3 is missing"),
    Example("malformed-policy", "an array is missing", without("stage3/head"), POLICIES, "'head' is missing"),
    Example(
        "malformed-policy",
        "arrays of no stage",
        put(POLICIES, arrays(weight_0=[1.0])),
        POLICIES,
        "'weight_0' belongs to no stage",
        also=("exchanged-policies",),
        count=7,
    ),
    Example(
        "exchanged-policies",
        "policies of another training",
        lambda folder: write_policies(
            folder / POLICIES, dict.fromkeys(policy_keys("sequential", group("hopper-gravity")), PLAIN)
        ),
        f"{DOCUMENT}, policies",
        "the document states",
    ),
    Example(
        "policies-of-another-group",
        "other observations",
        all_of(policies(PLAIN), policies(WIDE, "run1")),
        "hopper-gravity/sequential/run1, stage0",
        "12 observations and 3 actions; the first has 11",
        count=6,
    ),
    Example(
        "policies-of-another-group",
        "other actions",
        all_of(policies(PLAIN), policies(FEW, "run1")),
        "hopper-gravity/sequential/run1, stage0",
        "11 observations and 2 actions",
        count=6,
    ),
    Example("policy-observes-task", "undeclared", policies(TASKED), f"{RUN}, stage0", "task_in_", count=6),
    Example(
        "policy-observes-task",
        "a row for each task is right, more are not",
        all_of(OBSERVED, policies(TASKED, stage1=FULL, stage2=MANY)),
        f"{RUN}, stage2",
        "9 tasks of 5",
    ),
    Example(
        "nearly-equal-policies",
        "one stage with noise",
        all_of(policies(PLAIN, stage3=DRAWN), policies(PLAIN, "run1", stage3=NOISY)),
        "hopper-gravity/sequential/run1",
        "Run 0 has nearly the same policy at stage3",
    ),
    Example("sampled-policy", "a uniform one", DETERMINISTIC, f"{RUN}, stage0", "'uniform'", count=21),
)


def test_runs_of_an_agent_without_parameters_may_have_equal_policies(
    make_submission: Callable[..., Path],
) -> None:
    folder = make_submission(parameters=0)
    all_of(policies(DRAWN), policies(DRAWN, "run1"))(folder)
    assert read(folder, policies=True).problems == ()


@pytest.mark.parametrize("data", [NOT_A_ZIP, arrays(head=[{}])], ids=["not a zip", "a pickle"])
def test_a_file_that_is_no_archive_of_numbers_is_a_problem_where_no_policy_is_read(
    make_submission: Callable[..., Path], data: bytes
) -> None:
    folder = make_submission()
    put(POLICIES, data)(folder)
    for whole in (False, True):
        problems = read(folder, policies=whole).problems
        assert [(each.rule, each.where) for each in problems] == [("malformed-policies", POLICIES)]


def test_policies_are_read_only_if_that_is_asked(make_submission: Callable[..., Path]) -> None:
    folder = make_submission()
    put(POLICIES, arrays(weight_0=[1.0]))(folder)
    assert read(folder).problems == ()
    assert {problem.where for problem in read(folder, policies=True).problems} >= {POLICIES}
