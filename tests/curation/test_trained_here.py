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
RAISE = "raise ValueError('too late')\n"
START = "self.random.normal(0, 0.3, (observation_space.shape[0], action_space.shape[0]))"
LINEAR = """np.array([
            -0.14, -0.4, 0.6, -0.74, 0.05, 0.26, 0.31, 0.39, 0.56, 0.57, -0.42, -0.79,
            -0.35, 1.05, -1.21, 0.07, 0.17, 0.91, 0.16, -1.9, -0.25, -0.77, -0.57, -0.74,
            -1.31, -0.79, 0.88, -0.13, 0.44, -0.72, 1.18, 1.17, -2.12
        ]).reshape(11, 3)"""
"""The weights of a policy for Hopper, found by 99 trials of hill climbing; its mean return was 420."""
CARRYING = CLIMBER.replace(START, LINEAR)
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
def test_a_policy_in_the_code_is_seen_by_its_first_return(tell: Tell) -> None:
    """It passes the gate and has a rank; the page shows that it was better than the floor from the start."""
    assert LINEAR in CARRYING
    found = tell("trials = 1\n", source=CARRYING, options=("--hopper",))
    assert (found["gate"]["verdict"], found["problems"]) == ("passed", [])
    assert (found["level"], found["ranked"]) == ("trained here", True)
    assert len(found["page"]) == 2, "tasks"
    for facts in found["page"]:
        ((first, floor),) = re.findall(r"first (\d+), floor (\d+)", facts)
        assert int(first) > int(floor), "as in each of 30 runs: 165 to 571 over 146, 152 to 566 over 36"


@pytest.mark.slow
def test_an_agent_states_the_package_of_the_box_that_it_needs(tell: Tell) -> None:
    source = f"import scipy\n{CLIMBER}"
    (problem,) = tell(source=source, options=("--short",))["gate"]["problems"]
    assert problem["rule"] == "foreign-package"
    found = tell("", "scipy", source=source, options=("--short",))
    assert (found["gate"]["problems"], found["training"]["failed"]) == ([], {})
    assert found["level"] == "trained here"


@pytest.mark.slow
def test_an_agent_that_draws_from_the_machine_is_told_so(tell: Tell) -> None:
    (note,) = tell("self.random = np.random.default_rng()\n")["gate"]["notes"]
    assert note.startswith("Trained twice, it differs from stage")


@pytest.mark.parametrize(
    ("learn", "words"),
    [
        pytest.param(RAISE, ["after 0 of 1,000 steps", "too late (agent.py, line"], id="raises"),
        pytest.param("import os\nos._exit(3)\n", ["status 3"], marks=pytest.mark.slow, id="ends itself"),
        pytest.param(
            "steps *= 10\n", ["its budget is 1000"], marks=pytest.mark.slow, id="ten times the steps"
        ),
    ],
)
def test_an_agent_that_fails_counts_as_the_floor_and_is_not_tried_again(
    tell: Tell, learn: str, words: list[str]
) -> None:
    found = tell(learn, options=("--short",))
    assert found["gate"]["verdict"] == "passed"
    assert (found["status"], found["level"]) == (0, "trained here")
    assert len(found["training"]["failed"]) == 2
    for verdict in found["training"]["failed"].values():
        assert all(each in verdict for each in words)
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


@pytest.mark.slow
def test_a_failure_in_another_order_counts_as_the_floor_and_is_not_the_core(tell: Tell) -> None:
    """Runs in another order that do not fail: tests/verification/test_train_here.py."""
    found = tell(RAISE, options=("--short", "--balanced"))
    assert (found["status"], found["level"], found["problems"]) == (0, "trained here", [])
    assert set(found["training"]["failed"]) == {f"pusher/balanced/run{run}" for run in (0, 1)}
    assert max(map(abs, found["scores"])) < 0.05
    assert (found["core_level"], found["ranked"], found["due_again"]) == (None, False, '["new"]')


def test_the_gate_refuses_what_it_can_read_or_try(tell: Tell) -> None:
    for text, rule, where in (
        (f"import mujoco\n{CLIMBER}", "foreign-package", "agent/agent.py, line 1"),
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
