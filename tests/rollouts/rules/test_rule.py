"""The rules together: every one has an example, a good folder breaks none, all that are broken are told."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.rules import RULES

from . import (
    test_consistency,
    test_csv,
    test_curves,
    test_episodes,
    test_folder,
    test_manifest,
    test_measurements,
    test_npz,
    test_runs,
    test_unicode,
)
from .broken import GROUP, TOML, TRACE, Good, arrays, cell, edit, put, row

TABLES = (
    test_folder,
    test_manifest,
    test_unicode,
    test_consistency,
    test_csv,
    test_episodes,
    test_measurements,
    test_runs,
    test_curves,
    test_npz,
)


def test_a_good_folder_breaks_no_rule(good: Good, tmp_path: Path) -> None:
    folder = good(GROUP, tmp_path)
    put(TRACE, arrays(actions=np.zeros((5, 3), np.float32), segment_steps=np.int64(10)))(folder)
    put(f"{GROUP}/policies/run0.npz", arrays(weights=np.zeros((5, 3))))(folder)
    put(".progress/half-done.csv", b"nothing yet")(folder)
    assert read(folder).problems == ()


def test_every_rule_has_an_example() -> None:
    elsewhere = {"unreadable-file"}  # test_a_file_that_cannot_be_read_is_named
    examples = [example.rule for table in TABLES for example in table.BROKEN]
    assert {*examples, *elsewhere} == set(RULES)


def test_all_problems_are_told_at_once(submission: Callable[..., Path]) -> None:
    folder = submission()
    cell(2, 6, "nan")(folder)
    cell(3, 4, "7")(folder)
    edit("boundaries = false\n", "", TOML)(folder)
    put("notes.txt", b"")(folder)
    cell(2, 5, "12", f"{GROUP}/single.csv")(folder)
    assert {problem.rule for problem in read(folder).problems} == {
        "not-finite",
        "wrong-seed",
        "missing-key",
        "unexpected-name",
        "unfinished-episode",
    }


def test_curves_and_arrays_are_checked_beside_a_log_with_problems(good: Good, tmp_path: Path) -> None:
    folder = good(GROUP, tmp_path)
    cell(2, 6, "nan")(folder)
    cell(4, 4, "inf", f"{GROUP}/curves.csv")(folder)
    put(TRACE, b"not a zip")(folder)
    put(TRACE.replace("sequential-run0", "single-run7"), arrays(actions=np.zeros(3)))(folder)
    assert {problem.rule for problem in read(folder).problems} == {
        "not-finite",
        "curve-not-finite",
        "malformed-arrays",
        "foreign-trace",
    }


def test_logs_are_checked_without_a_manifest(good: Good, tmp_path: Path) -> None:
    folder = good(GROUP, tmp_path)
    (folder / TOML).unlink()
    cell(2, 6, "nan")(folder)
    assert [problem.rule for problem in read(folder).problems] == ["not-a-submission", "not-finite"]


def test_what_belongs_to_a_log_under_a_wrong_name_is_not_called_foreign(good: Good, tmp_path: Path) -> None:
    folder = good(GROUP, tmp_path)
    (folder / GROUP / "single.csv").rename(folder / GROUP / "singel.csv")
    assert [problem.rule for problem in read(folder).problems] == ["unexpected-name"]


def test_a_link_in_the_place_of_a_file_is_not_called_missing_too(good: Good, tmp_path: Path) -> None:
    folder = good(GROUP, tmp_path)
    for path in (TOML, f"{GROUP}/sequential.csv", f"{GROUP}/single.csv"):
        (folder / path).rename(tmp_path / Path(path).name)
        (folder / path).symlink_to(tmp_path / Path(path).name)
    assert {problem.rule for problem in read(folder).problems} == {"not-a-regular-file"}


def test_a_return_is_not_measured_by_an_impossible_length(good: Good, tmp_path: Path) -> None:
    folder = good(GROUP, tmp_path)
    row(2, lambda cells: [*cells[:5], "-5", "100.0", *cells[7:]])(folder)
    assert [problem.rule for problem in read(folder).problems] == ["impossible-length"]


def test_what_belongs_to_a_log_that_cannot_be_read_is_not_called_foreign(good: Good, tmp_path: Path) -> None:
    folder = good(GROUP, tmp_path)
    edit("terminated", "terminate")(folder)
    put(TRACE, arrays(actions=np.zeros(3)))(folder)
    assert [problem.rule for problem in read(folder).problems] == ["wrong-header"]
