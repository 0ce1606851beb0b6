"""What pull requests with a new entry do besides, and the rule and path that refuse each."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from .repositories import commit, git

NEW = "submissions/new"
OLD, GRAVITY = "submissions/old/hopper-gravity", f"{NEW}/hopper-gravity"
Play = Callable[[Path], object]


def index(project: Path, *rows: tuple[str, str, str]) -> None:
    """Commits files without a work tree: (mode, content or commit id, path)."""
    for mode, content, path in rows:
        data = content.encode()
        object_id = content if mode == "160000" else git(project, "hash-object", "-w", "--stdin", data=data)
        git(project, "update-index", "--add", "--cacheinfo", f"{mode},{object_id},{path}")
    git(project, "commit", "--quiet", "-m", "index")


PLAYS: dict[str, tuple[str, str, Play]] = {
    "a submission that also edits the scorer": (
        "code-and-data",
        "scoring/rank.py",
        lambda project: commit(project, {"scoring/rank.py": "rank = 9\n"}),
    ),
    "a submission that also edits a workflow": (
        "code-and-data",
        ".github/workflows/gate.yml",
        lambda project: commit(project, {".github/workflows/gate.yml": "on: push\n"}),
    ),
    "a submission that also edits another entry": (
        "several-entries",
        "submissions",
        lambda project: commit(project, {"submissions/old/README.md": "Worse.\n"}),
    ),
    "a submission with a review of its own": (
        "written-by-the-base",
        f"{NEW}/review.toml",
        lambda project: commit(project, {f"{NEW}/review.toml": "verifications = []\n"}),
    ),
    "a submission with poses": (
        "written-by-the-base",
        f"{NEW}/poses/hopper-gravity.json",
        lambda project: commit(project, {f"{NEW}/poses/hopper-gravity.json": "{}\n"}),
    ),
    "a review of another entry": (
        "written-by-the-base",
        "submissions/old/review.toml",
        lambda project: commit(project, {"submissions/old/review.toml": "decisions = []\n"}),
    ),
    "two new entries": (
        "several-entries",
        "submissions",
        lambda project: index(project, ("100644", "x", "submissions/another/submission.toml")),
    ),
    "a file beside the entries": (
        "stray-file",
        "submissions/conftest.py",
        lambda project: commit(project, {"submissions/conftest.py": "import os\n"}),
    ),
    "policies of the old form": (
        "stray-file",
        f"{NEW}/hopper-gravity/policies/run0.npz",
        lambda project: commit(project, {f"{NEW}/hopper-gravity/policies/run0.npz": "x"}),
    ),
    "a folder of submissions in capitals": (
        "stray-file",
        "Submissions/new/submission.toml",
        lambda project: index(project, ("100644", "x", "Submissions/new/submission.toml")),
    ),
    "a symbolic link": (
        "symbolic-link",
        f"{NEW}/README.md",
        lambda project: index(project, ("120000", "../../scoring/rank.py", f"{NEW}/README.md")),
    ),
    "a submodule": (
        "submodule",
        f"{NEW}/code",
        lambda project: index(project, ("160000", "1" * 40, f"{NEW}/code")),
    ),
    "an executable file": (
        "file-mode",
        f"{NEW}/README.md",
        lambda project: index(project, ("100755", "text", f"{NEW}/README.md")),
    ),
    "a file that is renamed from another entry": (
        "renamed-file",
        f"{NEW}/hopper-gravity/sequential/run7.csv",
        lambda project: (
            git(
                project,
                "mv",
                "submissions/old/hopper-gravity/sequential/run0.csv",
                f"{NEW}/hopper-gravity/sequential/run7.csv",
            ),
            git(project, "commit", "--quiet", "-m", "move"),
        ),
    ),
    "a file of another entry that is deleted": (
        "deleted-file",
        "submissions/old/hopper-gravity/sequential/run0.csv",
        lambda project: commit(project, {"submissions/old/hopper-gravity/sequential/run0.csv": None}),
    ),
    "a name of a device": (
        "reserved-name",
        f"{NEW}/Nul.csv",
        lambda project: index(project, ("100644", "x", f"{NEW}/Nul.csv")),
    ),
    "a name that ends in a dot": (
        "reserved-name",
        f"{NEW}/single.csv.",
        lambda project: index(project, ("100644", "x", f"{NEW}/single.csv.")),
    ),
    "a hidden file": (
        "path-characters",
        f"{NEW}/.gitattributes",
        lambda project: index(project, ("100644", "* export-subst", f"{NEW}/.gitattributes")),
    ),
    "a name in other letters": (
        "path-characters",
        f"{NEW}/τrace.npz",
        lambda project: index(project, ("100644", "x", f"{NEW}/τrace.npz")),
    ),
    "a name with an escape sequence": (
        "path-characters",
        f"{NEW}/\\x1b[2J.csv",
        lambda project: index(project, ("100644", "x", f"{NEW}/\x1b[2J.csv")),
    ),
    "a log of another entry": (
        "copied-run",
        f"{NEW}/hopper-gravity/sequential/run0.csv",
        lambda project: commit(
            project,
            {
                f"{NEW}/hopper-gravity/sequential/run0.csv": (
                    project / "submissions/old/hopper-gravity/sequential/run0.csv"
                ).read_bytes()
            },
        ),
    ),
    "two names that differ in case": (
        "case-collision",
        f"{NEW}/hopper-gravity/sequential/run0.csv",
        lambda project: index(project, ("100644", "x", f"{NEW}/hopper-gravity/sequential/Run0.csv")),
    ),
    "a large file": (
        "too-large",
        f"{NEW}/README.md",
        lambda project: commit(project, {f"{NEW}/README.md": b"x" * 65537}),
    ),
}
