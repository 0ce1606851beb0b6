"""Pull requests by their history: common ancestors, a base that moved, earlier merges, and vast commits."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from gym_extensions.curation import git as plumbing
from gym_extensions.errors import BenchError

from .checks import checked, rules
from .repositories import commit, git, make_crossed

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the gate needs limits that Windows lacks")


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


def test_a_clone_without_old_contents_is_named_and_no_pull_request_is_refused_for_it(
    project: Path, tmp_path: Path
) -> None:
    git(project, "config", "uploadpack.allowFilter", "true")
    part = tmp_path / "part"
    git(tmp_path, "clone", "--quiet", "--filter=blob:none", f"file://{project}", str(part))
    with pytest.raises(BenchError) as error:
        checked(part, base="origin/main", head="origin/entry")
    assert error.value.code == "partial-clone"


def test_a_clone_of_another_owner_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    git(tmp_path, "init", "--quiet")
    monkeypatch.setenv("GIT_TEST_ASSUME_DIFFERENT_OWNER", "1")
    with pytest.raises(BenchError) as error:
        checked(tmp_path)
    assert error.value.code == "distrusted-clone"
    assert "safe.directory" in error.value.hint
