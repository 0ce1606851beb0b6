"""Hostile folders: numbers and names of files, links, devices, and files that change while they are read."""

from __future__ import annotations

import os
from pathlib import Path

from ..rollouts.examples import Change
from .case import GROUP, LOG, POLICIES, TOML, TRACE, TRACES, Case, all_of, put, remove

LONG = "x" * 200


def many(count: int, folder: str, name: str, data: bytes = b"") -> Change:
    """Writes that many files; the name has the place of a number."""

    def change(entry: Path) -> None:
        (entry / folder).mkdir(exist_ok=True, parents=True)
        first = entry / folder / name.format(0)
        first.write_bytes(data)
        for index in range(1, count):
            os.link(first, entry / folder / name.format(index))

    return change


def many_linked(count: int) -> Change:
    """As ``many``, with hard links to several files, because one file may have 65,000 names at most."""

    def change(entry: Path) -> None:
        for part in range(count // 30_000):
            many(30_000, TRACES, f"single-run{part + 1}-stage1-Hopper-episode{{}}.npz")(entry)

    return change


def folders(*names: str) -> Change:
    """Makes empty folders."""

    def change(entry: Path) -> None:
        for name in names:
            (entry / name).mkdir()

    return change


def folder_in_place_of(path: str) -> Change:
    """Replaces a file by a folder."""

    def change(entry: Path) -> None:
        (entry / path).unlink()
        (entry / path).mkdir()

    return change


def without_files(entry: Path) -> None:
    """Removes every file."""
    for path in entry.rglob("*"):
        if path.is_file():
            path.unlink()


def link(path: str, target: str) -> Change:
    """Replaces a path by a symbolic link."""

    def change(entry: Path) -> None:
        (entry / path).unlink(missing_ok=True)
        (entry / path).symlink_to(target)

    return change


def fifo(path: str) -> Change:
    """Replaces a path by a FIFO, at which a reader would wait."""

    def change(entry: Path) -> None:
        (entry / path).unlink(missing_ok=True)
        os.mkfifo(entry / path)

    return change


def folder_link(entry: Path) -> None:
    (entry / GROUP).rename(entry.parent / "elsewhere")
    (entry / GROUP).symlink_to(entry.parent / "elsewhere")


def tree(depth: int) -> Change:
    """Folders in folders."""

    def change(entry: Path) -> None:
        path = entry / GROUP
        for _ in range(depth):
            path = path / "d"
            path.mkdir()

    return change


def unreadable(path: str) -> Change:
    return lambda entry: (entry / path).chmod(0)


CASES = (
    Case("60,000 empty traces", many_linked(60_000), ("too-large",)),
    Case("60,000 unexpected files", many(60_000, GROUP, "x{}"), ("too-large", "unexpected-name")),
    Case("5,000 unexpected files with long names", many(5_000, GROUP, LONG + "{}"), ("unexpected-name",)),
    Case(
        "5,000 traces of runs that do not exist",
        many(5_000, TRACES, "single-run{}-stage1-Hopper-episode3.npz"),
        ("foreign-trace", "malformed-arrays"),
    ),
    Case(
        "5,000 unknown groups",
        folders(*(f"g{number}" for number in range(5_000))),
        ("unknown-group",),
    ),
    Case("folders of 100 levels", tree(100), ("unexpected-name",)),
    Case("a log that is a link", link(LOG, "/dev/zero"), ("not-a-regular-file",)),
    Case("a manifest that is a link", link(TOML, "/etc/passwd"), ("not-a-regular-file",)),
    Case("a trace that is a link to itself", link(TRACE, Path(TRACE).name), ("not-a-regular-file",)),
    Case("a group that is a link", folder_link, ("not-a-regular-file",)),
    Case("a log that is a FIFO", fifo(LOG), ("not-a-regular-file",)),
    Case("a manifest that is a FIFO", fifo(TOML), ("not-a-regular-file",)),
    Case("a trace that is a FIFO", fifo(TRACE), ("not-a-regular-file",)),
    Case("a file named CON", put("CON", b""), ("unexpected-name",)),
    Case("a folder that is named CON", lambda entry: None, ("folder-name",), name="CON"),
    Case("a folder that is named nul.txt", lambda entry: None, ("folder-name",), name="nul.txt"),
    Case("a folder that ends in a dot", lambda entry: None, ("folder-name",), name="entry."),
    Case("a folder with a space", lambda entry: None, ("folder-name",), name="my entry"),
    Case("a folder with a formula", lambda entry: None, ("folder-name",), "table", "=1+1"),
    Case("a folder with a foreign letter", lambda entry: None, ("folder-name",), name="trрo"),
    Case("a folder with a bell", lambda entry: None, ("folder-name",), name="a\x07b"),
    Case("a folder of 200 letters", lambda entry: None, ("folder-name",), name=LONG),
    Case("a file name with control characters", put("\x1b[2J", b""), ("unexpected-name",)),
    Case("a file name that is not UTF-8", put(os.fsdecode(b"\xff\xfe"), b""), ("unexpected-name",)),
    Case(
        "a manifest in other letter case",
        lambda entry: (entry / TOML).rename(entry / "Submission.toml"),
        ("not-a-submission", "unexpected-name"),
    ),
    Case(
        "a log in other letter case",
        lambda entry: (entry / LOG).rename(entry / GROUP / "Single.csv"),
        ("no-logs", "unexpected-name"),
    ),
    Case(
        "a group in other letter case",
        lambda entry: (entry / GROUP).rename(entry / "Hopper-Gravity"),
        ("unknown-group",),
    ),
    Case("a salt of other letters", put(f"{TRACES}/salt.txt", b"g" * 64 + b"\n"), ("malformed-salt",)),
    Case("a salt of 64 digits without a line end", put(f"{TRACES}/salt.txt", b"0" * 64), ("malformed-salt",)),
    Case("a salt of a million digits", put(f"{TRACES}/salt.txt", b"0" * 1_000_000), ("too-large",)),
    Case("a salt in upper case", put(f"{TRACES}/salt.txt", b"A" * 64 + b"\n"), ("malformed-salt",)),
    Case("a program", put(f"{GROUP}/run.py", b"import os"), ("unexpected-name",)),
    Case("a hidden file", put(".gitattributes", b"* text"), ("unexpected-name",)),
    Case("a folder of progress", put(".progress/x", b"x" * 1000)),
    Case(
        "an empty folder",
        without_files,
        ("no-logs", "not-a-submission"),
    ),
    Case(
        "a folder in place of a log",
        folder_in_place_of(LOG),
        ("no-logs", "unexpected-name"),
    ),
    Case(
        "a folder in place of the manifest",
        folder_in_place_of(TOML),
        ("not-a-submission", "unknown-group"),
    ),
    Case(
        "policies without a log",
        all_of(remove(LOG), put(f"{POLICIES}/joint-run0-stage1.npz", b"")),
        ("malformed-arrays", "no-logs"),
    ),
    Case("a digest of a folder with a FIFO", fifo(LOG), (), "digest"),
)
