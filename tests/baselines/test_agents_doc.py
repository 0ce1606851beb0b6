"""Every example of docs/agents.md runs as printed, apart from budgets, runs, groups and worker processes.

The first runs as a program; the others run in this process, which has loaded what they import.
"""

import contextlib
import re
import shlex
import statistics
import subprocess
import sys
import textwrap
import tomllib
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gym_extensions.__main__ import main
from gym_extensions.baselines import Context
from gym_extensions.submissions.reader import read
from gym_extensions.submissions.run import read_run

from .conftest import QUICK_GROUP, log_rows

PAGE = Path(__file__).parents[2] / "docs/agents.md"
TEXT = PAGE.read_text(encoding="utf-8")
AGENT, POLICY, CARD, MULTI_HEAD, RECURRENT, SB3 = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
PUSHER_WEIGHTS = 23 * 7
"""Observations times actions: the parameters of the hill climber in that group."""
TWO_HOPPERS = "hopper-motor-noise"
"""A group of two tasks in which agents learn within the budget smoke."""
TRAIN = re.compile(r"^gym-extensions (train (?!.*--by).*)$", re.MULTILINE)
"""Commands that train a submission; a donated run (``--by``) is tested with its rules."""
COMMANDS = TRAIN.findall(TEXT.replace("\\\n", " "))


def run_script(code: str, folder: Path) -> None:
    """Runs a program in this process, which has loaded what it imports, with ``folder`` as current folder."""
    with contextlib.chdir(folder):
        exec(code, {"__name__": "__main__"})


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the hill climber in mine.py and its submission."""
    path = tmp_path_factory.mktemp("submit")
    (path / "mine.py").write_text(AGENT.replace("hopper-gravity", TWO_HOPPERS), encoding="utf-8")
    done = subprocess.run([sys.executable, "mine.py"], cwd=path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return path


def test_the_agent_writes_a_submission_without_problems(folder: Path) -> None:
    assert not read(folder / "submissions/climber").problems


def test_the_agent_learns(folder: Path) -> None:
    returns: dict[str, list[float]] = {}
    for row in log_rows(folder / "submissions/climber" / TWO_HOPPERS / "sequential/run0.csv"):
        returns.setdefault(row["stage"], []).append(float(row["return"]))
    untrained, trained = statistics.mean(returns["0"]), statistics.mean(returns["2"])
    assert trained > 5 * untrained > 0


@pytest.mark.parametrize("command", COMMANDS)
def test_the_commands_train_what_they_name(
    command: str, folder: Path, quick_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    quick = command.replace("--budget 100k --runs 0-4", "--budget smoke --runs 0").replace("--jobs 2", "")
    words = shlex.split(quick.replace("--groups hopper-gravity", f"--groups {quick_file}"))
    monkeypatch.chdir(folder)
    assert main(words) == 0
    group = folder / words[words.index("--out") + 1] / QUICK_GROUP.name
    protocols = words[words.index("--protocol") + 1] if "--protocol" in words else "sequential"
    assert {path.parent.name for path in group.glob("*/run0.csv")} == set(protocols.split(","))


def test_the_card_and_the_policy_are_written(quick_file: Path, tmp_path: Path) -> None:
    code = AGENT.replace("    def learn", f"{CARD}\n{POLICY}\n    def learn")
    code = code.replace("hopper-gravity", str(quick_file)).replace('["sequential", "single"]', '"single"')
    imports = "from gym_extensions.baselines import Card\nfrom gym_extensions.policies import Policy\n"
    run_script(imports + code, tmp_path)
    manifest = tomllib.loads((tmp_path / "submissions/climber/submission.toml").read_text(encoding="utf-8"))
    assert manifest["protocol"]["algorithm"] == "hill climbing"
    document = read_run(tmp_path / "submissions/climber" / QUICK_GROUP.name / "single/run0.json")
    assert document.memory.parameters_last == PUSHER_WEIGHTS
    assert document.policies is not None


def test_the_example_of_stable_baselines3_runs(quick_file: Path, tmp_path: Path) -> None:
    pytest.importorskip("stable_baselines3")
    quick = SB3.replace('"100k"', '"smoke"').replace("[0, 1]", "0").replace('"sequential"', '"single"')
    quick = quick.replace("hopper-gravity", str(quick_file))
    assert [quick.count(text) for text in ("smoke", "runs=0", "single", str(quick_file))] == [1, 1, 1, 1]
    run_script(quick, tmp_path)
    assert len(log_rows(tmp_path / "submissions/sb3" / QUICK_GROUP.name / "single/run0.csv")) == 2 * 20


def test_the_multi_head_agent_declares_what_it_asks_for_and_forgets_no_task(tmp_path: Path) -> None:
    run_script(MULTI_HEAD.replace("hopper-gravity", TWO_HOPPERS), tmp_path)
    folder = tmp_path / "submissions/two-heads"
    manifest = tomllib.loads((folder / "submission.toml").read_text(encoding="utf-8"))
    asked = {"task_in_training": True, "task_in_evaluation": True, "boundaries": False}
    assert manifest["observes"] == asked
    returns: dict[tuple[str, str], list[float]] = {}
    for row in log_rows(folder / TWO_HOPPERS / "sequential/run0.csv"):
        returns.setdefault((row["task"], row["stage"]), []).append(float(row["return"]))
    (first, second) = dict.fromkeys(task for task, _ in returns)
    assert returns[first, "1"] == returns[first, "2"]
    assert returns[second, "1"] == returns[second, "0"]
    for task, stage in ((first, "1"), (second, "2")):
        assert statistics.mean(returns[task, stage]) > 5 * statistics.mean(returns[task, "0"]) > 0


def test_the_recurrent_agent_clears_its_state_where_an_episode_starts() -> None:
    names: dict[str, Any] = {"np": np}
    exec(textwrap.dedent(RECURRENT), names)
    ones = np.ones((2, 2))
    agent = SimpleNamespace(state_size=2, inputs=ones, recurrent=ones, outputs=ones)
    act, observations = names["act"], np.ones((3, 2))
    first = act(agent, observations, Context(np.ones(3, bool)))
    second = act(agent, observations, Context(np.array([False, True, False])))
    assert (first == second).all(axis=1).tolist() == [False, True, False]
