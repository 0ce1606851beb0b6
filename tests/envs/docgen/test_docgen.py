"""The pages of docs/environments and ``envs show``: made from the catalog, and right."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from gym_extensions.catalog.registry import TASKS, task
from gym_extensions.envs import cli, make
from gym_extensions.envs.docgen.descriptions import SENTENCES, differences
from gym_extensions.envs.docgen.pages import pages
from gym_extensions.envs.docgen.prose import HISTORY, PROSE
from gym_extensions.envs.docgen.summary import summary
from gym_extensions.envs.docgen.tables import action_fields, indexed, observation_fields

DOCS = Path(__file__).parents[3] / "docs" / "environments"
PAGES = pages()
ONE_A_BASE = list({row.base: row.id for row in TASKS.values()}.values())


@pytest.mark.parametrize("name", sorted(PAGES))
def test_a_committed_page_is_the_one_that_the_catalog_makes(name: str) -> None:
    assert (DOCS / name).read_text() == PAGES[name], "run `gym-extensions envs docs`"


def test_every_picture_that_a_page_shows_is_committed_and_no_other() -> None:
    shown = {name for text in PAGES.values() for name in re.findall(r"\(pictures/([^)]+)\)", text)}
    committed = {path.name for path in (DOCS / "pictures").iterdir()}
    assert shown == committed
    assert {"hopperbigfoot.png", "humanoidsmallhand.png", "halfcheetahwall.png", "map9.png"} <= shown


@pytest.mark.parametrize("task_id", ONE_A_BASE)
def test_the_tables_describe_as_many_numbers_as_there_are(task_id: str) -> None:
    env = make(task_id)
    observed = sum(field.count for field in observation_fields(task(task_id)))
    assert observed == (0 if env.observation_space.shape == (120, 160, 3) else env.observation_space.shape[0])
    actions = action_fields(task(task_id))
    np.testing.assert_allclose([field.low for field in actions], env.action_space.low)
    np.testing.assert_allclose([field.high for field in actions], env.action_space.high)


def test_an_entry_of_the_table_is_what_the_index_says() -> None:
    rows = dict(indexed(observation_fields(task("HumanoidWall"))))
    env = make("HumanoidWall").unwrapped
    seen, _ = env.reset(seed=0)
    assert rows["0"].meaning == "height of the torso"
    assert seen[0] == env.data.qpos[2]
    assert rows["5"].meaning == "angle of abdomen_z"
    assert seen[5] == env.data.joint("abdomen_z").qpos[0]
    assert rows["45–54"].meaning.startswith("inertia and mass of torso")
    np.testing.assert_array_equal(seen[45:55], env.data.cinert[1])
    assert rows["253"].meaning == "torque of the motor of abdomen_z"
    assert rows["348"].meaning.startswith("range beam at -45°")
    assert list(rows)[-1] == "357"


def test_every_variation_has_a_sentence_and_every_base_its_prose() -> None:
    for row in TASKS.values():
        assert len(differences(row)) == len(row.variations)
        assert row.base in PROSE
        assert row.version in HISTORY
    assert {type(variation) for row in TASKS.values() for variation in row.variations} == set(SENTENCES)


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("HopperGravityHalf", "Gravity -4.905 m/s², 0.5 times -9.81."),
        (
            "HalfCheetahBigTorso",
            "Torso: radius and mass times 1.25 (radius: torso 0.046 → 0.0575 m; mass 4.663 → 5.828 kg).",
        ),
        (
            "HumanoidWall",
            "A wall of 0.4 × 10 × 0.5 m (deep, wide, tall), without friction, its top at 0.375 m, "
            "its centre at x ~ U(1.8, 3.8) m, y 0, drawn at reset.",
        ),
    ],
)
def test_a_difference_is_told_in_numbers(name: str, sentence: str) -> None:
    assert sentence in differences(task(name))


def test_show_prints_every_fact(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["show", "StrikerMovingStart"]) == 0
    told = capsys.readouterr().out
    assert told == summary(task("StrikerMovingStart")) + "\n"
    for fact in ("100 steps", "striker-v0", "x ~ U(0.43, 0.55)", "motor of r_wrist_roll_joint", "-3 … 3"):
        assert fact in told
    assert "smallest distance of ball and goal" in told
    assert "22     z of the goal" in told


def test_docs_writes_the_pages(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["docs", "--out", str(tmp_path)]) == 0
    assert {path.name for path in tmp_path.iterdir()} == set(PAGES)
    assert capsys.readouterr().out == f"{len(PAGES)} pages and 0 pictures written to {tmp_path}.\n"
