"""Duplicates: submissions that share most of their episodes, whatever was changed in the copy."""

from collections.abc import Callable
from dataclasses import replace
from shutil import rmtree

import msgspec
import pytest

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.references import References
from gym_extensions.scoring.group_score import Sketch
from gym_extensions.scoring.pipeline import score_folder
from gym_extensions.scoring.ranking.copies import (
    duplicate_submissions,
    duplicates,
    is_common,
    unusually_alike,
)
from gym_extensions.scoring.ranking.group_board import board
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.scoring.submission.scorer import run_sketches
from gym_extensions.submissions.reader import read
from gym_extensions.submissions.review import Decision
from gym_extensions.submissions.run import PolicyFile

from ...conftest import Value, Write, trained_here
from ..made_submissions import FIVE, GROUP, KEY, Enter, at_level, names

RUNS = (0, 1, 2)


def sketch(*numbers: int) -> Sketch:
    return tuple(f"{number:08x}" for number in numbers)


def honest(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
    """Returns without a common episode between runs."""
    return 7.0 * stage + 100.0 * run + 31.0 * position + episode / 8 + 0.123456


@pytest.fixture
def sketches(make_submission: Write) -> Callable[..., tuple[Sketch, ...]]:
    def make(name: str, value: Value = honest, runs: tuple[int, ...] = RUNS) -> tuple[Sketch, ...]:
        folder = make_submission(name=name, value=value, runs=runs, protocols=("sequential",))
        return run_sketches(read(folder).groups[GROUP], "sequential")

    return make


COPIES: dict[str, Value] = {
    "noise": lambda *key: honest(*key) * (1 + 3e-13),
    "runs in another order": lambda p, run, *key: honest(p, 2 - run, *key),
    "a fifth invented": lambda *key: honest(*key) + (50.0 if key[-1] % 5 == 0 else 0.0),
    "two fifths invented": lambda *key: honest(*key) + (50.0 if key[-1] % 5 < 2 else 0.0),
    "one run invented": lambda p, run, *key: honest(p, run, *key) + (55.0 if run == 1 else 0.0),
    "further runs": honest,
    "other early stages": lambda p, run, stage, *key: honest(p, run, stage, *key) + 1.5 * (stage < 5),
}
OTHERS: dict[str, Value] = {
    "shifted": lambda *key: honest(*key) + 0.05,
    "same early stages": lambda p, run, stage, *key: honest(p, run, stage, *key) + 1.5 * (stage == 5),
}


@pytest.mark.parametrize("change", COPIES)
def test_a_changed_copy_is_recognized(sketches: Callable[..., tuple[Sketch, ...]], change: str) -> None:
    runs = tuple(range(8)) if change == "further runs" else RUNS
    submissions = {"copy": sketches("copy", COPIES[change], runs), "original": sketches("original")}
    assert duplicate_submissions(submissions) == {"original": "copy"}


@pytest.mark.parametrize("change", OTHERS)
def test_other_episodes_after_the_last_stage_are_another_submission(
    sketches: Callable[..., tuple[Sketch, ...]], change: str
) -> None:
    """Methods that differ from the second task on share the episodes of the first stages."""
    assert duplicate_submissions({"a": sketches("a"), "b": sketches("b", OTHERS[change])}) == {}


def test_the_last_task_does_not_count(sketches: Callable[..., tuple[Sketch, ...]]) -> None:
    """Methods that only differ in what they keep of earlier tasks have equal episodes on it."""

    def other_on(task: int) -> Value:
        return lambda *key: honest(*key) + 50.0 * (key[3] == task)

    assert sketches("last", other_on(5)) == sketches("plain")
    assert sketches("fourth", other_on(4)) != sketches("same")


def test_in_navigation_a_copy_has_the_same_policies(make_submission: Write) -> None:
    """Agents that stand still have equal episodes there: those show nothing."""
    folder = make_submission(value=lambda protocol, run, *_: 1.0 + run, runs=RUNS, protocols=("sequential",))
    submission = replace(read(folder).groups[GROUP], group=GROUPS["nav-state"])

    def published(digest: str | None) -> tuple[Sketch, ...]:
        runs = {
            run: msgspec.structs.replace(document, policies=digest and PolicyFile(sha256=digest * 64, size=1))
            for run, document in submission.runs["sequential"].items()
        }
        return run_sketches(replace(submission, runs={"sequential": runs}), "sequential")

    assert duplicate_submissions({"still": published("a"), "other": published("b")}) == {}
    assert duplicate_submissions({"still": published("a"), "copy": published("a")}) == {"copy": "still"}
    assert duplicate_submissions({"still": published(None), "other": published(None)}) == {}


def test_failed_runs_make_no_copy(make_submission: Write, references: References) -> None:
    """In the place of each lies the same run of the agent ``zero``."""

    def trained(name: str, runs: tuple[int, ...], shift: float) -> Scorecard:
        def value(protocol: str, run: int, *key: int) -> float:
            return 5.0 + key[-1] / 8 if run == 0 else honest(protocol, run, *key) + shift

        folder = make_submission(name=name, value=value, runs=runs, protocols=("sequential",))
        trained_here(folder, failed={"hopper-gravity/sequential/run0": "too late"})
        rmtree(folder / "hopper-gravity")
        return score_folder(folder, references)

    cards = [trained("half", (0, 1), 0.0), trained("one", FIVE, 3.0)]
    assert duplicates(cards, replace(KEY, budget="smoke")) == {}


def test_an_equal_sequential_log_is_a_copy_and_an_equal_single_or_joint_log_is_not(enter: Enter) -> None:
    cards = [enter(name, 500, protocols=("sequential", "single", "joint")) for name in "ab"]
    for protocol, original in (("sequential", "a"), ("single", None), ("joint", None)):
        first, second = board(cards, replace(KEY, protocol=protocol)).rows
        assert (first.duplicate_of, second.duplicate_of) == (None, original), protocol
        assert (first.ranked, second.ranked) == (True, original is None), protocol


def test_a_copy_follows_the_first_by_name_without_a_rank(enter: Enter) -> None:
    made = board([enter(name, 500) for name in ("original", "copied", "again")] + [enter("other", 501)], KEY)
    assert names(made) == ["other", "again", "copied", "original"]
    assert [row.duplicate_of for row in made.rows] == [None, None, "again", "again"]
    assert [row.ranked for row in made.rows] == [True, True, False, False]
    assert "again" in made.rows[2].why


def test_of_identical_submissions_the_verified_one_counts_then_the_one_accepted_first(enter: Enter) -> None:
    def accepted(name: str, date: str) -> Scorecard:
        return replace(
            enter(name, 500), decisions=(Decision(action="accepted", by="M.", date=date, reason=""),)
        )

    for first, second in (
        (at_level(enter("a", 500), "claimed"), enter("b", 500)),
        (accepted("a", "2026-02-01"), accepted("b", "2026-01-01")),
        (enter("a", 500), accepted("b", "2026-01-01")),
    ):
        rows = board([first, second], KEY).rows
        assert [(row.name, row.duplicate_of) for row in rows] == [("b", None), ("a", "b")]


@pytest.mark.parametrize(("count", "expected"), [(16, True), (6, True), (5, False), (0, False)])
def test_with_half_of_the_episodes_in_common_a_third_of_all_digests_is(count: int, expected: bool) -> None:
    first = sketch(*range(16))
    second = sketch(*sorted([*range(count), *range(100, 116 - count)]))
    assert is_common(first, second) == expected


def test_each_duplicate_names_the_first_submission_that_it_copies() -> None:
    one, two = [sketch(1)], [sketch(2)]
    assert duplicate_submissions({"c": one, "a": one, "b": one}) == {"a": "c", "b": "c"}
    assert duplicate_submissions({"a": one, "b": two, "c": one, "d": two}) == {"c": "a", "d": "b"}
    for first, second in ("ab", "ba"):
        assert duplicate_submissions({first: one, second: two, "copy": [*two, *one]}) == {"copy": first}
    assert duplicate_submissions({"a": [], "b": [], "c": [()], "d": [()]}) == {}


def test_a_board_marks_runs_that_are_unusually_alike_and_keeps_their_rank(enter: Enter) -> None:
    def alike(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
        return stage * 400 / 5 + 0.01 * run + position - episode / 20

    cards = [enter("a", 300), enter("b", 350), enter("one-run", 400, value=alike)]
    rows = {row.name: row for row in board(cards, KEY).rows}
    assert "may not be trusted" in rows["one-run"].alike
    assert rows["one-run"].ranked
    assert rows["a"].alike == rows["b"].alike == ""
    assert board(cards[1:], KEY).rows[0].alike == ""  # one other submission says little


def test_an_honest_spread_of_a_quarter_of_the_others_is_not_marked() -> None:
    wide, narrow = [0.1, 0.2, 0.3, 0.4, 0.5], [0.25, 0.275, 0.3, 0.325, 0.35]
    assert unusually_alike({"a": wide, "b": wide, "c": narrow, "d": wide}, alpha=0.01) == {}
    alike = {"a": wide, "b": wide, "c": [0.3, 0.301, 0.302], "d": wide}
    assert set(unusually_alike(alike, alpha=0.01)) == {"c"}
