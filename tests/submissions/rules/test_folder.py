"""Every rule about the folder and its files reports its mistake."""

from pathlib import Path

import pytest

from gym_extensions.submissions.layout import MAX_FILE_BYTES
from gym_extensions.submissions.reader import read

from ..examples import DOCUMENT, GROUP, LOG, TOML, Change, CopySubmission, Example, edit, put, remove


def rename(old: str, new: str) -> Change:
    return lambda folder: (folder / old).rename(folder / new)


def rename_runs(old: int, new: int, *protocols: str) -> Change:
    """Gives the files of a run another number."""

    def change(folder: Path) -> None:
        for protocol in protocols:
            for suffix in (".csv", ".json", ".npz"):
                path = folder / GROUP / protocol
                (path / f"run{old}{suffix}").rename(path / f"run{new}{suffix}")

    return change


def prefixed(data: bytes, path: str = LOG) -> Change:
    return lambda folder: (folder / path).write_bytes(data + (folder / path).read_bytes())


EXAMPLES = (
    Example("not-a-submission", "no manifest", remove(TOML), "submission", "no submission.toml"),
    Example(
        "folder-name",
        "a space",
        lambda f: f.rename(f.with_name("my submission")),
        "my submission",
        "my submission",
    ),
    Example("folder-name", "a device", lambda f: f.rename(f.with_name("nul.x")), "nul.x", "nul.x"),
    Example(
        "not-a-regular-file",
        "a link",
        lambda folder: (folder / "README.md").symlink_to("/etc/hostname"),
        "README.md",
        "symbolic link",
    ),
    Example(
        "unknown-group",
        "a typing error",
        rename(GROUP, "hoper-gravity"),
        "hoper-gravity",
        f"Did you mean '{GROUP}'",
    ),
    *(
        Example("unexpected-name", title, put(path, b"x"), path, fact)
        for title, path, fact in (
            ("code", "agent.py", "Unexpected file"),
            ("a misspelt text", "REDME.md", "Did you mean 'README.md'"),
            ("a note in a group", f"{GROUP}/notes.txt", "Unexpected"),
            ("a leading zero", f"{GROUP}/joint/run00.csv", "file"),
            ("a log of the old form", f"{GROUP}/joint.csv", "Unexpected file"),
        )
    ),
    Example(
        "unexpected-name",
        "a protocol with a typing error",
        lambda folder: (folder / GROUP / "joints").mkdir(),
        f"{GROUP}/joints",
        "Did you mean 'joint'",
    ),
    Example("no-runs", "an empty group", lambda f: (f / "pusher").mkdir(), "pusher", "no run"),
    Example("missing-file", "a log without its document", remove(DOCUMENT), DOCUMENT, f"the run has {LOG}"),
    Example("missing-file", "a document without its log", remove(LOG), LOG, DOCUMENT),
    *(
        Example(
            *("gaps-in-runs", title, rename_runs(old, new, "sequential", "single"), f"{GROUP}/sequential"),
            *(fact, ("misplaced-document",)),
            count=2,
        )
        for title, old, new, fact in (
            ("the first run left out", 0, 2, "run 0 is missing"),
            ("a seed of the reference agents", 1, 1001, "those from 1000 are reserved"),
        )
    ),
    Example(
        "too-large", "a long text", put("README.md", b"x" * (MAX_FILE_BYTES[".md"] + 1)), "README.md", "65537"
    ),
    Example("malformed-toml", "not TOML", edit("format = 1", "format 1", TOML), TOML, "line 1", also=()),
    Example("malformed-toml", "not UTF-8", prefixed(b"\xff", TOML), TOML, "utf-8"),
    Example("malformed-toml", "a very long line", prefixed(b"x" * 20_001, TOML), TOML, "20000 characters"),
    *(
        Example("malformed-log", title, change, f"{LOG}, line {line}", fact, also=("different-log",))
        for title, change, line, fact in (
            ("empty", put(LOG, b""), 1, "header"),
            ("a conflict of a merge", edit("\n0,", "\n<<<<<<< ours\n0,", count=2), 2, "'<'"),
        )
    ),
    Example("malformed-review", "no such key", put("review.toml", b"rank = 1\n"), "review.toml", "rank"),
)


def test_an_unreadable_file_is_named(
    good: CopySubmission, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(path: Path, max_bytes: int) -> bytes:
        raise PermissionError(13, "Permission denied")

    folder = good(GROUP, tmp_path)
    monkeypatch.setattr("gym_extensions.submissions.layout.read_regular", refuse)
    problems = read(folder).problems
    assert {problem.rule for problem in problems} == {"unreadable-file"}
    assert (LOG, "Add read permission, or copy it again.") in [(each.where, each.hint) for each in problems]


def test_poses_are_part_of_a_submission(good: CopySubmission, tmp_path: Path) -> None:
    folder = good(GROUP, tmp_path)
    put("poses/hopper-gravity.json", b"{}")(folder)
    assert read(folder).problems == ()
    put("poses/run.py", b"")(folder)
    assert [problem.where for problem in read(folder).problems] == ["poses/run.py"]
