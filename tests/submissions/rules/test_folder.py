"""Every rule about the folder and its files reports its mistake."""

from pathlib import Path

import pytest

from gym_extensions.submissions.layout import MAX_FILE_BYTES
from gym_extensions.submissions.reader import read

from ..examples import DOCUMENT, GROUP, LOG, TOML, Change, Table, edit, put, remove


def rename(old: str, new: str) -> Change:
    return lambda folder: (folder / old).rename(folder / new)


def called(name: str) -> Change:
    return lambda folder: folder.rename(folder.with_name(name))


def rename_runs(old: int, new: int) -> Change:
    """Gives the files of a sequential and a single run another number."""

    def change(folder: Path) -> None:
        for path in folder.glob(f"{GROUP}/*/run{old}.*"):
            path.rename(path.with_name(f"run{new}{path.suffix}"))

    return change


def prefixed(data: bytes, path: str = LOG) -> Change:
    return lambda folder: (folder / path).write_bytes(data + (folder / path).read_bytes())


CONFLICT = edit("\n0,", "\n<<<<<<< ours\n0,", count=2)
RUNS, NOTE = f"{GROUP}/sequential", f"{GROUP}/notes.txt"
EXAMPLES: Table = {
    "not-a-submission": [("no manifest", remove(TOML), "submission", "no submission.toml")],
    "folder-name": [
        ("a space", called("my submission"), "my submission", "my submission"),
        ("a device", called("nul.x"), "nul.x", "nul.x"),
    ],
    "not-a-regular-file": [
        ("a link", lambda f: (f / "README.md").symlink_to("/etc/hostname"), "README.md", "symbolic link"),
    ],
    "unknown-group": [
        ("a typing error", rename(GROUP, "hoper-gravity"), "hoper-gravity", f"Did you mean '{GROUP}'"),
    ],
    "unexpected-name": [
        ("code", put("agent.py", b"x"), "agent.py", "Unexpected file"),
        ("a misspelt text", put("REDME.md", b"x"), "REDME.md", "Did you mean 'README.md'"),
        ("a note in a group", put(NOTE, b"x"), NOTE, "Unexpected"),
        ("a leading zero", put(f"{GROUP}/joint/run00.csv", b"x"), f"{GROUP}/joint/run00.csv", "file"),
        ("no protocol", lambda f: (f / GROUP / "joints").mkdir(), f"{GROUP}/joints", "Did you mean 'joint'"),
    ],
    "no-runs": [("an empty group", lambda folder: (folder / "pusher").mkdir(), "pusher", "no run")],
    "missing-file": [
        ("a log without its document", remove(DOCUMENT), DOCUMENT, f"the run has {LOG}"),
        ("a document without its log", remove(LOG), LOG, DOCUMENT),
    ],
    "gaps-in-runs": [
        ("no first run", rename_runs(0, 2), RUNS, "run 0 is missing", ("misplaced-document",), 2),
        ("a seed of experts", rename_runs(1, 1001), RUNS, "1000 are reserved", ("misplaced-document",), 2),
    ],
    "too-large": [("a text", put("README.md", b"x" * (MAX_FILE_BYTES[".md"] + 1)), "README.md", "65537")],
    "malformed-toml": [
        ("not TOML", edit("format = 1", "format 1", TOML), TOML, "line 1"),
        ("not UTF-8", prefixed(b"\xff", TOML), TOML, "utf-8"),
        ("a very long line", prefixed(b"x" * 20_001, TOML), TOML, "20000 characters"),
    ],
    "malformed-log": [
        ("empty", put(LOG, b""), f"{LOG}, line 1", "header", ("different-log",)),
        ("a conflict of a merge", CONFLICT, f"{LOG}, line 2", "'<'", ("different-log",)),
    ],
    "malformed-review": [("no such key", put("review.toml", b"rank = 1\n"), "review.toml", "rank")],
}


def test_an_unreadable_file_is_named(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(path: Path, max_bytes: int) -> bytes:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("gym_extensions.submissions.layout.read_regular", refuse)
    problems = read(folder).problems
    assert {problem.rule for problem in problems} == {"unreadable-file"}
    assert (LOG, "Add read permission, or copy it again.") in [(each.where, each.hint) for each in problems]


def test_poses_are_part_of_a_submission(folder: Path) -> None:
    put("poses/hopper-gravity.json", b"{}")(folder)
    assert read(folder).problems == ()
    put("poses/run.py", b"")(folder)
    assert [problem.where for problem in read(folder).problems] == ["poses/run.py"]
