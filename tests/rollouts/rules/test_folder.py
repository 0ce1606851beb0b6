"""Rules about the folder."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np

from ..examples import GROUP, TOML, Check, Example, arrays, parametrize, put, remove


def link(folder: Path) -> None:
    (folder / GROUP / "joint.csv").symlink_to("/etc/hostname")


def interrupted(folder: Path) -> None:
    shutil.rmtree(folder / GROUP)
    (folder / TOML).unlink()
    (folder / ".progress" / GROUP).mkdir(parents=True)


WRITE = "Write submission.toml as described in docs/rollout-log.md, or name the folder that contains it."

EXAMPLES = (
    Example(
        "not-a-submission",
        "a folder without submission.toml",
        remove(TOML),
        (
            (
                "entry",
                "The folder contains no submission.toml.",
                WRITE,
            ),
        ),
    ),
    Example(
        "folder-name",
        "a name that cannot be part of a URL",
        lambda folder: folder.rename(folder.with_name("my entry!")),
        (
            (
                "my entry!",
                "The folder's name is 'my entry!'.",
                "Use 1 to 64 letters, digits, dots, dashes and underscores; start with a letter or digit.",
            ),
        ),
    ),
    Example(
        "not-a-regular-file",
        "a symbolic link",
        link,
        ((f"{GROUP}/joint.csv", "It is a symbolic link.", "Replace it by the file itself."),),
    ),
    Example(
        "unknown-group",
        "a misspelt group",
        lambda folder: (folder / GROUP).rename(folder / "hoper-gravity"),
        (
            (
                "hoper-gravity",
                "Unknown group 'hoper-gravity'.",
                "Did you mean 'hopper-gravity'? For a custom group, pass its TOML file with --groups, where "
                "the command has it.",
            ),
        ),
    ),
    Example(
        "unexpected-name",
        "a misspelt log",
        put(f"{GROUP}/sequental.csv", b""),
        (
            (
                f"{GROUP}/sequental.csv",
                "Unexpected file.",
                "Did you mean 'sequential.csv'?",
            ),
        ),
    ),
    Example(
        "unexpected-name",
        "a README of a group",
        put(f"{GROUP}/README.md", b"Text."),
        (
            (
                f"{GROUP}/README.md",
                "Unexpected file.",
                "Remove it, or rename it as described in docs/rollout-log.md.",
            ),
        ),
    ),
    Example(
        "unexpected-name",
        "a README in small letters",
        put("readme.md", b"Text."),
        (("readme.md", "Unexpected file.", "Did you mean 'README.md'?"),),
    ),
    Example(
        "malformed-salt",
        "a salt in capital letters",
        put(f"{GROUP}/traces/salt.txt", b"AB" * 32 + b"\n"),
        (
            (
                f"{GROUP}/traces/salt.txt",
                "The file is not 64 hexadecimal digits (0 to 9, a to f) and a line end.",
                "Run gym-extensions trace with the salt, which writes the file.",
            ),
        ),
    ),
    Example(
        "too-large",
        "a long salt",
        put(f"{GROUP}/traces/salt.txt", b"ab" * 33),
        (
            (
                f"{GROUP}/traces/salt.txt",
                "The file has 66 bytes; the limit is 65.",
                "Leave out everything that the format does not need.",
            ),
        ),
    ),
    Example(
        "too-large",
        "a README above 64 KiB",
        put("README.md", b"a" * (2**16 + 1)),
        (
            (
                "README.md",
                "The file has 65537 bytes; the limit is 65536.",
                "Leave out everything that the format does not need.",
            ),
        ),
    ),
    Example(
        "unexpected-name",
        "a program",
        put("run.py", b"print()"),
        (
            (
                "run.py",
                "Unexpected file.",
                "Remove it, or rename it as described in docs/rollout-log.md.",
            ),
        ),
    ),
    Example(
        "unexpected-name",
        "the trace of a task of another group",
        put(f"{GROUP}/traces/sequential-run0-stage1-Humanoid-episode3.npz", arrays(actions=np.zeros(3))),
        (
            (
                f"{GROUP}/traces/sequential-run0-stage1-Humanoid-episode3.npz",
                "Unexpected file.",
                "Remove it, or rename it as described in docs/rollout-log.md.",
            ),
        ),
    ),
    Example(
        "unexpected-name",
        "a folder among the logs",
        lambda folder: (folder / GROUP / "code").mkdir(),
        ((f"{GROUP}/code", "Unexpected folder.", "Remove it."),),
    ),
    Example(
        "no-logs",
        "a group's folder without a log",
        lambda folder: (folder / "humanoid-gravity").mkdir(),
        (
            (
                "humanoid-gravity",
                "The group folder contains no log.",
                "Add one of sequential.csv, single.csv, joint.csv, or remove the folder.",
            ),
        ),
    ),
    Example(
        "too-large",
        "a long manifest",
        lambda folder: (folder / TOML).write_text((folder / TOML).read_text() + "#" * 2**18),
        (
            (
                TOML,
                "The file has 262695 bytes; the limit is 262144.",
                "Leave out everything that the format does not need.",
            ),
        ),
    ),
    Example(
        "not-a-submission",
        "a renamed folder without submission.toml",
        lambda folder: folder.rename(folder.with_name("elsewhere")).joinpath(TOML).unlink(),
        (
            (
                "elsewhere",
                "The folder contains no submission.toml.",
                WRITE,
            ),
        ),
    ),
    Example(
        "not-a-submission",
        "a training that was interrupted in its first run",
        interrupted,
        (
            (
                "entry",
                "The folder contains no submission.toml.",
                "It contains only unfinished runs: repeat the command that trains them.",
            ),
        ),
    ),
)


@parametrize(EXAMPLES)
def test_the_rule_reports_these_problems_and_no_other(example: Example, check: Check) -> None:
    check(example)
