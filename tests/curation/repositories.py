"""Small git repositories with submissions, made in a test's folder."""

import subprocess
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from gym_extensions.curation.gate import check_pull_request
from gym_extensions.curation.gate_report import GateReport
from gym_extensions.submissions.policies.mlp import Policy
from gym_extensions.verification.git import Repository

from .. import conftest
from ..conftest import MANIFEST

BOARD_MANIFEST = MANIFEST.replace('"smoke"', '"100k"')
"""The manifest of a submission that boards show."""
IDENTITY = ("-c", "user.name=Tester", "-c", "user.email=tester@example.org", "-c", "commit.gpgsign=false")


def git(folder: Path, *arguments: str, data: bytes | None = None) -> str:
    """The output of a git command in a folder."""
    command = ["git", *IDENTITY, "-C", str(folder), *arguments]
    return subprocess.run(command, input=data, capture_output=True, check=True).stdout.decode().strip()


def make_repository(folder: Path) -> Path:
    """A repository with the branch ``main`` and no commit."""
    folder.mkdir(parents=True, exist_ok=True)
    git(folder, "init", "--quiet", "--initial-branch=main", "--template=")
    return folder


def commit(
    folder: Path, files: Mapping[str, str | bytes | None] | None = None, message: str = "change"
) -> str:
    """Writes files (None removes one), commits everything, and gives the commit's id."""
    for name, content in (files or {}).items():
        path = folder / name
        if content is None:
            path.unlink()
            continue
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    git(folder, "add", "--all", "--force")
    git(folder, "commit", "--quiet", "--allow-empty", "-m", message)
    return git(folder, "rev-parse", "HEAD")


def merge(folder: Path, files: Mapping[str, str | bytes | None]) -> str:
    """Commits files on a branch, merges it into the current one, and gives the merge's id."""
    branch = git(folder, "branch", "--show-current")
    git(folder, "commit", "--quiet", "--allow-empty", "-m", "start")
    git(folder, "switch", "--quiet", "--force-create", "merged")
    commit(folder, files)
    git(folder, "switch", "--quiet", branch)
    git(folder, "merge", "--quiet", "--no-ff", "--no-edit", "merged")
    return git(folder, "rev-parse", "HEAD")


def write_submission(folder: Path, name: str, bonus: float = 0.0, group: str = "hopper-gravity") -> Path:
    """A small submission with policies that act at random: one group, two runs, sequential and single."""

    def value(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
        return bonus + 10.0 * position + run + episode / 8

    manifest = BOARD_MANIFEST.replace("A submission", f"Submission {name}")
    policy = Policy(np.full(3, bonus / 100), np.ones(3), head="uniform")
    return conftest.write_submission(
        folder, name=name, groups=(group,), value=value, manifest=manifest, policy=policy
    )


def make_project(folder: Path) -> Path:
    """A repository with code and a submission.

    The branch ``request``, which is checked out, equals ``main``; the branch ``submission`` adds a new
    submission.
    """
    make_repository(folder)
    write_submission(folder / "submissions", "old")
    commit(folder, {"scoring/rank.py": "rank = 1\n"})
    git(folder, "switch", "--quiet", "-c", "submission")
    write_submission(folder / "submissions", "new", bonus=7.0)
    commit(folder)
    git(folder, "switch", "--quiet", "-c", "request", "main")
    return folder


def checked(project: Path, base: str = "main", **options: object) -> GateReport:
    """The report on the project's branch that is checked out, as a pull request to ``main``."""
    return check_pull_request(Repository(project), base, **options)  # type: ignore[arg-type]


def rules(report: GateReport) -> list[tuple[str, str]]:
    """The rule and the place of every problem."""
    return [(problem.rule, problem.where) for problem in report.problems]
