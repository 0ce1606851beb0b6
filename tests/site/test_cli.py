"""``gym-extensions site`` scores folders of logs and builds their pages."""

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
from gym_extensions.scoring.pipeline import score as pipeline
from gym_extensions.scoring.pipeline.score import score_folders
from gym_extensions.scoring.references import Reference, References
from gym_extensions.site import cli

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

[tuning]
steps = 0
tasks = []

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
            success=None,
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
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working directory; every task of hopper-gravity has the floor 0 and the ceiling 100."""
    monkeypatch.chdir(tmp_path)
    tasks = {task: Reference(0.0, 100.0, unsolved=False) for task in group("hopper-gravity").task_ids}
    references = References("made-up", True, tasks, "0f" * 32)
    for module in (pipeline, cli):
        monkeypatch.setattr(module, "load_references", lambda: references)
    return tmp_path


def test_submissions_are_built_into_the_folder_site_by_default(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    submission(folder / "submissions", "alpha")
    submission(folder / "submissions", "beta")
    assert main(["site"]) == 0
    out = capsys.readouterr().out
    assert out.splitlines()[-1] == "_site/index.html"
    assert out.splitlines()[0].strip() == "sequential, budget 100k"
    (row,) = [line.split() for line in out.splitlines() if line.startswith("hopper-gravity-v0")]
    # 50 + mean(0 … 19) / 7 + run, over 100: .5136 and .5236; 12.706 · .00707 / √2 = .0635 on both sides.
    assert row == ["hopper-gravity-v0", "Alpha", "0.52", "0.46", "to", "0.58", "0.00", "0", "of", "2"]
    page = folder / "_site" / "boards" / "hopper-gravity-v0-sequential-100k.html"
    assert "Alpha" in page.read_text(encoding="utf-8")
    assert "Beta" in page.read_text(encoding="utf-8")


def test_one_submission_and_another_output_folder(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    alpha = submission(folder, "alpha")
    assert main(["site", str(alpha), "--out", "elsewhere/pages"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "elsewhere/pages/index.html"
    index = json.loads((folder / "elsewhere/pages/api/index.json").read_text(encoding="utf-8"))
    assert [row["name"] for row in index["entries"]] == ["alpha"]


def test_a_refused_submission_is_printed_with_all_problems_and_the_exit_status_is_1(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    submission(folder / "submissions", "alpha")
    broken = submission(folder / "submissions", "beta")
    log = broken / "hopper-gravity" / "sequential.csv"
    log.write_text("\n".join(log.read_text(encoding="utf-8").splitlines()[:-1]) + "\n", encoding="utf-8")
    (broken / "[red]:smile:.txt").write_text("unexpected", encoding="utf-8")
    assert main(["site"]) == 1
    out = capsys.readouterr().out
    assert out.splitlines()[-1] == "_site/index.html"
    printed = " ".join(out.split("Refused ")[1].split())
    assert "(not on a board until all problems are fixed): beta Beta (2 problems)" in printed
    (card,) = score_folders([broken]).submissions
    assert len(card.problems) == 2
    for problem in card.problems:
        line = f"{problem.rule} {problem.where}: {problem.message} {problem.hint}"
        assert " ".join(line.split()) in printed
    assert "alpha" not in printed
    assert "19 of 20 episodes" in (folder / "_site/submissions/beta.html").read_text(encoding="utf-8")


def test_characters_outside_the_encoding_of_the_output_are_escaped(folder: Path) -> None:
    alpha = submission(folder / "submissions", "alpha")
    (alpha / "\N{SNOWMAN}.txt").write_text("unexpected", encoding="utf-8")
    command = [sys.executable, "-m", "gym_extensions", "site"]
    ascii_only = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = subprocess.run(command, check=False, capture_output=True, text=True, env=ascii_only)
    assert (done.returncode, done.stderr) == (1, "")
    assert "\\u2603.txt" in done.stdout


def test_a_missing_folder_is_a_usage_error(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["site", "submission"]) == 2
    assert capsys.readouterr().err == (
        "error: submission: There is no such folder. Name a submission, or a folder of submissions.\n"
    )
    assert not (folder / "_site").exists()


def test_a_folder_without_submissions_is_not_a_refused_submission(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "submissions").mkdir()
    (folder / "submissions" / "README.md").write_text("Submissions go here.", encoding="utf-8")
    assert main(["site"]) == 0
    assert capsys.readouterr().out == "submissions contains no submissions.\n_site/index.html\n"
    page = (folder / "_site" / "index.html").read_text(encoding="utf-8")
    assert "There are no submissions yet." in page
    assert "Refused" not in page


def test_a_folder_with_logs_but_no_manifest_is_refused(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (submission(folder, "alpha") / "submission.toml").unlink()
    assert main(["site", "alpha"]) == 1
    assert "not-a-submission alpha: The folder contains no submission.toml." in " ".join(
        capsys.readouterr().out.split()
    )


def test_an_output_folder_that_is_not_a_built_site_is_a_usage_error(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    alpha = submission(folder, "alpha")
    assert main(["site", "alpha", "--out", "alpha"]) == 2
    assert "does not contain a built site" in capsys.readouterr().err
    assert (alpha / "submission.toml").is_file()


def test_verify_replays_valid_submissions_and_shows_how_much(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from gym_extensions.scoring.replay import verify as replay

    replayed = []

    def verify(path: Path, groups: object, salt: None) -> replay.Verification:
        replayed.append(path.name)
        return replay.Verification(1, 1, ())

    monkeypatch.setattr(replay, "verify", verify)
    submission(folder / "submissions", "alpha")
    (submission(folder / "submissions", "beta") / "hopper-gravity" / "sequential.csv").unlink()
    assert main(["site", "--verify"]) == 1
    assert replayed == ["alpha"], "a refused submission is not replayed"
    board = folder / "_site" / "boards" / "hopper-gravity-v0-sequential-100k.html"
    assert '>replayed</a> <span class="sample-size">all episodes</span>' in board.read_text(encoding="utf-8")


def test_the_page_of_a_scored_submission_is_complete(folder: Path) -> None:
    submission(folder / "submissions", "alpha")
    assert main(["site"]) == 0
    page = (folder / "_site" / "submissions" / "alpha.html").read_text(encoding="utf-8")
    for part in (
        "Final performance",
        "Evaluation matrix",
        "The paper’s table",
        "Score of each task over training",
    ):
        assert part in page
    assert "not stated" not in page


def test_ten_entries_need_less_than_five_seconds_of_processor_time_and_no_simulator(folder: Path) -> None:
    for index in range(10):
        submission(folder / "submissions", f"entry-{index}")
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
