"""The fingerprint check: every task matches its published fingerprint, and differences are reported."""

import platform
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.catalog import fingerprints
from gym_extensions.catalog.bodies import BODIES
from gym_extensions.catalog.tasks import TASKS, task
from gym_extensions.catalog.variations import Gravity
from gym_extensions.envs import fingerprinting
from gym_extensions.envs.mujoco import model as models

from ..conftest import refused

HALF = "gym_extensions/HopperGravityHalf-v0"


def test_every_task_matches_its_published_fingerprint() -> None:
    assert [str(difference) for difference in fingerprinting.check()] == []


def test_no_two_mujoco_tasks_have_the_same_episodes() -> None:
    rows = [fingerprints.table()["tasks"][each.id] for each in TASKS.values() if each.base != "Navigation"]
    episodes = [str(row["canary"]["episodes"]) for row in rows]
    assert len(set(episodes)) == len(episodes)


def test_a_changed_variation_is_reported_with_task_and_value() -> None:
    moved = replace(task(HALF), variations=(Gravity(0.501),))
    lines = [str(difference) for difference in fingerprinting.check([moved])]
    assert lines[0].startswith(f"{HALF}: canary.episodes[0].observation[0] is ")
    assert f"{HALF}: definition.variations[0].factor is 0.501, published as 0.5" in lines


def test_a_changed_base_model_is_reported(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    text = models.asset(BODIES["Hopper"]).read_text().replace('gear="200.0"', 'gear="201.0"')
    (tmp_path / "hopper.xml").write_text(text)
    monkeypatch.setattr(models, "ASSETS", tmp_path)
    wheres = [difference.where for difference in fingerprinting.check([task(HALF)])]
    assert "model_sha256" in wheres
    assert "canary.episodes[0].rewards[0]" in wheres


def test_an_edited_row_is_reported(table: Any) -> None:
    table["tasks"][HALF]["canary"]["episodes"][1]["rewards"][3] += 1e-8
    wheres = [difference.where for difference in fingerprinting.check([task(HALF)])]
    assert wheres == ["canary.episodes[1].rewards[3]", "fingerprint"]


def test_a_difference_below_the_tolerance_is_ignored() -> None:
    assert list(fingerprinting.compare("", {"a": [1.0, 2e6]}, {"a": [1.0 + 9e-10, 2e6 + 1e-3]})) == []
    assert list(fingerprinting.compare("", {"a": [1.0]}, {"a": [1.0 + 2e-9]})) == [("a[0]", 1.0, 1.0 + 2e-9)]


def test_a_row_of_another_processor_within_the_tolerance_has_its_own_digest(table: Any) -> None:
    row = table["tasks"][HALF]
    row["canary"]["episodes"][0]["rewards"][0] += 1e-10
    row["fingerprint"] = fingerprints.digest(row)
    assert fingerprinting.check([task(HALF)]) == []


def test_a_task_without_a_row_and_a_row_without_a_task_are_reported(
    table: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fingerprinting, "TASKS", {HALF: task(HALF)})
    table["tasks"] = {"gym_extensions/Gone-v0": table["tasks"][HALF]}
    assert [(each.task, each.current) for each in fingerprinting.check()] == [
        (HALF, "not yet published"),
        ("gym_extensions/Gone-v0", "not in the catalog"),
    ]


def other(monkeypatch: pytest.MonkeyPatch, **versions: str) -> None:
    """Pretends that other versions are installed."""
    installed = fingerprinting.engine() | versions
    monkeypatch.setattr(fingerprinting, "engine", lambda: installed)


def test_another_engine_cannot_repeat_episodes_and_gives_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    other(monkeypatch, gymnasium="1.0.0")
    with refused("other-engine", "gymnasium 1.0.0", "gymnasium==1.4.0"):
        fingerprinting.require_published_engine()
    with pytest.warns(UserWarning, match=r"gymnasium 1\.0\.0"):
        fingerprinting.warn_of_another_engine()


def test_another_engine_with_equal_fingerprints_trains_and_warns(
    table: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    other(monkeypatch, gymnasium="1.0.0")
    with pytest.warns(UserWarning, match="fingerprints agree"):
        fingerprinting.require_published_engine([task(HALF)])
    table["tasks"][HALF]["canary"]["episodes"][0]["rewards"][0] += 1e-6
    with refused("other-engine"):
        fingerprinting.require_published_engine([task("Hopper")])
    other(monkeypatch, mujoco="3.17.0")
    with refused("other-engine"):
        fingerprinting.require_published_engine([task("Pusher")])


@pytest.mark.parametrize(
    ("text", "why"), [("x\nflags\t: sse fma\n", ""), ("x\nflags\t: sse\n", "no FMA"), (None, "no FMA")]
)
def test_a_processor_that_states_no_fma_may_compute_other_last_bits(
    text: str | None, why: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(fingerprinting, "CPU_INFO", tmp_path / "cpuinfo")
    monkeypatch.setattr(platform, "system", lambda: "Linux")
    monkeypatch.setattr(platform, "machine", lambda: "x86_64")
    if text is not None:
        (tmp_path / "cpuinfo").write_text(text)
    assert why in fingerprinting.other_platform()
    assert bool(why) == bool(fingerprinting.other_platform())
