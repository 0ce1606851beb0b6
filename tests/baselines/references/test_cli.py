"""The command ``gym-extensions reference``."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import pytest

from gym_extensions.baselines.references import cli
from gym_extensions.catalog.groups import group
from gym_extensions.catalog.registry import task
from gym_extensions.errors import BenchError


def files(folder: Path) -> dict[str, bytes]:
    return {str(path): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def test_the_command_writes_the_references_and_their_logs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cli, "FLOOR_EPISODES", 4)
    monkeypatch.setattr(cli, "CEILING_EPISODES", 3)
    out = tmp_path / "provisional.json"
    argv = ["--groups", "hopper-motor-noise", "--budget", "smoke", "--runs", "1000", "--out", str(out)]
    assert cli.main(argv) == 0
    content = json.loads(out.read_text())
    assert (content["format"], content["version"], content["provisional"]) == (1, "provisional", True)
    assert len(content["tasks"]) == 2
    row = content["tasks"]["gym_extensions/Hopper-v0"]
    assert row["floor"]["episodes"] == 4
    trained = row["ceiling"] or row["attempts"]
    assert (trained["agent"], trained["budget"], trained["episodes"]) == ("trpo", "smoke", 3)
    log = tmp_path / "provisional-logs/Hopper-v0.csv"
    assert trained["log_sha256"] == sha256(log)
    assert len(log.read_text().splitlines()) == 1 + 3
    log = tmp_path / "provisional-logs/floors/Hopper-v0.csv"
    assert row["floor"]["log_sha256"] == sha256(log)
    header, *lines = log.read_text().splitlines()
    assert header == "agent,episode,seed,length,return,terminated"
    assert [line.split(",")[:2] for line in lines] == [
        [agent, str(episode)] for agent in ("random", "zero") for episode in range(4)
    ]
    before = files(tmp_path)
    assert cli.main(argv) == 0
    assert files(tmp_path) == before


@pytest.mark.parametrize("agent", ["trpo", "trpo-2017"])
def test_the_ceilings_are_measured_with_the_named_agent(agent: str) -> None:
    runs = cli.ceiling_measurements(task("Hopper"), "1M", [1000, 1001], agent)
    assert [(each.agent, each.run) for each in runs] == [(agent, 1000), (agent, 1001)]
    oracle = cli.ceiling_measurements(group("nav-state").tasks[0], "1M", [1000, 1001], agent)
    assert [each.agent for each in oracle] == ["oracle"]


def test_each_group_may_have_its_own_budget() -> None:
    hopper, pusher = group("hopper-gravity").tasks, group("pusher").tasks
    assert cli.task_budgets("hopper-gravity, pusher", "1M") == dict.fromkeys([*hopper, *pusher], "1M")
    budgets = cli.task_budgets("hopper-gravity,pusher", "1M,100k")
    assert budgets == dict.fromkeys(hopper, "1M") | dict.fromkeys(pusher, "100k")
    assert list(budgets) == [*hopper, *pusher]


@pytest.mark.parametrize(
    ("groups", "budgets", "message"),
    [
        (
            "hopper-gravity,pusher",
            "1M,1M,100k",
            "--budget: There are 2 groups and 3 budgets. Use one budget, or one per group.",
        ),
        (
            "hopper-gravity,hopper-motor-noise",
            "1M,100k",
            "--budget: gym_extensions/Hopper-v0 is in two groups with the budgets 1M and 100k. "
            "Use the same budget for these groups.",
        ),
        ("hopper-gravity", "2M", "There is no budget '2M'. Choose one of: 100k, 1M, 300k, paper, smoke."),
    ],
)
def test_budgets_that_do_not_match_the_groups_are_rejected(groups: str, budgets: str, message: str) -> None:
    with pytest.raises(BenchError) as error:
        cli.task_budgets(groups, budgets)
    assert str(error.value) == message
