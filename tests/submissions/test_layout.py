"""The folder: what is listed, which runs it has, and which submissions a path stands for."""

import os
from pathlib import Path

import pytest

from gym_extensions.errors import BenchError
from gym_extensions.submissions import layout
from gym_extensions.submissions.reader import read

from ..conftest import refused
from .examples import GROUP, put


def test_items_are_listed_by_path_to_a_limited_depth(tmp_path: Path) -> None:
    put("a/b/c/d/e.txt", b"deep")(tmp_path)
    put("a/file", b"12345")(tmp_path)
    put(".progress/log", b"")(tmp_path)
    put("agent/__pycache__/agent.cpython-311.pyc", b"")(tmp_path)
    (tmp_path / "link").symlink_to("a")
    file, link = layout.FolderItem("a/file", "file", 5), layout.FolderItem("link", "link")
    folders = [layout.FolderItem(path, "folder") for path in ("a", "a/b", "a/b/c", "a/b/c/d")]
    agent = layout.FolderItem("agent", "folder")
    progress, cache = (layout.FolderItem(path, "ignored") for path in layout.IGNORED)
    assert layout.scan(tmp_path).items == (progress, *folders, file, agent, cache, link)
    assert layout.scan(tmp_path).files == {"a/file": file}


def test_a_path_that_is_not_a_folder_is_not_a_submission(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    messages = [read(tmp_path / name).problems[0].message for name in ("nowhere", "file")]
    assert messages == ["'nowhere' does not exist.", "'file' is not a folder."]


def found(path: Path) -> list[tuple[str, str]]:
    """The place and the rule of each problem."""
    return [(problem.where, problem.rule) for problem in read(path).problems]


@pytest.mark.parametrize("target", ["submission", "nowhere"])
@pytest.mark.usefixtures("folder")
def test_a_linked_submission_is_refused(tmp_path: Path, target: str) -> None:
    (tmp_path / "other").symlink_to(tmp_path / target)
    problems = {path.name: found(path) for path in layout.submission_folders([tmp_path])}
    assert problems == {"submission": [], "other": [("other", "not-a-regular-file")]}


def test_a_link_that_is_named_stands_for_its_submission(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "other").symlink_to(folder)
    assert layout.submission_folders([tmp_path / "other"]) == [folder.resolve()]


def test_a_folder_that_git_leaves_behind_is_no_submission_unless_it_is_named(
    folder: Path, tmp_path: Path
) -> None:
    left = tmp_path / "left"
    put(".progress/train.log", b"")(left)
    for name in ("empty", ".hidden"):
        (tmp_path / name).mkdir()
    assert layout.submission_folders([tmp_path]) == [tmp_path / "empty", folder]
    (named,) = layout.submission_folders([left])
    assert found(named) == [("left", "not-a-submission")]
    assert read(named).problems[0].hint.startswith("It contains only unfinished runs")


@pytest.mark.parametrize(
    ("path", "command"),
    [("mine", ""), ("submissions", "disable"), ("submissions/trpo", "add submissions/trpo")],
)
def test_a_missing_folder_is_refused_with_the_command_that_fetches_committed_ones(
    tmp_path: Path, path: str, command: str
) -> None:
    with pytest.raises(BenchError) as error:
        layout.submission_folders([tmp_path / path])
    assert (error.value.code, error.value.where) == ("no-such-folder", str(tmp_path / path))
    assert error.value.hint.partition("git sparse-checkout ")[2] == command


def test_a_part_of_a_submission_is_none(folder: Path) -> None:
    with refused("no-such-folder", f"It is a part of the submission {folder.name}."):
        layout.submission_folders([folder / GROUP])
    put(f"{GROUP}/submission.toml", b"")(folder)
    assert layout.submission_folders([folder]) == [folder]


def test_two_submissions_of_the_same_name_are_refused(tmp_path: Path) -> None:
    paths = [tmp_path / "a" / "mine", tmp_path / "b" / "mine"]
    for path in paths:
        path.mkdir(parents=True)
    assert layout.submission_folders([paths[0], paths[0]]) == [paths[0]]
    with refused("two-of-one-name", f"the name 'mine': {paths[0]} and {paths[1]}"):
        layout.submission_folders(paths)


def test_names_and_texts_are_printed_without_control_characters(folder: Path, tmp_path: Path) -> None:
    put("ü\n\x1b[31m\u202e.txt", b"")(folder)
    submission = read(folder.rename(tmp_path / os.fsdecode(b"a\xff")))
    assert submission.name == "a\\udcff"
    assert [(problem.where, problem.message) for problem in submission.problems] == [
        ("a\\udcff", "The folder's name is 'a\\udcff'."),
        ("ü\\n\\x1b[31m\\u202e.txt", "Unexpected file."),
    ]


def test_runs_are_found_by_the_names_of_their_files(tmp_path: Path) -> None:
    for path in ("run10.csv", "run2.csv", "run2.json", "run02.csv", "run2.txt", "notes/run3.csv"):
        put(f"pusher/joint/{path}", b"")(tmp_path)
    put("pusher/other/run0.csv", b"")(tmp_path)
    put("run0.csv", b"")(tmp_path)
    assert layout.scan(tmp_path).runs == {("pusher", "joint"): {2: {".csv", ".json"}, 10: {".csv"}}}


def test_a_link_or_a_file_that_grew_is_not_read(tmp_path: Path) -> None:
    put("file", b"12345")(tmp_path)
    (tmp_path / "link").symlink_to("file")
    assert layout.read_regular(tmp_path / "file", 5) == b"12345"
    for name, limit in (("file", 4), ("link", 5), (".", 5)):
        with pytest.raises(OSError):
            layout.read_regular(tmp_path / name, limit)
