"""Every task is as published, and the check says what moved when one is not."""

from __future__ import annotations

import copy
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from gym_extensions.catalog import fingerprints
from gym_extensions.catalog.registry import TASKS, task
from gym_extensions.catalog.variations.gravity import Gravity
from gym_extensions.envs import canary, fingerprint
from gym_extensions.envs.mujoco import compile as models
from gym_extensions.errors import BenchError

HALF = "gym_extensions/HopperGravityHalf-v0"


def test_every_task_is_as_published() -> None:
    assert [str(difference) for difference in fingerprint.check()] == []


def test_the_table_holds_a_row_for_each_task_in_the_catalogs_order_with_its_own_digest() -> None:
    rows = fingerprints.table()["tasks"]
    assert list(rows) == list(TASKS)
    assert all(row["fingerprint"] == fingerprints.digest(row) for row in rows.values())
    assert len({row["fingerprint"] for row in rows.values()}) == len(rows)


def test_the_gravity_groups_keep_the_fingerprints_that_results_were_recorded_against() -> None:
    assert fingerprints.published(HALF) == "af8ea315c226519b"
    assert fingerprints.published("gym_extensions/HumanoidGravityOneAndHalf-v0") == "5fac30efc503633c"


def test_a_changed_variation_is_told_with_task_and_number() -> None:
    moved = replace(task(HALF), variations=(Gravity(0.501),))
    told = [str(difference) for difference in fingerprint.check([moved])]
    assert told[0].startswith(f"{HALF}: canary.episodes[0].observation[0] is ")
    assert f"{HALF}: definition.variations[0].factor is 0.501, published as 0.5" in told


def test_a_changed_time_limit_is_told() -> None:
    told = fingerprint.check([replace(task(HALF), max_steps=999)])
    assert [str(one) for one in told] == [f"{HALF}: definition.max_steps is 999, published as 1000"]


def test_a_changed_base_model_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    text = models.asset("Hopper").read_text().replace('gear="200.0"', 'gear="201.0"')
    (tmp_path / "hopper.xml").write_text(text)
    monkeypatch.setattr(models, "ASSETS", tmp_path)
    wheres = [difference.where for difference in fingerprint.check([task(HALF)])]
    assert "model_sha256" in wheres
    assert "canary.episodes[0].rewards[0]" in wheres


def test_another_engine_is_told() -> None:
    table = copy.deepcopy(fingerprints.table())
    table["engine"]["mujoco"] = "3.17.0"
    told = [str(difference) for difference in fingerprint.check([task(HALF)], table)]
    assert told == ["engine: mujoco is '4.0.0', published as '3.17.0'"]


def test_an_edited_row_is_told() -> None:
    table = copy.deepcopy(fingerprints.table())
    table["tasks"][HALF]["canary"]["episodes"][1]["rewards"][3] += 1e-8
    wheres = [difference.where for difference in fingerprint.check([task(HALF)], table)]
    assert wheres == ["fingerprint", "canary.episodes[1].rewards[3]"]


def test_a_difference_below_the_tolerance_is_none() -> None:
    assert list(fingerprint.compare("", {"a": [1.0, 2e6]}, {"a": [1.0 + 9e-10, 2e6 + 1e-3]})) == []
    assert list(fingerprint.compare("", {"a": [1.0]}, {"a": [1.0 + 2e-9]})) == [("a[0]", 1.0, 1.0 + 2e-9)]


def test_a_task_without_a_row_and_a_row_without_a_task_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fingerprint, "TASKS", {HALF: task(HALF)})
    table = copy.deepcopy(fingerprints.table())
    row = table["tasks"].pop(HALF)
    assert fingerprint.check([task(HALF)], table)[0].found == "not yet published"
    table["tasks"]["gym_extensions/Gone-v0"] = row
    assert "gym_extensions/Gone-v0" in [difference.task for difference in fingerprint.check(None, table)]


def test_publishing_again_changes_no_byte() -> None:
    table, changed = fingerprint.updated()
    assert changed == []
    assert fingerprint.text(table) == fingerprints.PATH.read_text()
    assert json.loads(fingerprint.text(table)) == table


def test_canary_actions_fill_the_space_and_differ_from_step_to_step() -> None:
    from gym_extensions.envs import make

    space = make("Hopper").action_space
    drawn = list(canary.actions(space))
    assert len(drawn) == canary.STEPS <= 10
    assert all(space.contains(action) for action in drawn)
    assert len({action.tobytes() for action in drawn}) == len(drawn)
    assert drawn[0].tolist() == pytest.approx(
        [2 * 0.6180339887 - 1, 2 * 0.2360679775 - 1, 2 * 0.8541019662 - 1]
    )


def test_reading_a_fingerprint_loads_no_simulator() -> None:
    code = (
        "import sys; from gym_extensions.catalog.fingerprints import published; "
        f"print(published({HALF!r})); "
        "sys.exit(any(name in sys.modules for name in ('mujoco', 'gymnasium', 'numpy')))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "af8ea315c226519b\n")


def test_an_unknown_id_has_no_fingerprint() -> None:
    with pytest.raises(BenchError) as caught:
        fingerprints.published("gym_extensions/HoperGravityHalf-v0")
    assert str(caught.value) == (
        "No fingerprint is published for 'gym_extensions/HoperGravityHalf-v0'. Did you mean "
        "'gym_extensions/HopperGravityHalf-v0'? A new task's is published by: gym-extensions envs fingerprint"
    )
