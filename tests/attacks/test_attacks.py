"""Attacks on the truth of results by somebody who has the project's code: each stops as its row says.

An attack changes an honest submission. Its author may write logs, documents and policies anew. It is judged
as on the base branch: the rules, then verification with seeds that the author does not know. ``verified`` is
what no part of a verification can show. The rows are those of docs/security.md.
"""

import itertools
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from msgspec import structs

from gym_extensions.catalog.groups import group
from gym_extensions.submissions.fetch import Fetcher
from gym_extensions.submissions.policies.files import AnyPolicy, Key, read_policies
from gym_extensions.submissions.policies.mlp import Policy
from gym_extensions.submissions.reader import read
from gym_extensions.submissions.review import Review, write_review
from gym_extensions.submissions.run import Machine, PolicyFile, Versions, read_run
from gym_extensions.verification.episodes import Player
from gym_extensions.verification.verify import verify

from ..submissions.examples import TOML, edit
from ..verification import made_submissions as submissions
from ..verification.made_submissions import (
    GROUP,
    ONNX,
    Row,
    change_documents,
    change_log,
    change_policies,
    copy,
    honest,
    network,
)

PAGE = Path(__file__).resolve().parents[2] / "docs" / "security.md"
TASKS = group(GROUP).tasks
LAST = len(TASKS)
VALUE = "5e" * 20
REPETITION, NEW_SEEDS, POLICIES, TWINS, CLAIMED, VERIFIED = (
    "repetition",
    "new seeds",
    "policies",
    "one run twice",
    "claimed",
    "verified",
)
Forge = Callable[[Path], object]


@dataclass(frozen=True)
class Attack:
    """One attack: what its author does, what stops it, and from which honest submission it is made.

    An attack that is ``reviewed`` is made after the submission was verified.
    """

    title: str
    forge: Forge
    stop: str
    head: str = "deterministic"
    runs: int = 2
    reviewed: bool = False


def rows(edit: Callable[[Row], Mapping[str, object]], run: int | None = None) -> Forge:
    """Changes rows of the logs."""
    return lambda submission: change_log(submission, edit, run)


def returns(change: Callable[[float], float], where: Callable[[Row], bool] = lambda _: True) -> Forge:
    """Changes the returns of some rows."""
    return rows(lambda row: {"return": change(row["return"])} if where(row) else {})


def is_zero_shot(row: Row) -> bool:
    return bool(row["stage"] == [task.id for task in TASKS].index(row["task"]) > 0)


def is_just_trained(row: Row) -> bool:
    return bool(row["stage"] == [task.id for task in TASKS].index(row["task"]) + 1)


def first_row(**values: object) -> Forge:
    """Changes the first row of every log."""
    is_first = {"stage": 0, "task": TASKS[0].id, "episode": 0}

    def edit(row: Row) -> Mapping[str, object]:
        matches = all(row[name] == value for name, value in is_first.items())
        return {name.rstrip("_"): value for name, value in values.items()} if matches else {}

    return rows(edit)


def documents(change: Callable[..., Mapping[str, object]]) -> Forge:
    """Changes the documents of all runs."""
    return lambda submission: change_documents(submission, change)


OTHERS = itertools.count(9)
"""Seeds of other agents' networks, one per run: two runs with one policy would be one run twice."""


def policies(change: Callable[[dict[Key, AnyPolicy]], object]) -> Forge:
    """Changes the stored policies of all runs, and states their digests."""
    return lambda submission: change_policies(submission, change)


def without_policies(submission: Path) -> None:
    documents(lambda _: {"policies": None})(submission)
    for path in submission.glob("*/*/*.npz"):
        path.unlink()


def best_of(evaluations: int, by: str) -> Forge:
    """Logs the best of several evaluations of sampled policies: of every episode, or of every cell."""

    def forged(submission: Path) -> None:
        rng, spread = np.random.default_rng(0), 4.0
        draws = {"episode": 20, "cell": 1}[by]
        noise = rng.normal(0, spread, (evaluations, 10_000, draws)).max(axis=0).ravel().tolist()
        change_log(submission, lambda row: {"return": row["return"] + abs(noise.pop())})

    return forged


def one_policy_everywhere(submission: Path) -> None:
    """Every stage is a policy that was chosen for one task."""
    for document in submission.glob("*/*/*.json"):
        run = read_run(document).run
        chosen = network(700 + run)
        stored = read_policies(submission, group(GROUP), "sequential", run)
        submissions.write_run_files(submission, "sequential", run, stored, dict.fromkeys(stored, chosen))


