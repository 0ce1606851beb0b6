"""Reading a repository, and the commits that fix seeds: what git lacks is a named error."""

from pathlib import Path

import pytest

from gym_extensions.errors import BenchError
from gym_extensions.verification.after_merge import runs_by_commit
from gym_extensions.verification.git import Repository

from ..conftest import refused
from ..curation.repositories import commit, git, make_repository


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


def test_files_of_a_commit_are_read_with_their_modes_and_sizes(tmp_path: Path) -> None:
    folder = make_repository(tmp_path)
    head = commit(folder, {"a/b.csv": "1\n", "c": b"\0\xff\n\n"})
    repository = Repository(folder)
    found = [(each.mode, each.size, each.path) for each in repository.tree(head, sizes=True)]
    assert found == [("100644", 2, "a/b.csv"), ("100644", 4, "c")]
    assert (repository.file(head, "c"), repository.file(head, "a")) == (b"\0\xff\n\n", None)


def test_the_last_commit_of_the_first_parents_fixes_runs(tmp_path: Path) -> None:
    folder = make_repository(tmp_path)
    commit(folder, {"submissions/a/g/single/run0.csv": "1\n"})
    git(folder, "switch", "--quiet", "-c", "submission")
    inner = commit(folder, {"submissions/a/g/single/run1.csv": "1\n"})
    git(folder, "switch", "--quiet", "main")
    git(folder, "merge", "--quiet", "--no-ff", "--no-edit", "submission")
    merge = git(folder, "rev-parse", "HEAD")
    head = commit(folder, {"submissions/a/README.md": "A text.\n"})
    paths = ["submissions/a/g/single/run0.csv", "submissions/a/g/single/run1.csv"]
    assert Repository(folder).last_change(head, paths) == merge != inner
    assert Repository(folder).last_change(head, ["submissions/absent"]) == ""


RUN = "g/sequential/run0"
FILES = ("submission.toml", *(f"{RUN}.{suffix}" for suffix in ("csv", "json", "npz", "stage0.onnx")))


@pytest.mark.parametrize("name", FILES)
def test_the_seeds_of_a_run_follow_from_the_last_commit_of_any_of_its_files(
    tmp_path: Path, name: str
) -> None:
    folder, other = make_repository(tmp_path), RUN.replace("0", "1")
    first = {f"submissions/a/{each}": "1\n" for each in (*FILES, f"{other}.csv")}
    commit(folder, {**first, "submissions/a/README.md": "A text.\n"})
    last = commit(folder, {f"submissions/a/{name}": "2\n"})
    commit(folder, {"submissions/a/README.md": "Another text.\n", f"submissions/a/{other}.csv": "2\n"})
    assert runs_by_commit(folder / "submissions/a", [RUN]) == {last: [RUN]}


def test_a_clone_that_lacks_older_commits_gives_no_seeds(tmp_path: Path) -> None:
    whole = make_repository(tmp_path / "whole")
    commit(whole, {"a": "1\n"})
    commit(whole, {"b": "1\n"})
    git(tmp_path, "clone", "--quiet", "--depth", "1", f"file://{whole}", str(tmp_path / "cut"))
    with refused("shallow-clone"):
        Repository(tmp_path / "cut").last_change("HEAD", ["a"])
