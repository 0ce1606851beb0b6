"""The lines of docs/submit.md, run as they stand."""

from __future__ import annotations

import csv
import re
import subprocess
import sys
from pathlib import Path

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


def test_the_line_for_stable_baselines3_is_ours():
    from gym_extensions.baselines import sb3, train

    assert "train(sb3(PPO" in blocks()[1]
    assert callable(sb3.sb3)
    assert callable(train.train)
