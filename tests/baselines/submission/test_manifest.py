"""The manifest: what follows from a run, what the author edits, and runs that do not belong to it."""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.baselines import Card, Observes, train
from gym_extensions.baselines.submission import manifest
from gym_extensions.envs import fingerprint
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.rules.manifest import bad_package, bad_value, missing_key, unknown_key

PATH = Path("mine/submission.toml")
CARD = Card("climber", hyperparameters={"step": 0.1}, stored_steps=10)
OBSERVES = Observes(task_in_training=True)


def run(card: Card = CARD, num_envs: int | None = None, observes: Observes = OBSERVES) -> dict[str, Any]:
    return manifest.run_sections(card, "smoke", num_envs, observes)


def test_a_new_manifest_passes_the_rules_of_the_format() -> None:
    tables = manifest.merge({}, CARD, run(), 3, 5)
    assert [*unknown_key(tables), *missing_key(tables), *bad_value(tables)] == []
    assert (tables["title"], tables["hyperparameters"]) == ("climber", {"step": 0.1})
    assert tables["memory"] == {"stored_steps": 10, "parameters_first": 3, "parameters_last": 5}


def test_the_versions_of_the_packages_that_an_agent_names_are_stored() -> None:
    card = Card("climber", packages=("pandas",))
    tables = manifest.merge({}, card, run(card), 3, 5)
    assert tables["packages"] == {"pandas": version("pandas")}
    assert [*unknown_key(tables), *missing_key(tables), *bad_value(tables), *bad_package(tables)] == []
    assert "packages" not in run()


def test_what_the_agent_observes_follows_from_what_it_asks_for() -> None:
    declared = {"task_in_training": True, "task_in_evaluation": False, "boundaries": False}
    assert manifest.merge({}, CARD, run(), 3, 5)["observes"] == declared


@pytest.mark.parametrize("declared", [True, False])
def test_a_manifest_that_declares_otherwise_is_rejected(declared: bool) -> None:
    existing = run(observes=Observes(task_in_training=True, boundaries=declared))
    with pytest.raises(BenchError) as error:
        manifest.require_same(PATH, existing, run(observes=Observes(True, False, not declared)))
    assert error.value.code == "mixed-submission"
    assert str(error.value) == (
        f"{PATH}: observes.boundaries is {declared} in this submission and {not declared} in the new run. "
        "This section follows from the agent's attribute observes. Change that, or choose another --out."
    )


def test_a_manifest_is_unchanged_by_writing_and_reading(tmp_path: Path) -> None:
    tables = manifest.merge({}, CARD, run(num_envs=4), 3, 5)
    manifest.write(tmp_path / "submission.toml", tables)
    assert manifest.read(tmp_path / "submission.toml") == tables
    assert tables["hyperparameters"] == {"step": 0.1, "num_envs": 4}


def test_the_largest_memory_of_all_runs_stays() -> None:
    first = manifest.merge({}, CARD, run(), 3, 50)
    second = manifest.merge(first, Card("climber", stored_steps=7), run(), 4, 5)
    assert second["memory"] == {"stored_steps": 10, "parameters_first": 4, "parameters_last": 50}


def test_a_run_with_another_version_of_the_physics_is_rejected() -> None:
    existing = run() | {"versions": {"mujoco": "3.0.0"}}
    installed = manifest.versions()["mujoco"]
    with pytest.raises(BenchError) as error:
        manifest.require_same(PATH, existing, run())
    assert str(error.value) == (
        f"{PATH}: This submission was made with mujoco 3.0.0; {installed} is installed. "
        "Install mujoco 3.0.0, or choose another --out."
    )


def test_a_run_on_another_platform_is_accepted() -> None:
    existing = run()
    existing["versions"] |= {"numpy": "1.0", "platform": "Darwin-arm64"}
    manifest.require_same(PATH, existing, run())
    with pytest.raises(BenchError, match=r"hyperparameters\.num_envs is not stated"):
        manifest.require_same(PATH, existing, run(num_envs=2))


def test_the_blas_kernels_of_all_runs_are_stated() -> None:
    first = manifest.merge({}, CARD, run(), 3, 5, kernels=["openblas Haswell", "openblas Haswell"])
    assert first["versions"]["blas"] == "openblas Haswell"
    second = manifest.merge(first, CARD, run(), 3, 5, kernels=["openblas Zen", "openblas Haswell"])
    assert second["versions"]["blas"] == "openblas Haswell, openblas Zen"


def test_runs_of_a_manifest_that_states_no_blas_kernels_have_unknown_ones() -> None:
    existing = manifest.merge({}, CARD, run(), 3, 5)
    del existing["versions"]["blas"]
    tables = manifest.merge(existing, CARD, run(), 3, 5, kernels=["openblas Zen"])
    assert tables["versions"]["blas"] == "unknown, openblas Zen"


def test_another_engine_records_nothing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(fingerprint, "engine", lambda: {"mujoco": "4.0.0", "gymnasium": "1.3.0"})
    with pytest.raises(BenchError, match=r"gymnasium 1\.3\.0 is installed") as caught:
        train("random", "pusher", "single", "smoke", 0, out=tmp_path / "mine")
    assert caught.value.code == "other-engine"
    assert list(tmp_path.iterdir()) == []


def test_the_versions_of_all_runs_are_stated() -> None:
    card = Card("climber", packages=("pandas",))
    first = manifest.merge({}, card, run(card), 3, 5)
    first["versions"] |= {"numpy": "1.0", "platform": "Plan9-mips"}
    first["packages"] = {"pandas": "1.0"}
    tables = manifest.merge(first, card, run(card), 3, 5)
    now = manifest.versions()
    assert tables["versions"]["numpy"] == f"1.0, {now['numpy']}"
    assert tables["versions"]["platform"] == f"Plan9-mips, {now['platform']}"
    assert tables["versions"]["mujoco"] == now["mujoco"]
    assert tables["packages"] == {"pandas": f"1.0, {version('pandas')}"}


def test_kernels_for_which_the_manifest_has_no_room_are_others() -> None:
    kernels = [f"openblas Kernel{number:02}" for number in range(9)]
    blas = manifest.merge({}, CARD, run(), 3, 5, kernels=kernels)["versions"]["blas"]
    assert blas == ", ".join(["others", *kernels[-4:]])
    assert len(blas) <= 100


def test_a_run_whose_kernels_were_not_recorded_has_unknown_ones() -> None:
    tables = manifest.merge({}, CARD, run(), 3, 5, kernels=["unknown", "openblas Zen"])
    assert tables["versions"]["blas"] == "unknown, openblas Zen"
