"""Plays, as an ordinary user: a stranger's fork with one file, the gate, the merge, the training, the rank.

``python trained_here.py FOLDER ENTRY FILES PACKAGES`` prints as JSON what became of it. ``FILES`` are the
files of agent/ and ``PACKAGES`` what [agent] states, as JSON. A core of one small group and a small budget
stand for the whole. With ``--hopper``, the group is of Hopper; with ``--interrupt``, the machine dies after
the first run; with ``--short``, two runs are trained, and the gate does not try the code; with
``--balanced``, they are balanced ones; with ``--try``, a trial comes before them.
"""

import contextlib
import io
import json
import subprocess
import sys
from functools import partial
from pathlib import Path
from typing import Any

import msgspec

from gym_extensions.catalog import groups, protocol

GROUP = "hopper-motor-noise" if "--hopper" in sys.argv else "pusher"
groups.CORES[groups.CORE] = (f"{GROUP}-v0",)
protocol.BUDGETS["300k"] = protocol.Budget("300k", batches=5, batch_steps=200, num_envs=2)

from gym_extensions import baselines  # noqa: E402
from gym_extensions.__main__ import main  # noqa: E402
from gym_extensions.baselines import Monitor, StageStarted  # noqa: E402
from gym_extensions.curation.gate import check_pull_request  # noqa: E402
from gym_extensions.metrics.formulas import CORE_METRICS  # noqa: E402
from gym_extensions.references import load_references  # noqa: E402
from gym_extensions.scoring.ranking import core_board  # noqa: E402
from gym_extensions.scoring.ranking.group_board import boards  # noqa: E402
from gym_extensions.scoring.submission.scorer import score  # noqa: E402
from gym_extensions.site.charts import line_charts  # noqa: E402
from gym_extensions.site.submission_results import SubmissionResult  # noqa: E402
from gym_extensions.submissions.reader import read  # noqa: E402
from gym_extensions.verification.git import Repository  # noqa: E402

NEW, FULL = "submissions/new", 5
RUNS = 2 if "--short" in sys.argv else FULL
ORDER = ("--protocol", "balanced", "--groups", GROUP) if "--balanced" in sys.argv else ()
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
algorithm = "hill climbing"
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
            path = self.fork / NEW / name
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

    def train(self, *more: str) -> tuple[int, str]:
        """The job that trains after a merge, in a clone."""
        if not self.job.exists():
            git(self.main, "clone", "--quiet", str(self.main), str(self.job))
        return command("maintain", "train-here", str(self.job / NEW), "--runs", str(RUNS), *ORDER, *more)

    def take(self) -> str:
        """The job that checks and commits what the other one wrote; what it changes."""
        status, text = command(
            *("maintain", "train-here", str(self.main / NEW), "--take", str(self.job / NEW / "trained"))
        )
        assert status == 0, text
        changed = git(self.main, "status", "--porcelain")
        git(self.main, "add", "--all")
        git(self.main, "commit", "--quiet", "-m", "trained")
        return changed

    def due(self) -> str:
        """What the first job would train."""
        words = str(self.main / "submissions"), "--due", "--runs", str(RUNS)
        return command("maintain", "train-here", *words)[1].strip()

    def result(self) -> dict[str, Any]:
        """Level, rank and failures of the submission."""
        card = score(read(self.main / NEW), load_references())
        core_board.left_out = lambda logs: iter(())  # of one group, no part can be left out
        of_group = next(iter(card.groups[f"{GROUP}-v0"].values()))
        core = boards([card]).core
        row = core.rows[0] if core else None
        return {
            "level": card.level,
            "problems": [f"{each.where}: {each.message}" for each in card.problems],
            "ranked": bool(row and row.ranked),
            "core_level": row and row.level,
            "why": row and row.why,
            "means": {name: row and row.metrics[name].mean for name in CORE_METRICS},
            "scores": of_group.metrics["final_performance"].runs,
            "page": [facts for _, facts, _ in line_charts.curves(SubmissionResult(GROUP, "", of_group))],
            "training": msgspec.to_builtins(card.training),
        }


class MachineDies(BaseException):
    """As if the power were cut."""


def dying(event: object) -> None:
    if isinstance(event, StageStarted) and event.job.endswith("run1"):
        raise MachineDies


def dead(train: Any, *words: Any, **options: Any) -> Any:
    return train(*words, **options | {"progress": Monitor(callback=dying)})


def interrupted(story: Story) -> dict[str, bytes]:
    """Trains until the machine dies, after one run. Returns the files that are finished then."""
    train = baselines.train
    baselines.train = partial(dead, train)
    with contextlib.suppress(MachineDies):
        story.train()
    baselines.train = train
    runs = story.job / NEW / "trained"
    half = runs / f"1/{GROUP}/sequential/run1.json"
    half.write_bytes(half.with_stem("run0").read_bytes())  # it was about to write the log
    return {str(path): path.read_bytes() for path in runs.glob(f"1/{GROUP}/*/run0.*")}


if __name__ == "__main__":
    story, found = Story(Path(sys.argv[1])), dict[str, Any]()
    sources = {f"agent/{name}": text for name, text in json.loads(sys.argv[3]).items()}
    sources["submission.toml"] = MANIFEST.format(entry=sys.argv[2], packages=sys.argv[4])
    found["gate"] = story.submit(sources, try_code=RUNS == FULL)
    if found["gate"]["verdict"] == "passed":
        found["merge"], found["due"] = story.merge(), story.due()
        kept = interrupted(story) if "--interrupt" in sys.argv else {}
        found["kept"] = len(kept)
        if "--try" in sys.argv:
            found["tried"] = story.train("--trial", str(story.job.with_name("trial")))
        found["status"], found["output"] = story.train()
        found["same"] = all(Path(path).read_bytes() == data for path, data in kept.items())
        found["changed"], found["due_again"] = story.take(), story.due()
        _, found["again"] = story.train()
        found |= story.result()
    sys.stdout.write(json.dumps(found))
