"""Plays, as an ordinary user: a stranger's fork with one file, the gate, the merge, the training, the rank.

``python trained_here.py FOLDER ENTRY FILES`` prints as JSON what became of it. ``FILES`` are the files of
agent/ as JSON. A core of one small group and a small budget stand for the whole.
"""

from __future__ import annotations

import contextlib
import io
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

from gym_extensions.catalog import groups, protocol

groups.CORES[groups.CORE] = ("pusher-v0",)
protocol.BUDGETS["300k"] = protocol.Budget("300k", batches=5, batch_steps=200, num_envs=2)

from gym_extensions.__main__ import main  # noqa: E402
from gym_extensions.curation.gate import check_pull_request  # noqa: E402
from gym_extensions.references import load_references  # noqa: E402
from gym_extensions.scoring.ranking.group_board import boards  # noqa: E402
from gym_extensions.scoring.submission.scorer import score  # noqa: E402
from gym_extensions.submissions.reader import read  # noqa: E402
from gym_extensions.verification.git import Repository  # noqa: E402

IDENTITY = ("-c", "user.name=Tester", "-c", "user.email=tester@example.org", "-c", "commit.gpgsign=false")
MANIFEST = """format = 1
title = "A stranger's agent"
authors = ["A. Stranger"]
description = ""

[agent]
entry = "{entry}"
packages = {packages}

[protocol]
budget = "300k"
algorithm = "stranger"
evaluation = "deterministic"

[observes]
task_in_training = false
task_in_evaluation = false
boundaries = false

[tuning]
steps = 0
tasks = []
"""


def git(folder: Path, *arguments: str) -> str:
    """The output of a git command in a folder."""
    command = ["git", *IDENTITY, "-C", str(folder), *arguments]
    return subprocess.run(command, capture_output=True, check=True).stdout.decode().strip()


def command(*arguments: str) -> tuple[int, str]:
    """The exit status of a command, and what it prints."""
    output = io.StringIO()
    with contextlib.redirect_stdout(output), contextlib.redirect_stderr(output):
        status = main([*arguments])
    return status, output.getvalue()


class Story:
    """The repository of the boards, and a stranger's fork of it."""

    def __init__(self, folder: Path) -> None:
        self.main, self.fork, self.job = folder / "main", folder / "fork", folder / "job"
        self.main.mkdir(parents=True)
        git(self.main, "init", "--quiet", "--initial-branch=main", "--template=")
        git(self.main, "commit", "--quiet", "--allow-empty", "-m", "start")
        git(folder, "clone", "--quiet", str(self.main), str(self.fork))

    def submit(self, files: dict[str, str], *, try_code: bool = True) -> dict[str, Any]:
        """The gate's report on a branch of the fork with these files of ``submissions/new``."""
        for name, text in files.items():
            path = self.fork / "submissions" / "new" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        git(self.fork, "add", "--all")
        git(self.fork, "commit", "--quiet", "-m", "submission")
        git(self.main, "fetch", "--quiet", str(self.fork), "+HEAD:refs/gate/head")
        report = check_pull_request(Repository(self.main), "main", "refs/gate/head", try_code=try_code)
        return dict(json.loads(report.to_json()))

    def merge(self) -> str:
        """Merges the branch, and gives the commit."""
        git(self.main, "merge", "--quiet", "--no-ff", "--no-edit", "refs/gate/head")
        return git(self.main, "rev-parse", "HEAD")

    def train(self, *options: str) -> tuple[int, str]:
        """Both jobs after a merge: one trains in a clone, the other checks and commits what that wrote."""
        git(self.main, "clone", "--quiet", str(self.main), str(self.job))
        new = "submissions/new"
        status, text = command("maintain", "train-here", str(self.job / new), *options)
        taken, more = command(
            *("maintain", "train-here", str(self.main / new), "--take", str(self.job / new / "trained"))
        )
        git(self.main, "add", "--all")
        git(self.main, "commit", "--quiet", "--allow-empty", "-m", "trained")
        return status or taken, text + more

    def result(self) -> dict[str, Any]:
        """Level, rank and failures of the submission."""
        card = score(read(self.main / "submissions" / "new"), load_references())
        core = boards([card]).core
        row = core.rows[0] if core else None
        return {
            "level": card.level,
            "problems": [f"{each.where}: {each.message}" for each in card.problems],
            "ranked": bool(row and row.ranked),
            "core_level": row and row.level,
            "why": row and row.why,
            "mean": row and row.metrics["final_performance"].mean,
            "attempts": card.training and card.training.attempts,
            "failed": card.training and card.training.failed,
            "value": card.training and card.training.commit,
        }


if __name__ == "__main__":
    story, found = Story(Path(sys.argv[1])), dict[str, Any]()
    sources = {f"agent/{name}": text for name, text in json.loads(sys.argv[3]).items()}
    packages = json.dumps(sys.argv[4:])
    sources["submission.toml"] = MANIFEST.format(entry=sys.argv[2], packages=packages)
    found["gate"] = story.submit(sources)
    if found["gate"]["verdict"] == "passed":
        found["merge"] = story.merge()
        found["status"], found["output"] = story.train("--runs", "5")
        found |= story.result()
    sys.stdout.write(json.dumps(found))
