"""The lines of docs/submit.md, run as they stand."""

from __future__ import annotations

import csv
import re
import subprocess
import sys
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs/submit.md"


def blocks() -> list[str]:
    return re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


def test_the_agent_is_twenty_lines_or_so():
    lines = [line for line in blocks()[0].splitlines() if line.strip()]
    assert len(lines) <= 22


def test_the_twenty_lines_make_a_valid_submission(tmp_path):
    (tmp_path / "mine.py").write_text(blocks()[0], encoding="utf-8")
    subprocess.run([sys.executable, "mine.py"], cwd=tmp_path, check=True)
    made = tmp_path / "submissions/climber"
    with (made / "hopper-gravity/sequential.csv").open() as file:
        assert len(list(csv.DictReader(file))) == 6 * 5 * 20
    score = [sys.executable, "-m", "gym_extensions", "score", "--verify", str(made)]
    done = subprocess.run(score, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "replayed (sample: 15 of 700 episodes)" in done.stdout


def test_the_command_of_the_page_trains_what_it_says_and_nothing_else(tmp_path):
    (tmp_path / "mine.py").write_text(blocks()[0], encoding="utf-8")
    (command,) = re.findall(
        r"gym-extensions (train mine:.*?)\n```", PAGE.read_text(encoding="utf-8"), re.DOTALL
    )
    short = command.replace("\\\n", " ").replace("100k --runs 0-4", "smoke --runs 0")
    train = [sys.executable, "-m", "gym_extensions", *short.split()]
    subprocess.run(train, cwd=tmp_path, check=True, capture_output=True)
    assert [path.name for path in (tmp_path / "submissions").iterdir()] == ["climber-100k"]


def test_the_card_of_the_page_says_what_the_manifest_says(tmp_path):
    code = blocks()[0].replace("    def learn", f"{blocks()[1]}\n    def learn")
    code = "from gym_extensions.baselines.agent import Card\n" + code
    (tmp_path / "mine.py").write_text(code, encoding="utf-8")
    subprocess.run([sys.executable, "mine.py"], cwd=tmp_path, check=True, capture_output=True)
    said = (tmp_path / "submissions/climber/submission.toml").read_text(encoding="utf-8")
    assert 'evaluation = "deterministic"' in said
    assert "parameters_last = 33" in said


def test_the_line_for_stable_baselines3_is_ours():
    from gym_extensions.baselines import train

    pytest.importorskip("torch")
    from gym_extensions.baselines.adapters import sb3

    assert "train(sb3(PPO" in blocks()[2]
    assert callable(sb3.sb3)
    assert callable(train.train)
