"""What pull requests with a new submission do besides, and the rule and path that refuse each."""

from collections.abc import Callable
from pathlib import Path

from .repositories import BOARD_MANIFEST, git

NEW = "submissions/new"
OLD, LOG = "submissions/old/hopper-gravity", f"{NEW}/hopper-gravity/sequential/run0.csv"
IGNORING = f'[submodule "code"]\npath = {NEW}/code\nurl = code\nignore = all\n'
Play = Callable[[Path], object]


def index(project: Path, *rows: tuple[str, str, str]) -> None:
    """Commits files without a work tree: (mode, content or commit id, path)."""
    for mode, content, path in rows:
        data = content.encode()
        object_id = content if mode == "160000" else git(project, "hash-object", "-w", "--stdin", data=data)
        git(project, "update-index", "--add", "--cacheinfo", f"{mode},{object_id},{path}")
    git(project, "commit", "--quiet", "-m", "index")


def file(
    rule: str, path: str, content: str = "x", mode: str = "100644", where: str = ""
) -> tuple[str, str, Play]:
    """A file that is added or changed, and the rule and the place (by default the path) of the refusal."""
    return rule, where or path, lambda project: index(project, (mode, content, path))


def merged(project: Path, *before: str) -> None:
    """A merge commit of the author, on top of the base or of another commit: seeds would follow from it."""
    git(project, "switch", "--quiet", "-c", "tip", "main")
    if before:
        git(project, "commit", "--quiet", "--allow-empty", "-m", *before)
    git(project, "merge", "--quiet", "--no-ff", "--no-edit", "submission")


def trained_copy(project: Path) -> None:
    """The log of a run that the base trained after the branch began."""
    git(project, "switch", "--quiet", "main")
    index(project, ("100644", "x", "submissions/old/trained/2/hopper-gravity/sequential/run7.csv"))
    git(project, "switch", "--quiet", "submission")
    index(project, ("100644", "x", LOG))


def moved(project: Path, *words: str) -> None:
    git(project, *words)
    git(project, "commit", "--quiet", "-m", "move")


PLAYS: dict[str, tuple[str, str, Play]] = {
    "a submission that also edits the scorer": file("code-and-data", "scoring/rank.py", "rank = 9\n"),
    "a submission that also edits a workflow": file("code-and-data", ".github/workflows/gate.yml"),
    "a submission that also edits another submission": file(
        "several-submissions", "submissions/old/README.md", "Worse.\n", where="submissions"
    ),
    "a submission with a review of its own": file("written-by-the-base", f"{NEW}/review.toml"),
    "a submission with a landscape": file(
        "written-by-the-base", f"{NEW}/landscapes/hopper-gravity.json", "{}"
    ),
    "a submission with poses": file("written-by-the-base", f"{NEW}/poses/hopper-gravity.json", "{}\n"),
    "a training of its own": file("written-by-the-base", f"{NEW}/trained/1.toml"),
    "a review of another submission": file("written-by-the-base", "submissions/old/review.toml"),
    "two new submissions": file(
        "several-submissions", "submissions/another/submission.toml", where="submissions"
    ),
    "a file beside the submissions": file("stray-file", "submissions/conftest.py", "import os\n"),
    "a folder of submissions in capitals": file("stray-file", "Submissions/new/submission.toml"),
    "a symbolic link": file("file-mode", f"{NEW}/README.md", "../../scoring/rank.py", "120000"),
    "a submodule": file("file-mode", f"{NEW}/code", "1" * 40, "160000"),
    "a submodule that git is told to ignore": (
        *("file-mode", f"{NEW}/code"),
        lambda project: index(
            project, ("100644", IGNORING, ".gitmodules"), ("160000", "1" * 40, f"{NEW}/code")
        ),
    ),
    "an executable file": file("file-mode", f"{NEW}/README.md", "text", "100755"),
    "a file that is renamed from another submission": (
        "deleted-file",
        LOG.replace("run0", "run7"),
        lambda project: moved(project, "mv", f"{OLD}/sequential/run0.csv", LOG.replace("run0", "run7")),
    ),
    "a file of another submission that is deleted": (
        "deleted-file",
        f"{OLD}/sequential/run0.csv",
        lambda project: moved(project, "rm", "--quiet", f"{OLD}/sequential/run0.csv"),
    ),
    "a name of a device": file("path-characters", f"{NEW}/Nul.csv"),
    "a name that ends in a dot": file("path-characters", f"{NEW}/single.csv."),
    "a hidden file": file("path-characters", f"{NEW}/.gitattributes", "* export-subst"),
    "a name in other letters": file("path-characters", f"{NEW}/τrace.npz"),
    "a name with an escape sequence": file(
        "path-characters", f"{NEW}/\x1b[2J.csv", where=f"{NEW}/\\x1b[2J.csv"
    ),
    "a log of another submission": (
        "copied-run",
        LOG,
        lambda project: index(project, ("100644", (project / OLD / "sequential/run0.csv").read_text(), LOG)),
    ),
    "a log that was trained here": ("copied-run", LOG, trained_copy),
    "a title that looks like another one": file(
        "same-title", f"{NEW}/submission.toml", BOARD_MANIFEST.replace("A submission", "SUBMISSIОN 0LD")
    ),
    "two names that differ in case": file("case-collision", LOG.replace("run0", "Run0"), where=LOG),
    "a merge commit of its author": ("own-merge", LOG, merged),
    "a merge commit after another one": ("own-merge", LOG, lambda project: merged(project, "empty")),
    "a large file": file("too-large", f"{NEW}/README.md", "x" * 65537),
}
