"""Reading a repository, and salts: what git lacks is a named error."""

from __future__ import annotations

from pathlib import Path

import pytest

from gym_extensions.curation.digest import folder_hashes
from gym_extensions.curation.git import Repository
from gym_extensions.curation.salt import derive_salt, fixing_commit
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.auditing.submission_digest import digest_without_traces, submission_digest

from .repositories import commit, git, make_repository, write_entry


def test_a_machine_without_git_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(BenchError, match=r"The command git was not found\. Install git\.$"):
        Repository(tmp_path).run("version")


def test_a_git_hook_in_which_another_repository_is_named_is_not_misled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = make_repository(tmp_path / "here")
    monkeypatch.setenv("GIT_DIR", str(make_repository(tmp_path / "other") / ".git"))
    assert Repository(folder).top.name == "here"


def test_two_commits_without_a_common_ancestor_are_no_error_and_a_missing_commit_is_one(
    tmp_path: Path,
) -> None:
    folder = make_repository(tmp_path / "here")
    first = commit(folder)
    git(folder, "checkout", "--quiet", "--orphan", "other")
    second = commit(folder, message="another")
    repository = Repository(folder)
    assert repository.merge_bases(first, second) == []
    with pytest.raises(BenchError, match="Not a valid object name missing"):
        repository.merge_bases(first, "missing")


def test_files_of_a_commit_are_read_with_their_modes_and_sizes(tmp_path: Path) -> None:
    folder = make_repository(tmp_path)
    head = commit(folder, {"a/b.csv": "1\n", "c": b"\0\xff\n\n"})
    repository = Repository(folder)
    assert [(entry.mode, entry.size, entry.path) for entry in repository.tree(head)] == [
        ("100644", 2, "a/b.csv"),
        ("100644", 4, "c"),
    ]
    assert (repository.file(head, "c"), repository.file(head, "a")) == (b"\0\xff\n\n", None)


def test_a_commit_that_changes_traces_alone_does_not_fix_a_submission(tmp_path: Path) -> None:
    folder = make_repository(tmp_path)
    fixed = commit(folder, {"submissions/a/g/single.csv": "1\n"})
    commit(folder, {"submissions/a/g/traces/x.npz": "1\n"})
    head = commit(folder, {"submissions/b/g/single.csv": "1\n"})
    repository = Repository(folder)
    assert fixing_commit(repository, head, "submissions/a") == fixed
    assert fixing_commit(repository, head, "submissions/absent") == ""


def test_a_salt_is_a_hash_of_the_digest_and_the_value() -> None:
    # printf '%s%s' aaa…a 111…1 | sha256sum
    expected = "dcb3be4b9d3dfb41a218bbb2a1207664136e65ad9a7589fa2041e75cb7f58804"
    assert derive_salt("a" * 64, "1" * 40) == expected


def test_the_digest_for_a_salt_is_that_of_the_submission(tmp_path: Path) -> None:
    folder = write_entry(tmp_path, "entry")
    (folder / "hopper-gravity" / "traces").mkdir()
    (folder / "hopper-gravity" / "traces" / "salt.txt").write_text("x")
    assert digest_without_traces(folder_hashes(folder)) == submission_digest(folder)
