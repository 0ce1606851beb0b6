"""The whole story with git repositories: one file of code, the gate, the merge, the training, the rank."""

import json
import re
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from ..baselines.isolated.conftest import ROOT, Ordinary, ordinary

__all__ = ["ordinary"]
STORY = (Path(__file__).parent / "trained_here.py").read_text(encoding="utf-8")
PAGE = (ROOT / "docs/submit.md").read_text(encoding="utf-8")
(CLIMBER,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
LEARN = "        best, best_return = self.weights, -np.inf\n"
Tell = Callable[..., dict[str, Any]]


@pytest.fixture
def tell(ordinary: Ordinary, tmp_path_factory: pytest.TempPathFactory) -> Tell:
    """Plays the story of an agent: hill climbing with these lines at the start of ``learn``."""

    def play(learn: str = "", *packages: str, source: str = CLIMBER, options: tuple[str, ...] = ()) -> Any:
        assert LEARN in CLIMBER
        text = source.replace(LEARN, textwrap.indent(learn, " " * 8) + LEARN)
        folder = ordinary.home / tmp_path_factory.mktemp("story").name
        files = json.dumps({"agent.py": text})
        return ordinary.run(
            STORY, str(folder), "agent.py:HillClimber", files, json.dumps([*packages]), *options
        )

    return play


def test_one_file_gets_a_rank_on_the_core(tell: Tell) -> None:
    found = tell()
    gate = found["gate"]
    assert (gate["verdict"], gate["trains"], gate["problems"]) == ("passed", True, [])
    assert gate["notes"] == ["Trained twice, it gives the same bytes."]
    assert found["status"] == 0
    assert "time left" in found["output"]
    assert (found["due"], found["due_again"]) == ('["new"]', "[]")
    assert found["changed"] == "?? submissions/new/trained/"
    assert (found["level"], found["core_level"], found["ranked"]) == (*["trained here"] * 2, True)
    training = found["training"]
    assert (training["attempts"], training["failed"], found["problems"]) == (1, {}, [])
    assert training["commit"] == found["merge"], "which nobody knew before"


@pytest.mark.slow
def test_seeds_are_the_worlds_even_if_an_agent_ignores_its_own(tell: Tell) -> None:
    found = tell("self.random = np.random.default_rng(12345)\n", options=("--short",))
    assert len(set(found["scores"])) == 2


@pytest.mark.slow
def test_an_agent_that_draws_from_the_machine_is_told_so(tell: Tell) -> None:
    (note,) = tell("self.random = np.random.default_rng()\n")["gate"]["notes"]
    assert note.startswith("Trained twice, it differs from stage")


def test_an_agent_that_fails_counts_as_the_floor_and_is_not_tried_again(tell: Tell) -> None:
    found = tell("raise ValueError('too late')\n", options=("--short",))
    assert found["gate"]["verdict"] == "passed"
    assert (found["status"], found["level"]) == (0, "trained here")
    assert len(found["training"]["failed"]) == 2
    for verdict in found["training"]["failed"].values():
        assert "after 0 of 1,000 steps" in verdict
        assert "too late (agent.py, line" in verdict
        assert len(verdict) <= 500
    assert max(map(abs, found["scores"])) < 0.05
    assert "failed: " not in found["again"], "nothing runs again"
    assert found["again"].startswith("new: 2 runs trained here.")


@pytest.mark.slow
def test_a_trial_comes_before_the_training_and_is_no_part_of_it(tell: Tell) -> None:
    found = tell(options=("--short", "--try"))
    status, output = found["tried"]
    assert (status, "new: 2 runs tried, in" in output) == (0, True)
    assert "new: 2 runs trained here." in found["output"]
    assert "time left" in found["output"], "it trains"
    assert (found["level"], found["due_again"], found["problems"]) == ("trained here", "[]", [])


@pytest.mark.parametrize(
    "learn", ["", pytest.param("raise ValueError('too late')\n", marks=pytest.mark.slow, id="it fails")]
)
def test_runs_in_another_order_are_trained_here_and_are_not_the_core(tell: Tell, learn: str) -> None:
    found = tell(learn, options=("--short", "--balanced"))
    assert (found["status"], found["level"], found["problems"]) == (0, "trained here", [])
    failed = {f"pusher/balanced/run{run}" for run in (0, 1)} if learn else set()
    assert set(found["training"]["failed"]) == failed
    assert (max(map(abs, found["scores"])) < 0.05) == bool(learn)
    assert (found["core_level"], found["ranked"], found["due_again"]) == (None, False, '["new"]')


def test_the_gate_refuses_what_it_can_read_or_try(tell: Tell) -> None:
    carried = "W = [\n" + "0.125, -1.5,\n" * 200 + "]\n"
    for text, rule, where in (
        (f"import mujoco\n{CLIMBER}", "foreign-package", "agent/agent.py, line 1"),
        (f"{carried}{CLIMBER}", "many-numbers", "agent"),
        (f"import numpy.missing\n{CLIMBER}", "agent-failed", "at its import"),
        (CLIMBER.replace("return np.tanh(", "return np.nan * ("), "bad-actions", "act()"),
    ):
        (problem,) = tell(source=text)["gate"]["problems"]
        assert (problem["rule"], where in problem["where"]) == (rule, True), problem


@pytest.mark.slow
def test_a_machine_that_dies_goes_on_and_trains_nothing_twice(tell: Tell) -> None:
    found = tell(options=("--interrupt", "--short"))
    assert (found["status"], found["level"]) == (0, "trained here")
    assert found["kept"] == 3, "log, document and policies of the first run"
    assert found["same"], "they were not written again"