def one_run_many_times(submission: Path) -> None:
    """Makes all runs from run 0 by noise on the weights, and evaluates each honestly."""
    first, rng = read_policies(submission, group(GROUP), "sequential", 0), np.random.default_rng(0)
    for document in submission.glob("*/*/*.json"):
        noisy = {
            key: replace(
                policy,
                weights=tuple(each * (1 + 1e-3 * rng.normal(size=each.shape)) for each in policy.weights),
            )
            for key, policy in first.items()
            if isinstance(policy, Policy)
        }
        submissions.write_run_files(submission, "sequential", read_run(document).run, noisy)


def per_task(stored: dict[Key, AnyPolicy]) -> None:
    """Packs two policies as one with weights per task."""
    for key, policy in stored.items():
        assert isinstance(policy, Policy)
        pair = np.stack([policy.weights[0], policy.weights[0] + 1])
        stored[key] = Policy(**{**vars(policy), "weights": (pair,)})


def swap(stored: dict[Key, AnyPolicy]) -> None:
    stored[LAST, None], stored[0, None] = stored[0, None], stored[LAST, None]


def invented_without_policies(submission: Path) -> None:
    returns(lambda value: 2 * value)(submission)
    without_policies(submission)


RAISED = returns(lambda value: value * (1 + 1e-7))
LOWERED = returns(lambda value: value - 9, is_just_trained)


def stated(first: Forge = RAISED, **values: object) -> Forge:
    """Changes returns, and what the documents state of the machine or the evaluation."""

    def forged(submission: Path) -> None:
        first(submission)
        versions = {name: value for name, value in values.items() if name in Versions.__struct_fields__}
        own = {name: value for name, value in values.items() if name not in versions}
        change_documents(
            submission, lambda run: {"versions": structs.replace(run.versions, **versions), **own}
        )

    return forged


