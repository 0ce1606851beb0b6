"""Rules about the folder: what may lie in it, under which names, how large."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gym_extensions.errors import BenchError
from gym_extensions.rollouts.folder import Folder, submission_folders
from gym_extensions.rollouts.problem import Problem
from gym_extensions.rollouts.reader import read

from .broken import GROUP, LOG, TOML, Broken, Good, Judge, arrays, each, put, remove


def link(folder: Path) -> None:
    (folder / GROUP / "joint.csv").symlink_to("/etc/hostname")


BROKEN = (
    Broken(
        "not-a-submission",
        "a folder without submission.toml",
        remove(TOML),
        (
            (
                "entry",
                "There is no submission.toml in it.",
                "Write submission.toml as docs/rollout-log.md says, or name the folder that holds it.",
            ),
        ),
    ),
    Broken(
        "folder-name",
        "a name that cannot be an address",
        lambda folder: folder.rename(folder.with_name("my entry!")),
        (
            (
                "my entry!",
                "The folder's name is 'my entry!'.",
                "Rename it with a letter or digit, then those, dots, dashes and underscores, 64 in all.",
            ),
        ),
    ),
    Broken(
        "not-a-regular-file",
        "a symbolic link",
        link,
        ((f"{GROUP}/joint.csv", "This is a symbolic link.", "Put the file itself in its place."),),
    ),
    Broken(
        "unknown-group",
        "a misspelt group",
        lambda folder: (folder / GROUP).rename(folder / "hoper-gravity"),
        (("hoper-gravity", "There is no group 'hoper-gravity'.", "Did you mean 'hopper-gravity'?"),),
    ),
    Broken(
        "unexpected-name",
        "a misspelt log",
        put(f"{GROUP}/sequental.csv", b""),
        (
            (
                f"{GROUP}/sequental.csv",
                "A file of this name has no place here.",
                "Did you mean 'sequential.csv'?",
            ),
        ),
    ),
    Broken(
        "unexpected-name",
        "a program",
        put("run.py", b"print()"),
        (
            (
                "run.py",
                "A file of this name has no place here.",
                "Remove it, or give it the name that docs/rollout-log.md says.",
            ),
        ),
    ),
    Broken(
        "unexpected-name",
        "the trace of a task of another group",
        put(f"{GROUP}/traces/sequential-run0-stage1-Humanoid-episode3.npz", arrays(actions=np.zeros(3))),
        (
            (
                f"{GROUP}/traces/sequential-run0-stage1-Humanoid-episode3.npz",
                "A file of this name has no place here.",
                "Remove it, or give it the name that docs/rollout-log.md says.",
            ),
        ),
    ),
    Broken(
        "unexpected-name",
        "a folder among the logs",
        lambda folder: (folder / GROUP / "code").mkdir(),
        ((f"{GROUP}/code", "A folder of this name has no place here.", "Remove it."),),
    ),
    Broken(
        "no-logs",
        "a group's folder without a log",
        lambda folder: (folder / "humanoid-gravity").mkdir(),
        (
            (
                "humanoid-gravity",
                "There is no log in it.",
                "Add one of sequential.csv, single.csv, joint.csv, or remove the folder.",
            ),
        ),
    ),
    Broken(
        "too-large",
        "a long manifest",
        lambda folder: (folder / TOML).write_text((folder / TOML).read_text() + "#" * 2**18),
        (
            (
                TOML,
                "The file has 262661 bytes; the limit is 262144.",
                "Leave out what the format does not ask for.",
            ),
        ),
    ),
    Broken(
        "not-a-submission",
        "a folder that is not there",
        lambda folder: folder.rename(folder.with_name("elsewhere")).joinpath(TOML).unlink(),
        (
            (
                "elsewhere",
                "There is no submission.toml in it.",
                "Write submission.toml as docs/rollout-log.md says, or name the folder that holds it.",
            ),
        ),
    ),
)


@each(BROKEN)
def test_a_broken_folder_breaks_its_rule_and_says_so(example: Broken, judge: Judge) -> None:
    judge(example)


def test_a_name_that_is_no_folder_is_no_submission(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    told = [read(tmp_path / name).problems[0].message for name in ("nowhere", "file")]
    assert told == ["'nowhere' does not exist.", "'file' is not a folder."]


def test_a_linked_submission_in_a_collection_is_refused(good: Good, tmp_path: Path) -> None:
    good(GROUP, tmp_path)
    (tmp_path / "other").symlink_to(tmp_path / "entry")
    problems = {path.name: read(path).problems for path in submission_folders([tmp_path])}
    assert problems["entry"] == ()
    assert [(one.rule, one.where) for one in problems["other"]] == [("not-a-regular-file", "other")]


def test_a_link_that_leads_nowhere_is_told(good: Good, tmp_path: Path) -> None:
    good(GROUP, tmp_path)
    (tmp_path / "other").symlink_to(tmp_path / "nowhere")
    problems = {path.name: read(path).problems for path in submission_folders([tmp_path])}
    assert problems["entry"] == ()
    assert [(one.rule, one.where) for one in problems["other"]] == [("not-a-regular-file", "other")]


def test_a_folder_that_may_not_be_opened_is_told(
    good: Good, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    good(GROUP, tmp_path)
    shut = tmp_path / "shut"
    shut.mkdir()
    look, enter = os.stat, os.scandir

    def stat(path: Any, **options: Any) -> os.stat_result:
        if isinstance(path, str | Path) and Path(path).parent == shut:
            raise PermissionError(13, "Permission denied")
        return look(path, **options)

    def scandir(path: Any) -> Any:
        if Path(path) == shut:
            raise PermissionError(13, "Permission denied")
        return enter(path)

    monkeypatch.setattr(os, "stat", stat)
    monkeypatch.setattr(os, "scandir", scandir)
    problems = {path.name: read(path).problems for path in submission_folders([tmp_path])}
    assert problems["entry"] == ()
    assert problems["shut"] == (
        Problem(
            "not-a-regular-file",
            "shut",
            "This is a folder that cannot be read.",
            "Give it read permission, or copy it again.",
        ),
    )


def test_two_submissions_of_one_name_are_refused(tmp_path: Path) -> None:
    paths = [tmp_path / "a" / "mine", tmp_path / "b" / "mine"]
    for path in paths:
        path.mkdir(parents=True)
    assert submission_folders([paths[0], paths[0]]) == [paths[0]]
    with pytest.raises(BenchError) as told:
        submission_folders(paths)
    first = f"Two submissions have the name 'mine': {paths[0]} and {paths[1]}."
    assert str(told.value) == f"{first} Score one at a time, or rename one."


def test_names_are_shown_without_what_a_terminal_would_obey(good: Good, tmp_path: Path) -> None:
    folder = good(GROUP, tmp_path)
    put("a\n\x1b[31m.txt", b"")(folder)
    named = folder.rename(tmp_path / os.fsdecode(b"a\xff"))
    submission = read(named)
    assert submission.name == "a\\udcff"
    assert [(one.rule, one.where, one.message) for one in submission.problems] == [
        ("folder-name", "a\\udcff", "The folder's name is 'a\\udcff'."),
        ("unexpected-name", "a\\n\\x1b[31m.txt", "A file of this name has no place here."),
    ]


def test_a_file_that_cannot_be_read_is_named(
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
            "Give it read permission, or copy it again.",
        ),
    )
