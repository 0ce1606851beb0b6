"""The pages of docs/environments, and the descriptions of tasks."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gymnasium.spaces import Box

from gym_extensions.catalog import descriptions, fingerprints
from gym_extensions.catalog.tasks import TASKS, task
from gym_extensions.envs import fingerprinting, make
from gym_extensions.envs.mujoco.env import TaskEnv
from tools.environments import fingerprints as publishing, pictures
from tools.environments.__main__ import main
from tools.environments.describe import action_fields, observation_fields, table

from ..conftest import refused

DOCS = Path(__file__).parents[2] / "docs" / "environments"
HALF = "gym_extensions/HopperGravityHalf-v0"
ONE_PER_BASE = list({each.base: each.id for each in TASKS.values()}.values())


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder with what ``tools.environments`` writes."""
    out = tmp_path_factory.mktemp("docs")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(descriptions, "PATH", out / "descriptions.json")
        assert main(["--out", str(out / "pages")]) == 0
    return out


@pytest.fixture(scope="module")
def text_by_name(written: Path) -> dict[str, str]:
    """The pages by file name."""
    return {path.name: path.read_text("utf-8") for path in (written / "pages").iterdir()}


def test_the_committed_pages_and_sheets_are_up_to_date(written: Path, text_by_name: dict[str, str]) -> None:
    committed = {path.name: path.read_text("utf-8") for path in DOCS.glob("*.md")}
    assert text_by_name == committed, "run `python -m tools.environments`"
    assert (written / "descriptions.json").read_bytes() == descriptions.PATH.read_bytes()


@pytest.mark.parametrize("task_id", ONE_PER_BASE)
def test_the_tables_have_as_many_entries_as_the_spaces(task_id: str) -> None:
    env = make(task_id)
    count = sum(field.count for field in observation_fields(task(task_id)))
    observations, action_space = env.observation_space, env.action_space
    assert isinstance(observations, Box) and isinstance(action_space, Box)
    assert count == (0 if observations.shape == (120, 160, 3) else observations.shape[0])
    actions = action_fields(task(task_id))
    np.testing.assert_allclose(np.array([field.low for field in actions]), action_space.low)
    np.testing.assert_allclose(np.array([field.high for field in actions]), action_space.high)


def test_the_entry_at_an_index_has_the_value_that_the_table_describes() -> None:
    rows = {index: meaning for index, meaning, *_ in table(observation_fields(task("HumanoidWall")))}
    env = TaskEnv(task("HumanoidWall"))
    seen, _ = env.reset(seed=0)
    ranges = [row[3] for row in table(observation_fields(task("Hopper")))]
    assert ranges[1:3] + ranges[-1:] == ["unbounded", "-2.61799 … 0, soft limit", "-10 … 10"]
    assert (rows["0"], seen[0]) == ("height of the torso", env.data.qpos[2])
    assert (rows["5"], seen[5]) == ("angle of abdomen_z", env.data.joint("abdomen_z").qpos[0])
    assert rows["45–54"].startswith("inertia and mass of torso")
    np.testing.assert_array_equal(seen[45:55], env.data.cinert[1])
    assert rows["253"] == "torque of the motor of abdomen_z"
    assert (rows["348"][:18], list(rows)[-1]) == ("range beam at -45°", "357")


def test_the_example_of_the_python_api_runs(text_by_name: dict[str, str]) -> None:
    code = re.findall(r"```python\n(.*?)```", text_by_name["README.md"], flags=re.DOTALL)
    names: dict[str, Any] = {}
    exec(compile(code[0], "docs/environments/README.md", "exec"), names)
    assert names["envs"].num_envs == 8
    assert [row.name for row in names["envs"].tasks[:2]] == ["Hopper.Gravity-0.8", "Hopper"]
    assert names["env"].spec.max_episode_steps == 500
    compile(code[1], "docs/environments/README.md", "exec")  # test_wrappers records one, where moviepy is


def test_a_picture_shows_the_beams_of_the_sensor_up_to_the_wall(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[pictures.Line] = []

    def render(_model: Any, _data: Any, _view: Any, lines: list[pictures.Line]) -> Any:
        drawn.extend(lines)
        return np.zeros((480, 640, 3), np.uint8)

    monkeypatch.setattr(pictures, "_render", render)
    monkeypatch.setattr(pictures, "TASKS", {"HopperWall": task("HopperWall")})
    assert list(pictures.task_pictures()) == ["hopperwall.webp"]
    assert len(drawn) == 10
    _, end, _ = drawn[2]  # 25° down from 1.25 m, to a wall whose face is 2.6 m ahead
    assert end == pytest.approx([2.6, 0.0, 1.25 - 2.6 * np.tan(np.radians(25))])


def test_a_published_task_that_is_gone_is_not_deleted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(publishing, "TASKS", {HALF: task(HALF)})
    with refused("lost-task"):
        publishing.updated()


def test_publishing_again_changes_nothing() -> None:
    table, changed = publishing.updated()
    assert changed == []
    assert publishing.text(table) == fingerprints.PATH.read_text()
    assert json.loads(publishing.text(table)) == table


def test_fingerprints_of_another_engine_are_not_mixed_with_the_published_ones(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(fingerprinting, "engine", lambda: {"mujoco": "9.9.9"})
    monkeypatch.setattr(publishing, "TASKS", {HALF: task(HALF)})
    with refused("other-engine", "Install that engine, or replace all fingerprints"):
        publishing.updated()
    assert publishing.updated(replace=True)[0]["engine"] == {"mujoco": "9.9.9"}
