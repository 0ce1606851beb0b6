"""Attacks on the truth of results by somebody who has the project's code: each stops as its row says.

An attack changes an honest entry. Its author may write logs, documents and policies anew. It is judged as on
the base branch: the rules, then verification with seeds that the author does not know. ``verified`` with a
reason is what no part of a verification can show.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from gym_extensions.catalog.groups import group
from gym_extensions.rollouts.policies.files import AnyPolicy, Key, read_policies
from gym_extensions.rollouts.policies.mlp import Policy
from gym_extensions.rollouts.run import PolicyFile, read_run
from gym_extensions.verification.episodes import Store
from gym_extensions.verification.fetch import Fetcher
from gym_extensions.verification.verify import verify

from ..verification import entries
from ..verification.entries import (
    GROUP,
    RUNS,
    Row,
    change_documents,
    change_log,
    change_policies,
    copy,
    honest,
    move_elsewhere,
    network,
)

TASKS = group(GROUP).tasks
LAST = len(TASKS)
VALUE = "5e" * 20
REPETITION, NEW_SEEDS, POLICIES, CLAIMED, VERIFIED = (
    "repetition",
    "new seeds",
    "policies",
    "claimed",
    "verified",
)
Forge = Callable[[Path], object]


@dataclass(frozen=True)
class Attack:
    """One attack: what its author does, what stops it, and from which honest entry it is made."""

    title: str
    forge: Forge
    stop: str
    head: str = "deterministic"


def rows(edit: Callable[[Row], Mapping[str, object]], run: int | None = None) -> Forge:
    """Changes rows of the logs."""
    return lambda entry: change_log(entry, edit, run)


def returns(change: Callable[[float], float], where: Callable[[Row], bool] = lambda _: True) -> Forge:
    """Changes the returns of some rows."""
    return rows(lambda row: {"return": change(row["return"])} if where(row) else {})


def first_row(**values: object) -> Forge:
    """Changes the first row of every log."""
    is_first = {"stage": 0, "task": TASKS[0].id, "episode": 0}

    def edit(row: Row) -> Mapping[str, object]:
        matches = all(row[name] == value for name, value in is_first.items())
        return {name.rstrip("_"): value for name, value in values.items()} if matches else {}

    return rows(edit)


def elsewhere(forge: Forge) -> Forge:
    """The same, and the documents say that the runs were made with other processor kernels."""

    def forged(entry: Path) -> None:
        forge(entry)
        move_elsewhere(entry)

    return forged


def documents(change: Callable[..., Mapping[str, object]]) -> Forge:
    """Changes the documents of all runs."""
    return lambda entry: change_documents(entry, change)


def policies(change: Callable[[dict[Key, AnyPolicy]], object]) -> Forge:
    """Changes the stored policies of all runs, and states their digests."""
    return lambda entry: change_policies(entry, change)


def without_policies(entry: Path) -> None:
    documents(lambda _: {"policies": None})(entry)
    for path in entry.glob("*/*/*.npz"):
        path.unlink()


def manifest(old: str, new: str) -> Forge:
    """Changes the text of the manifest."""

    def forged(entry: Path) -> None:
        path = entry / "submission.toml"
        text, count = re.subn(old, lambda _: new, path.read_text(), count=1)
        assert count == 1
        path.write_text(text, encoding="utf-8")

    return forged


def best_of(evaluations: int, by: str) -> Forge:
    """Logs the best of several evaluations of sampled policies: of every episode, or of every cell."""

    def forged(entry: Path) -> None:
        rng, spread = np.random.default_rng(0), 4.0
        draws = {"episode": 20, "cell": 1}[by]
        noise = rng.normal(0, spread, (evaluations, 10_000, draws)).max(axis=0).ravel().tolist()
        change_log(entry, lambda row: {"return": row["return"] + abs(noise.pop())})

    return forged


def one_policy_everywhere(entry: Path) -> None:
    """Every stage is a policy that was chosen for one task."""
    for run in RUNS:
        chosen = network(700 + run)
        stored = read_policies(entry, group(GROUP), "sequential", run)
        entries.write_run_files(entry, "sequential", run, stored, dict.fromkeys(stored, chosen))


def files(name: str, text: str) -> Forge:
    """Adds a file."""
    return lambda entry: (entry / name).write_text(text, encoding="utf-8")


def same_run_five_times(entry: Path) -> None:
    for suffix in ("csv", "npz"):
        for run in RUNS[1:]:
            shutil.copyfile(
                entry / GROUP / "sequential" / f"run0.{suffix}",
                entry / GROUP / "sequential" / f"run{run}.{suffix}",
            )
    first = read_run(entry / GROUP / "sequential" / "run0.json")
    documents(lambda run: {"log": first.log, "policies": first.policies})(entry)


def per_task(stored: dict[Key, AnyPolicy]) -> None:
    """Packs two policies as one with weights per task."""
    for key, policy in stored.items():
        assert isinstance(policy, Policy)
        pair = np.stack([policy.weights[0], policy.weights[0] + 1])
        stored[key] = Policy(**{**vars(policy), "weights": (pair,)})


def swap(stored: dict[Key, AnyPolicy]) -> None:
    stored[LAST, None], stored[0, None] = stored[0, None], stored[LAST, None]


UP = returns(lambda value: 1.3 * value + 5)


def raised_without_policies(entry: Path) -> None:
    UP(entry)
    without_policies(entry)


ATTACKS = (
    Attack("All returns are raised.", UP, REPETITION),
    Attack("All returns are raised by somebody with other kernels.", elsewhere(UP), NEW_SEEDS),
    Attack("All returns are raised by a billionth.", returns(lambda value: value * (1 + 1e-9)), REPETITION),
    Attack(
        "All returns are raised by a billionth by somebody with other kernels.",
        elsewhere(returns(lambda value: value * (1 + 1e-9))),
        VERIFIED,
    ),
    Attack(
        "The returns of the last stage are raised.",
        returns(lambda value: value + 50, lambda row: row["stage"] == LAST),
        REPETITION,
    ),
    Attack(
        "The returns of the last stage are raised elsewhere.",
        elsewhere(returns(lambda value: value + 50, lambda row: row["stage"] == LAST)),
        NEW_SEEDS,
    ),
    Attack(
        "One run of five is invented.", rows(lambda row: {"return": 90.0 + row["episode"]}, run=3), REPETITION
    ),
    Attack(
        "One run of five is invented elsewhere.",
        elsewhere(rows(lambda row: {"return": 90.0 + row["episode"]}, run=3)),
        NEW_SEEDS,
    ),
    Attack("One episode is invented.", first_row(return_=17.0), REPETITION),
    Attack("The lengths are one step longer.", rows(lambda row: {"length": row["length"] + 1}), REPETITION),
    Attack("A return is beyond what the task can give.", first_row(return_=1e6), "impossible-return"),
    Attack("A return is infinite.", first_row(return_=float("inf")), "not-finite"),
    Attack("A seed is another one.", first_row(seed=1), "wrong-seed"),
    Attack("An episode is longer than the time limit.", first_row(length=1001), "impossible-length"),
    Attack(
        "A fall is logged as an episode that goes on.",
        rows(lambda _: {"terminated": False}),
        "unfinished-episode",
    ),
    Attack("Success is claimed where none is defined.", rows(lambda _: {"success": 1}), "undefined-success"),
    Attack(
        "Another model is stated.",
        documents(lambda run: {"fingerprints": dict.fromkeys(run.fingerprints, "0" * 16)}),
        "foreign-fingerprint",
    ),
    Attack("All returns are raised, and no policies are published.", raised_without_policies, CLAIMED),
    Attack("The policies of the first and the last stage are exchanged.", policies(swap), REPETITION),
    Attack(
        "The policies are those of another agent.",
        policies(lambda stored: stored.update(dict.fromkeys(stored, network(9)))),
        REPETITION,
    ),
    Attack(
        "The policies act at random.",
        policies(
            lambda stored: stored.update(
                dict.fromkeys(stored, Policy(np.zeros(3), np.ones(3), head="uniform"))
            )
        ),
        POLICIES,
    ),
    Attack(
        "The policies are Gaussians as wide as the action space.",
        policies(lambda stored: stored.update(dict.fromkeys(stored, network(9, "gaussian")))),
        POLICIES,
    ),
    Attack("Experts are packed as one policy with weights per task.", policies(per_task), POLICIES),
    Attack(
        "The digest of the policies is that of others.",
        documents(lambda run: {"policies": PolicyFile(sha256="0" * 64, size=run.policies.size)}),
        POLICIES,
    ),
    Attack(
        "The policies of one run are missing.",
        lambda entry: (entry / GROUP / "sequential" / "run2.npz").unlink(),
        "different-policies",
    ),
    Attack("A policy of stage 1 is logged as that of every stage.", one_policy_everywhere, REPETITION),
    Attack(
        "The better of two evaluations of every episode is logged.",
        best_of(2, "episode"),
        NEW_SEEDS,
        "gaussian",
    ),
    Attack(
        "The best of ten evaluations of every episode is logged.",
        best_of(10, "episode"),
        NEW_SEEDS,
        "gaussian",
    ),
    Attack(
        "The best of ten evaluations of every cell is logged.", best_of(10, "cell"), NEW_SEEDS, "gaussian"
    ),
    Attack("One run is logged five times.", same_run_five_times, "identical-runs"),
    Attack(
        "A review of the author's own is in the folder, with a typing error.",
        files("review.toml", "levle = 1\n"),
        "malformed-review",
    ),
    Attack(
        "The README has characters that hide text.", files("README.md", "Fine\u202e.\n"), "readme-character"
    ),
    Attack(
        "The manifest has a key of its own.",
        manifest("format = 1", 'format = 1\nlevel = "reproduced"'),
        "unknown-key",
    ),
    Attack(
        "A log is presented as a published table.",
        manifest("format = 1", 'format = 1\nreported = "henderson2017"'),
        "unknown-report",
    ),
    Attack(
        "The title has a character that turns text around.",
        manifest("An entry", "An\u202eentry"),
        "control-character",
    ),
    Attack(
        "The code's address is a script.", manifest('url = ""', 'url = "javascript:alert(1)"'), "bad-value"
    ),
    Attack(
        "The evaluation is none of the two kinds.",
        manifest('evaluation = "\\w+"', 'evaluation = "lucky"'),
        "bad-value",
    ),
    Attack("Tuning is said to have cost nothing.", manifest("steps = 0", "steps = 0"), VERIFIED),
)


def stop_of(entry: Path, cache: Path) -> str:
    """What stops an entry, or ``verified``."""
    report = verify(entry, VALUE, Store(cache / "verify"), Fetcher(cache / "policies"))
    if report.problems:
        return " ".join(problem.rule for problem in report.problems)
    found = report.verification
    if found is None:
        return CLAIMED
    if found.passed:
        return VERIFIED
    if not report.means:
        return POLICIES
    is_refused = found.second_p_value is not None and max(found.p_value, found.second_p_value) <= 0.004
    is_other = any(each.difference and name not in report.machines for name, each in report.runs.items())
    return REPETITION if is_other else NEW_SEEDS if is_refused else "?"


@pytest.mark.usefixtures("in_this_process")
@pytest.mark.parametrize("attack", ATTACKS, ids=lambda attack: attack.title)
def test_an_attack_stops_where_its_row_says(attack: Attack, tmp_path: Path) -> None:
    entry = copy(honest(attack.head), tmp_path / "attack")
    attack.forge(entry)
    assert attack.stop in stop_of(entry, tmp_path)
