"""Reading a submission: the rules together, and everything that is reported at once."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gym_extensions.rollouts.folder import Folder
from gym_extensions.rollouts.problem import PROBLEMS_LISTED, Problem
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.rules import RULES

from .examples import (
    GROUP,
    LOG,
    TOML,
    TRACE,
    CopySubmission,
    arrays,
    cell,
    edit,
    put,
    row,
    rules,
)
from .rules import (
    test_consistency,
    test_csv,
    test_curves,
    test_episodes,
    test_folder,
    test_manifest,
    test_measurements,
    test_npz,
    test_policies,
    test_runs,
    test_unicode,
)

TABLES = (
    test_folder.EXAMPLES,
    test_manifest.EXAMPLES,
    test_unicode.EXAMPLES,
    test_consistency.EXAMPLES,
    test_csv.EXAMPLES,
    test_episodes.EXAMPLES,
    test_measurements.EXAMPLES,
    test_runs.EXAMPLES,
    test_curves.EXAMPLES,
    test_npz.EXAMPLES,
    test_policies.EXAMPLES,
)


def test_a_valid_submission_breaks_no_rule(good: CopySubmission, tmp_path: Path) -> None:
    folder = good(GROUP, tmp_path)
    put(TRACE, arrays(actions=np.zeros((5, 3), np.float32), segment_steps=np.int64(10)))(folder)
    put(".progress/half-done.csv", b"nothing yet")(folder)
    assert read(folder).problems == ()


def test_every_rule_has_an_example() -> None:
    elsewhere = {"unreadable-file"}  # test_a_file_that_cannot_be_opened_is_a_problem
    examples = [example.rule for table in TABLES for example in table]
    assert {*examples, *elsewhere} == set(RULES)


def test_problems_of_all_files_are_reported_at_once(submission: Callable[..., Path]) -> None:
    folder = submission()
    cell(2, 6, "nan")(folder)
    cell(3, 4, "7")(folder)
    edit("boundaries = false\n", "", TOML)(folder)
    put("notes.txt", b"")(folder)
    cell(2, 5, "12", f"{GROUP}/single.csv")(folder)
    assert set(rules(read(folder).problems)) == {
        "not-finite",
        "wrong-seed",
        "missing-key",
        "unexpected-name",
        "unfinished-episode",
    }


def test_each_rule_lists_twenty_problems_and_counts_the_rest(good: CopySubmission, tmp_path: Path) -> None:
    folder = good(GROUP, tmp_path)
    for number in range(5000):
        (folder / f"notes{number:04}.txt").touch()
    cell(2, 6, "nan")(folder)
    problems = read(folder).problems
    assert [problem.where for problem in problems[:PROBLEMS_LISTED]] == [
        f"notes{number:04}.txt" for number in range(PROBLEMS_LISTED)
    ]
    assert problems[PROBLEMS_LISTED:] == (
        Problem(
            "not-finite",
            f"{LOG}, row 2",
            "Column `return` is nan; expected a finite number.",
            "Find the cause in the policy or in the sum of rewards; such an episode cannot be scored.",
        ),
        Problem(
            "unexpected-name",
            "entry",
            "4980 more problems of this rule in the submission.",
            "Remove it, or rename it as described in docs/rollout-log.md.",
        ),
    )


def test_curves_and_traces_are_checked_beside_a_log_with_problems(
    good: CopySubmission, tmp_path: Path
) -> None:
    folder = good(GROUP, tmp_path)
    cell(2, 6, "nan")(folder)
    cell(4, 4, "inf", f"{GROUP}/curves.csv")(folder)
    put(TRACE, b"not a zip")(folder)
    put(TRACE.replace("sequential-run0", "single-run7"), arrays(actions=np.zeros(3)))(folder)
    assert set(rules(read(folder).problems)) == {
        "not-finite",
        "curve-not-finite",
        "malformed-arrays",
        "foreign-trace",
    }


def test_logs_are_checked_without_a_manifest(good: CopySubmission, tmp_path: Path) -> None:
    folder = good(GROUP, tmp_path)
    (folder / TOML).unlink()
    cell(2, 6, "nan")(folder)
    assert rules(read(folder).problems) == ["not-a-submission", "not-finite"]


def test_the_curves_of_a_log_with_a_wrong_name_are_not_foreign(good: CopySubmission, tmp_path: Path) -> None:
    folder = good(GROUP, tmp_path)
    (folder / GROUP / "single.csv").rename(folder / GROUP / "singel.csv")
    assert rules(read(folder).problems) == ["unexpected-name"]


def test_a_link_is_not_reported_as_a_missing_file_too(good: CopySubmission, tmp_path: Path) -> None:
    folder = good(GROUP, tmp_path)
    for path in (TOML, f"{GROUP}/sequential.csv", f"{GROUP}/single.csv"):
        (folder / path).rename(tmp_path / Path(path).name)
        (folder / path).symlink_to(tmp_path / Path(path).name)
    assert rules(read(folder).problems) == ["not-a-regular-file"] * 3


def test_the_return_of_an_episode_of_impossible_length_is_not_checked(
    good: CopySubmission, tmp_path: Path
) -> None:
    folder = good(GROUP, tmp_path)
    row(2, lambda cells: [*cells[:5], "-5", "100.0", *cells[7:]])(folder)
    assert rules(read(folder).problems) == ["impossible-length"]


def test_the_curves_and_traces_of_an_unreadable_log_are_not_foreign(
    good: CopySubmission, tmp_path: Path
) -> None:
    folder = good(GROUP, tmp_path)
    edit("terminated", "terminate")(folder)
    put(TRACE, arrays(actions=np.zeros(3)))(folder)
    assert rules(read(folder).problems) == ["wrong-header"]


def test_a_file_that_cannot_be_opened_is_a_problem(
    submission: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(self: Folder, path: str) -> bytes:
        if path == LOG:
            raise PermissionError(13, "Permission denied")
        return (self.root / path).read_bytes()

    monkeypatch.setattr(Folder, "read", refuse)
    assert read(submission()).problems == (
        Problem(
            "unreadable-file",
            LOG,
            "The file cannot be read: Permission denied.",
            "Add read permission, or copy it again.",
        ),
    )
