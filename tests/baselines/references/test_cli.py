"""``gym-extensions maintain references``: the published file, files of custom groups, and the check."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from gym_extensions.baselines.references import cli, measuring
from gym_extensions.baselines.training.runner import PendingJob
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.tasks import task
from gym_extensions.references import parse_file, path_of

PUSHER = task("Pusher")


@pytest.mark.usefixtures("quick")
def test_a_floor_and_an_expert_of_other_episodes_are_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    document = json.loads(path_of().read_bytes())
    for agent in document["tasks"][PUSHER.id]["floor"]["agents"].values():
        agent["mean"] = -1.0
    document["tasks"][PUSHER.id]["expert"]["mean"] = -3.0
    path = tmp_path / "2.json"
    path.write_text(json.dumps(document))
    monkeypatch.setattr(measuring, "measured_again", lambda *_: (-32.0, -31.0, True))
    monkeypatch.setattr(cli, "parse_groups", lambda _: [TaskGroup("mine", (PUSHER,))])
    assert cli.main(["--groups", "pusher", "--check", str(path), "--quick"]) == 1
    sentences = capsys.readouterr().out.splitlines()[-4:]
    for told, sentence in zip(
        ("random returns", "zero returns", "not the one of its card", "the expert returns -32, not -31"),
        sentences,
        strict=True,
    ):
        assert told in sentence


@pytest.mark.usefixtures("quick")
def test_an_interrupted_measurement_of_custom_groups_trains_nothing_twice(
    quick_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "mine.json"
    command = ["--groups", str(quick_file), "--budget", "smoke", "--runs", "1000", "--out", str(out)]
    with monkeypatch.context() as patch, pytest.raises(TypeError):
        patch.setattr(measuring, "with_runs", None)
        cli.main(command)
    assert len(list((tmp_path / ".progress/mine").rglob("stage1.json"))) == 2
    monkeypatch.setattr(PendingJob, "_train", None)
    assert cli.main(command) == 0
    assert not (tmp_path / ".progress").exists()
    rows = parse_file(out.read_bytes()).tasks.values()
    found = [(best.agent, best.budget) for row in rows if (best := row.expert or row.attempts)]
    assert found == [("trpo", "smoke")] * 2


def test_a_custom_group_needs_a_file_of_its_own(capsys: pytest.CaptureFixture[str]) -> None:
    before = path_of().read_bytes()
    assert cli.main(["--groups", "pusher"]) == 2
    assert "Custom groups have a file of their own." in capsys.readouterr().err
    assert path_of().read_bytes() == before


def test_a_file_that_does_not_exist_cannot_be_checked(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["--check", "none.json"]) == 2
    assert "none.json: The file does not exist." in capsys.readouterr().err


@pytest.mark.usefixtures("quick")
def test_tasks_of_an_existing_file_stay(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "mine.json"
    options = ["--budget", "smoke", "--runs", "1000", "--agent", "random", "--out", str(out)]
    assert cli.main(["--groups", "pusher", *options]) == 0
    before = json.loads(out.read_text())["tasks"]
    capsys.readouterr()
    assert cli.main(["--groups", "pusher,pusher-tracking", *options]) == 0
    after = json.loads(out.read_text())["tasks"]
    assert {name: after[name] for name in before} == before
    assert len(after) > len(before)


@pytest.mark.parametrize("text", ["{", "[]", '{"format": 3, "version": "1", "tasks": {}}'])
def test_a_file_that_does_not_hold_references_is_not_replaced(text: str, tmp_path: Path) -> None:
    out = tmp_path / "1.json"
    out.write_text(text)
    assert cli.main(["--groups", "pusher", "--out", str(out)]) == 2
    assert out.read_text() == text
