"""Every rule about policies reports its mistake."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

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

from ..examples import DOCUMENT, POLICIES, TOML, Change, Table, all_of, arrays, document, edit, put

NOT_A_ZIP = b"PK" * 500
RUN = POLICIES.removesuffix(".npz")
KEYS = policy_keys("sequential", group("hopper-gravity"))


def linear(weights: NDArray[np.float64], bias: float = 0.0) -> Policy:
    actions = weights.shape[-1]
    return Policy(np.zeros(actions), np.ones(actions), weights=(weights,), biases=(np.full(actions, bias),))


PLAIN, WIDE, FEW = (linear(np.ones(shape)) for shape in ((11, 3), (12, 3), (11, 2)))
TASKED, FULL, MANY = (linear(np.ones((tasks, 11, 3))) for tasks in (2, 5, 9))
DRAWN = linear(np.random.default_rng(0).normal(size=(11, 3)))
NOISY = linear(DRAWN.weights[0] + 1e-3 * np.random.default_rng(1).normal(size=(11, 3)), bias=1.0)


def policies(policy: Policy, run: str = "run0", **others: Policy) -> Change:
    """Writes a policy for every stage but those that are named (``stage3``), and its digest."""
    path = POLICIES.replace("run0", run)

    def change(folder: Path) -> None:
        by_key: dict[Key, Policy] = {key: others.get(f"stage{key[0]}", policy) for key in KEYS}
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
OTHER = "hopper-gravity/sequential/run1"


def of_another_training(folder: Path) -> None:
    write_policies(folder / POLICIES, dict.fromkeys(KEYS, PLAIN))


EXAMPLES: Table = {
    "malformed-policies": [("not a zip", put(POLICIES, NOT_A_ZIP), POLICIES, "cannot be read")],
    "malformed-policy": [
        ("no stage", without("stage3/"), POLICIES, "stage3 is missing"),
        ("no array", without("stage3/head"), POLICIES, "'head' is missing"),
        (
            *("arrays of no stage", put(POLICIES, arrays(weight_0=[1.0])), POLICIES),
            *("'weight_0' belongs to no stage", ("exchanged-policies",), 7),
        ),
    ],
    "exchanged-policies": [
        ("of another training", of_another_training, f"{DOCUMENT}, policies", "the document states"),
    ],
    "policies-of-another-group": [
        (
            *("other observations", all_of(policies(PLAIN), policies(WIDE, "run1")), f"{OTHER}, stage0"),
            *("12 observations and 3 actions; the first has 11", (), 6),
        ),
        (
            *("other actions", all_of(policies(PLAIN), policies(FEW, "run1")), f"{OTHER}, stage0"),
            *("11 observations and 2 actions", (), 6),
        ),
    ],
    "policy-observes-task": [
        ("undeclared", policies(TASKED), f"{RUN}, stage0", "task_in_", (), 6),
        (
            *("more rows than tasks", all_of(OBSERVED, policies(TASKED, stage1=FULL, stage2=MANY))),
            *(f"{RUN}, stage2", "9 tasks of 5"),
        ),
    ],
    "nearly-equal-policies": [
        (
            *("noise", all_of(policies(PLAIN, stage3=DRAWN), policies(PLAIN, "run1", stage3=NOISY)), OTHER),
            "Run 0 has nearly the same policy at stage3",
        ),
    ],
    "sampled-policy": [("a uniform one", DETERMINISTIC, f"{RUN}, stage0", "'uniform'", (), 21)],
}


@pytest.mark.parametrize(("first", "is_problem"), [(DRAWN, False), (PLAIN, True)], ids=["never", "once"])
def test_runs_may_have_equal_policies_only_if_their_weights_never_change(
    make_submission: Callable[..., Path], first: Policy, is_problem: bool
) -> None:
    folder = make_submission(parameters=0)  # what documents state does not matter
    all_of(policies(DRAWN, stage0=first), policies(DRAWN, "run1", stage0=first))(folder)
    rules = {problem.rule for problem in read(folder, policies=True).problems}
    assert rules == ({"nearly-equal-policies"} if is_problem else set())


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