ATTACKS = (
    Attack(
        "All returns are scaled by 1.1 in the log, with digests to match.",
        returns(lambda value: 1.1 * value),
        REPETITION,
    ),
    Attack(
        "All returns are raised by a ten-millionth, less than the tolerance of replay.",
        RAISED,
        REPETITION,
    ),
    Attack(
        "All returns are raised by a ten-millionth, and the documents state another machine.",
        stated(platform="Darwin-arm64", blas="openblas Zen"),
        REPETITION,
    ),
    Attack(
        "All returns are raised by a ten-millionth, and the documents state the first arithmetic.",
        stated(arithmetic=1),
        CLAIMED,
    ),
    Attack(
        "All returns are raised by a ten-millionth, and the documents name a runtime of networks.",
        stated(packages={"onnxruntime": "0.1"}),
        REPETITION,
    ),
    *(
        Attack(
            f"Returns of networks right after training are lowered; the documents state another {what}.",
            stated(LOWERED, **{key: value}),
            stop,
            head=ONNX,
        )
        for what, stop, key, value in (
            ("BLAS", REPETITION, "blas", "openblas Zen"),
            ("processor", VERIFIED, "machine", Machine(processor="Zen", cores=1)),
            ("system", VERIFIED, "platform", "Darwin-arm64"),
            ("version of onnxruntime", VERIFIED, "packages", {"onnxruntime": "0.1"}),
        )
    ),
    Attack(
        "The returns of the last stage are raised.",
        returns(lambda value: value + 50, lambda row: row["stage"] == LAST),
        REPETITION,
    ),
    Attack(
        "One run of five is invented.",
        rows(lambda row: {"return": 90.0 + row["episode"]}, run=3),
        REPETITION,
        runs=5,
    ),
    Attack("One episode of the log is invented.", first_row(return_=17.0), REPETITION),
    Attack(
        "The lengths of the log are one step longer.",
        rows(lambda row: {"length": row["length"] + 1}),
        REPETITION,
    ),
    Attack("A return is beyond what the task can give.", first_row(return_=1e6), "impossible-return"),
    Attack("All returns are invented, and no policies are published.", invented_without_policies, CLAIMED),
    Attack(
        "The best stage is logged as the last one, with the policies of the stated stages.",
        policies(swap),
        REPETITION,
    ),
    Attack(
        "Experts of single tasks are logged as the last stage, with the policies of the stages.",
        one_policy_everywhere,
        REPETITION,
    ),
    Attack(
        "The policy files are those of another agent.",
        policies(lambda stored: stored.update(dict.fromkeys(stored, network(next(OTHERS))))),
        REPETITION,
    ),
    Attack(
        "The policy files are uniform, and the manifest says sampled.",
        policies(
            lambda stored: stored.update(
                dict.fromkeys(stored, Policy(np.zeros(3), np.ones(3), head="uniform"))
            )
        ),
        NEW_SEEDS,
        head="gaussian",
    ),
    Attack(
        "The policy files are Gaussians that any action agrees with.",
        policies(lambda stored: stored.update(dict.fromkeys(stored, network(next(OTHERS), "gaussian")))),
        NEW_SEEDS,
        head="gaussian",
    ),
    Attack("Experts are packed as one policy with weights per task.", policies(per_task), POLICIES),
    Attack(
        "The digest of the policy files is that of others.",
        documents(lambda run: {"policies": PolicyFile(sha256="0" * 64, size=run.policies.size)}),
        POLICIES,
    ),
    Attack(
        "The better of two evaluations of every episode.", best_of(2, "episode"), NEW_SEEDS, head="gaussian"
    ),
    Attack(
        "The best of five evaluations of every episode.", best_of(5, "episode"), NEW_SEEDS, head="gaussian"
    ),
    Attack("The best of ten evaluations of every cell.", best_of(10, "cell"), NEW_SEEDS, head="gaussian"),
    Attack(
        "Zero-shot transfer is invented: the returns on every task right before its training.",
        returns(lambda value: value + 50, is_zero_shot),
        NEW_SEEDS,
        head="gaussian",
    ),
    Attack("All runs are made from one, by noise of a thousandth of the weights.", one_run_many_times, TWINS),
    Attack("Tuning is said to have cost nothing.", lambda submission: submission, VERIFIED),
    *(
        Attack(f"After the verification, {what} is edited.", edit(*words, TOML), CLAIMED, reviewed=True)
        for what, words in {
            "the budget": ('"100k"', '"300k"'),
            "the algorithm": ('"formula"', '"trpo"'),
            "a hyperparameter": ("step = 0.01", "step = 0.02"),
            "the cost of tuning": ("steps = 0", "steps = 1"),
        }.items()
    ),
    Attack(
        "After the verification, curves, steps and costs of the documents are edited.",
        documents(lambda run: {"steps": run.steps // 2, "cpu_seconds": 1.0}),
        CLAIMED,
        reviewed=True,
    ),
)


STORES = Player(submissions.CACHE / "verify"), Fetcher(submissions.CACHE / "policies")


def stop_of(submission: Path) -> str:
    """What stops a submission, or ``verified``."""
    judged = read(submission)
    if judged.problems:
        return " ".join(problem.rule for problem in judged.problems)
    report = verify(judged, VALUE, *STORES)
    found = report.verification
    if found is None:
        return CLAIMED
    if found.passed:
        return VERIFIED
    if not report.means:
        return POLICIES
    is_refused = found.second_p_value is not None and max(found.p_value, found.second_p_value) <= 0.004
    is_other = any(each.difference and not each.other_machine for each in report.repetitions.values())
    return REPETITION if is_other else NEW_SEEDS if is_refused else TWINS if report.twins else "?"


@pytest.mark.usefixtures("in_this_process")
@pytest.mark.parametrize("attack", ATTACKS, ids=lambda attack: attack.title)
def test_an_attack_stops_where_its_row_says(attack: Attack, tmp_path: Path) -> None:
    for package in ("torch", "onnx", "onnxruntime") if attack.head == ONNX else ():
        pytest.importorskip(package, reason="needs the extra onnx")
    submission = copy(honest(attack.head, attack.runs), tmp_path / "attack")
    if attack.reviewed:
        report = verify(read(submission), VALUE, *STORES)
        assert report.verification is not None
        write_review(submission, Review(verifications=[report.verification]))
        assert submissions.level_of(submission) == VERIFIED
        attack.forge(submission)
        assert submissions.level_of(submission) == attack.stop
        return
    attack.forge(submission)
    assert attack.stop in stop_of(submission)


def test_the_attacks_are_the_rows_that_name_them() -> None:
    text = PAGE.read_text(encoding="utf-8")
    named = re.findall(r"^\| (.+?) \| .* \| attacks \|$", text, re.MULTILINE)
    assert sorted(named) == sorted(attack.title for attack in ATTACKS)
