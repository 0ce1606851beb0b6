"""Pull requests by their history: common ancestors, a base that moved, earlier merges, and vast commits."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from gym_extensions.curation import git as plumbing
from gym_extensions.curation.digest import folder_hashes
from gym_extensions.curation.salt import derive_salt
from gym_extensions.rollouts.auditing.submission_digest import digest_without_traces

from ..repositories import commit, git, make_crossed
from .checks import checked, rules

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the gate needs limits that Windows lacks")


@pytest.mark.usefixtures("no_judge")
def test_the_merge_commit_of_an_entry_gives_the_salt_of_the_pull_request_with_its_traces(
    project: Path,
) -> None:
    merged = git(project, "rev-parse", "main")
    path = "submissions/old/hopper-gravity/traces/salt.txt"
    commit(project, {path: "x"})
    report = checked(project)
    assert report.value == merged
    files = folder_hashes(project / "submissions" / "old")
    assert report.salt == derive_salt(digest_without_traces(files), merged)
    git(project, "switch", "--quiet", "-c", "later")
    git(project, "branch", "--force", "main", "request")
    moved = project / path
    moved.rename(moved.with_name("other.npz"))
    commit(project)
    assert (checked(project).problems, checked(project).value) == ((), merged)
    commit(project, {"submissions/old/README.md": "A text.\n"})
    assert (checked(project).value, checked(project, head="entry").value) == ("", "")


@pytest.mark.usefixtures("no_judge")
def test_another_salt_of_the_same_logs_is_noted(project: Path) -> None:
    commit(project, {"submissions/old/README.md": "A typo.\n"})
    assert checked(project).notes[0] == "The logs stay, and their salt becomes another one."
    git(project, "switch", "--quiet", "main")
    git(project, "merge", "--quiet", "--no-ff", "--no-edit", "request")
    git(project, "switch", "--quiet", "-c", "traces")
    commit(project, {"submissions/old/hopper-gravity/traces/x.npz": "x"})
    assert checked(project, head="traces").notes[0] == (
        "This is salt 2 of the same logs: other files were changed after the first."
    )


def test_a_pull_request_without_a_change_or_a_common_ancestor_is_refused(project: Path) -> None:
    ((rule, where),) = rules(checked(project))
    assert (rule, len(where)) == ("no-change", 40), "the commit"
    git(project, "switch", "--quiet", "--orphan", "alone")
    commit(project, {"submissions/new/submission.toml": "x"})
    assert rules(checked(project)) == [("unrelated-history", "")]


def test_a_history_with_several_common_ancestors_is_refused(project: Path) -> None:
    """The merge would revert what the base changed on its side."""
    make_crossed(project)
    (problem,) = checked(project).problems
    assert (problem.rule, problem.message) == ("crossed-history", "The two commits have 2 common ancestors.")


def test_an_edit_of_an_entry_that_the_base_changed_meanwhile_is_refused(project: Path) -> None:
    commit(project, {"submissions/old/README.md": "One text.\n"})
    git(project, "switch", "--quiet", "main")
    commit(project, {"submissions/old/README.md": "Another text.\n"})
    assert rules(checked(project, head="request")) == [("outdated-entry", "submissions/old")]


@pytest.mark.usefixtures("no_judge")
def test_a_new_entry_is_compared_with_the_base_where_it_started(project: Path) -> None:
    git(project, "switch", "--quiet", "main")
    commit(project, {"scoring/rank.py": "rank = 3\n"})
    assert checked(project, head="entry").verdict == "passed"


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux limits the memory of git")
def test_a_commit_that_stands_for_billions_of_files_is_refused(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    blob = git(project, "hash-object", "-w", "--stdin", data=b"x")
    rows = [f"100644 blob {blob}\tfile{number}" for number in range(10)]
    for _ in range(9):
        tree = git(project, "mktree", data="\n".join(rows).encode())
        rows = [f"040000 tree {tree}\tfolder{number}" for number in range(10)]
    root = git(project, "mktree", data=f"040000 tree {tree}\tsubmissions".encode())
    head = git(project, "commit-tree", "-p", "main", "-m", "bomb", root)
    monkeypatch.setattr(plumbing, "MAX_MEMORY", 64 * 2**20)
    assert [problem.rule for problem in checked(project, head=head).problems] == ["git-limit"]
