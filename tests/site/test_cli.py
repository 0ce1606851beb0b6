"""``gym-extensions site``: from folders of logs to pages, through the scorer itself."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from gym_extensions.__main__ import main
from gym_extensions.atomic import write_text
from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, evaluation_seed
from gym_extensions.rollouts.episodes import Episode, write_episodes
from gym_extensions.scoring.pipeline import score as scorecard
from gym_extensions.scoring.pipeline.score import score_folders
from gym_extensions.scoring.references import Reference, References

MANIFEST = """format = 1
title = "{title}"
authors = ["A. Researcher"]
description = "Made for a test."

[code]
url = ""
commit = ""

[protocol]
budget = "100k"
algorithm = "none"
evaluation = "sampled"

[observes]
task_in_training = false
task_in_evaluation = false
boundaries = false

[memory]
stored_steps = 0
parameters_first = 0
parameters_last = 0

[versions]
gym_extensions = "1.0.0.dev0"
gymnasium = "1.4.0"
mujoco = "4.0.0"
numpy = "2.4.6"
python = "3.11.7"
platform = "Linux-x86_64"
"""


def submission(root: Path, name: str, runs: int = 2) -> Path:
    """A complete sequential entry on hopper-gravity, and its folder."""
    hopper = group("hopper-gravity")
    rows = [
        Episode(
            run=run,
            stage=stage,
            task=task.id,
            episode=episode,
            seed=evaluation_seed(hopper.id, task.id, episode),
            length=100 + episode,
            return_=20.0 + 30 * (stage > index) + run + episode / 7,
            terminated=True,
            fingerprint=published(task.id),
        )
        for run in range(runs)
        for stage in range(len(hopper.tasks) + 1)
        for index, task in enumerate(hopper.tasks)
        for episode in range(EVALUATION_EPISODES)
    ]
    folder = root / name
    write_text(folder / "submission.toml", MANIFEST.format(title=name.title()))
    write_episodes(folder / "hopper-gravity" / "sequential.csv", rows, hopper.task_ids)
    return folder


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working directory; every task of hopper-gravity has the floor 0 and the ceiling 100."""
    monkeypatch.chdir(tmp_path)
    tasks = {task: Reference(0.0, 100.0, unsolved=False) for task in group("hopper-gravity").task_ids}
    monkeypatch.setattr(scorecard, "load_references", lambda: References("made-up", True, tasks, "0f" * 32))
    return tmp_path


def test_it_builds_submissions_into_site_by_default(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    submission(here / "submissions", "alpha")
    submission(here / "submissions", "beta")
    assert main(["site"]) == 0
    out = capsys.readouterr().out
    assert out.splitlines()[-1] == "_site/index.html"
    assert out.splitlines()[0].strip() == "sequential, budget 100k"
    (row,) = [line.split() for line in out.splitlines() if line.startswith("hopper-gravity-v0")]
    # 50 + mean(0 … 19) / 7 + run, over 100: .5136 and .5236; 12.706 · .00707 / √2 = .0635 on both sides.
    assert row == ["hopper-gravity-v0", "Alpha", "0.52", "0.46", "to", "0.58", "0.00", "2"]
    page = (here / "_site" / "index.html").read_text(encoding="utf-8")
    assert "Alpha" in page
    assert "Beta" in page


def test_one_folder_and_another_place(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = submission(here, "alpha")
    assert main(["site", str(folder), "--out", "elsewhere/pages"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "elsewhere/pages/index.html"
    document = json.loads((here / "elsewhere/pages/scorecards.json").read_text(encoding="utf-8"))
    assert [row["name"] for row in document["submissions"]] == ["alpha"]


def test_every_problem_of_a_refused_submission_is_told_and_makes_exit_one(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    submission(here / "submissions", "alpha")
    broken = submission(here / "submissions", "beta")
    log = broken / "hopper-gravity" / "sequential.csv"
    log.write_text("\n".join(log.read_text(encoding="utf-8").splitlines()[:-1]) + "\n", encoding="utf-8")
    (broken / "[red]:smile:.txt").write_text("of no use", encoding="utf-8")
    assert main(["site"]) == 1
    out = capsys.readouterr().out
    assert out.splitlines()[-1] == "_site/index.html"
    told = " ".join(out.split("Refused, ")[1].split())
    assert "on no board until every problem is gone: beta Beta (2 problems)" in told
    (card,) = score_folders([broken]).submissions
    assert len(card.problems) == 2
    for problem in card.problems:
        place = f"{problem.rule} {problem.where}: {problem.message} {problem.hint}"
        assert " ".join(place.split()) in told
    assert "alpha" not in told
    assert "19 of 20 episodes" in (here / "_site/submissions/beta.html").read_text(encoding="utf-8")


def test_what_an_encoding_cannot_say_does_not_stop_the_output(here: Path) -> None:
    folder = submission(here / "submissions", "alpha")
    (folder / "\N{SNOWMAN}.txt").write_text("of no use", encoding="utf-8")
    command = [sys.executable, "-m", "gym_extensions", "site"]
    ascii_only = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = subprocess.run(command, check=False, capture_output=True, text=True, env=ascii_only)
    assert (done.returncode, done.stderr) == (1, "")
    assert "\\u2603.txt" in done.stdout


def test_a_folder_that_is_not_there_is_told(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["site", "submission"]) == 2
    assert capsys.readouterr().err == (
        "error: submission: There is no such folder. Name a submission, or a folder of submissions.\n"
    )
    assert not (here / "_site").exists()


def test_a_folder_that_is_not_a_site_is_left_alone(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = submission(here, "alpha")
    assert main(["site", "alpha", "--out", "alpha"]) == 2
    assert "no site was built in it" in capsys.readouterr().err
    assert (folder / "submission.toml").is_file()


def test_verify_replays_and_shows_how_much(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from gym_extensions.scoring.replay import verify as replay

    replayed = []

    def verify(path: Path) -> replay.Verification:
        replayed.append(path.name)
        return replay.Verification(1, 1, ())

    monkeypatch.setattr(replay, "verify", verify)
    submission(here / "submissions", "alpha")
    (submission(here / "submissions", "beta") / "hopper-gravity" / "sequential.csv").unlink()
    assert main(["site", "--verify"]) == 1
    assert replayed == ["alpha"], "what is refused anyway is not replayed"
    assert ">replayed (all)</a>" in (here / "_site" / "index.html").read_text(encoding="utf-8")


def test_the_scorers_document_has_every_key_that_the_pages_read(here: Path) -> None:
    submission(here / "submissions", "alpha")
    assert main(["site"]) == 0
    page = (here / "_site" / "submissions" / "alpha.html").read_text(encoding="utf-8")
    for part in ("Final performance", "Evaluation matrix", "The paper’s table", "What became of each task"):
        assert part in page
    assert "no reason given" not in page
    assert "not said" not in page


def test_ten_entries_are_built_in_five_seconds_of_work_without_a_simulator(here: Path) -> None:
    for index in range(10):
        submission(here / "submissions", f"entry-{index}")
    program = (
        "import sys; from gym_extensions.__main__ import main; status = main(['site']);"
        "print(sorted({'mujoco', 'gymnasium', 'torch'} & set(sys.modules))); sys.exit(status)"
    )
    before = os.times()
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    after = os.times()
    assert done.stdout.splitlines()[-1] == "[]"
    used = after.children_user + after.children_system - before.children_user - before.children_system
    assert used < 5
