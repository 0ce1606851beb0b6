"""The published references: made from floors, cards and the planner, and measured again."""

import json
import shutil
from pathlib import Path

import msgspec
import pytest

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.tasks import task
from gym_extensions.references import Floor, FloorAgent, Reference, experts, parse_references, path_of
from tools import references
from tools.experts.candidates import QUICK
from tools.references import differences, published, with_expert

from ..baselines.conftest import make_quick
from ..conftest import refused

PUSHER = task("Pusher")
HOPPER = task("Hopper")
NAVIGATION = task("State-Based-Navigation-2d-Map0-Goal0")
FLOOR = Floor(4.0, "zero", agents={"zero": FloorAgent(4.0, std=1.0)})


def test_the_published_floors_and_experts_of_three_tasks_follow_from_seeds_and_files() -> None:
    assert differences([PUSHER], path_of(), 0, QUICK) == []
    assert differences([task("HopperGravityHalf"), NAVIGATION], path_of(), 0, 10) == [], "long episodes"


def test_a_floor_and_an_expert_of_other_episodes_are_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    document = json.loads(path_of().read_bytes())
    for agent in document["tasks"][PUSHER.id]["floor"]["agents"].values():
        agent["mean"] = -1.0
    document["tasks"][PUSHER.id]["expert"]["mean"] = -3.0
    path = tmp_path / "2.json"
    path.write_text(json.dumps(document))
    monkeypatch.setattr(references, "measured_again", lambda *_: (-32.0, -31.0, True))
    monkeypatch.setattr(references, "parse_groups", lambda _: [TaskGroup("mine", (PUSHER,))])
    make_quick(monkeypatch, 4)
    assert references.main(["--groups", "pusher", "--check", str(path), "--quick"]) == 1
    said = capsys.readouterr().out.splitlines()[-4:]
    told = ("random returns", "zero returns", "not the one of its card", "the expert returns -32, not -31")
    assert [fact in sentence for fact, sentence in zip(told, said, strict=True)] == [True] * 4


def test_a_file_that_does_not_exist_cannot_be_checked(capsys: pytest.CaptureFixture[str]) -> None:
    assert references.main(["--check", "none.json"]) == 2
    assert "none.json: The file does not exist." in capsys.readouterr().err


def test_the_published_file_is_made_from_floors_cards_and_the_planner(tmp_path: Path) -> None:
    made = published(tmp_path / "2.json", 0, tasks=[PUSHER, NAVIGATION])
    current = parse_references(path_of().read_bytes())
    assert made.tasks == {task.id: current.tasks[task.id] for task in (PUSHER, NAVIGATION)}


def test_a_task_is_open_without_an_expert_or_with_one_that_is_not_clear(tmp_path: Path) -> None:
    assert with_expert(HOPPER, FLOOR, tmp_path) == Reference(FLOOR, None)
    high = Floor(3700.0, "zero", agents={"zero": FloorAgent(3700.0, std=100.0)})
    row = with_expert(HOPPER, high)
    assert row.expert is None
    assert row.attempts and row.attempts.agent == "expert"


@pytest.mark.parametrize(
    ("change", "code"),
    [({"fingerprint": "0" * 16}, "foreign-fingerprint"), ({"policy": "0" * 64}, "other-policy")],
)
def test_an_expert_of_another_task_is_refused_and_nothing_is_written(
    change: dict[str, str], code: str, tmp_path: Path
) -> None:
    shutil.copy(experts.DATA / "Pusher.npz", tmp_path / "Pusher.npz")
    card = msgspec.structs.replace(experts.card("Pusher"), **change)
    (tmp_path / "Pusher.json").write_bytes(msgspec.json.encode(card))
    out = tmp_path / "out/2.json"
    with refused(code, "Pusher"):
        published(out, 0, tmp_path, [PUSHER])
    assert not out.exists()
