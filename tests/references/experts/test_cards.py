"""The experts' files: loading, refusals, seeds, and when an expert is an anchor."""

import hashlib
import json
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from gym_extensions.catalog import fingerprints
from gym_extensions.catalog.tasks import TASKS, task
from gym_extensions.errors import BenchError
from gym_extensions.references import experts
from gym_extensions.references.experts import PURPOSES, ExpertCard, Measurement, Step
from gym_extensions.submissions.policies.mlp import Policy
from tools.experts.candidates import write_policy
from tools.experts.published import write_expert

from ...conftest import refused

POLICY = Policy(
    action_offset=np.zeros(3),
    action_scale=np.ones(3),
    weights=(np.ones((11, 3), np.float32),),
    biases=(np.zeros(3, np.float32),),
)
MEASURED = Measurement(episodes=100, mean=3600.0, deviation=10.0)
CARD = ExpertCard(
    task=task("Hopper").id,
    fingerprint=fingerprints.published(task("Hopper").id),
    policy=experts.digest(POLICY),
    history=(Step("trpo-Hopper-seed0@2000000", "trpo", 2_000_000, 157.0, "train trpo-Hopper"),),
    from_submission=False,
    candidates=20,
    steps_tried=2_000_000,
    selection=MEASURED,
    measurement=MEASURED,
    first_hundred=MEASURED.mean,
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with one expert."""
    write_expert(POLICY, CARD, tmp_path / "Hopper.json")
    return tmp_path


def test_every_published_expert_loads_acts_and_belongs_to_its_task() -> None:
    names = experts.names()
    assert names
    for name in names:
        policy, card = experts.load(name), experts.card(name)
        assert card.fingerprint == fingerprints.published(card.task)
        assert np.isfinite(policy.act(np.zeros((1, policy.num_inputs or 0)))).all()
        assert card.history
        assert card.selection.episodes >= 100 <= card.measurement.episodes


def test_what_is_written_is_read(folder: Path) -> None:
    assert experts.names(folder) == ["Hopper"]
    assert experts.digest(experts.load("Hopper", folder)) == experts.digest(POLICY)
    assert experts.card("Hopper", folder) == CARD


def test_a_policy_that_is_not_the_cards_is_refused(folder: Path) -> None:
    other = replace(POLICY, action_offset=np.ones(3))
    with pytest.raises(BenchError, match="describes another policy"):
        write_expert(other, CARD, folder / "Hopper.json")
    write_policy(folder / "Hopper.npz", other)
    with refused("other-policy"):
        experts.load("Hopper", folder)


def test_a_file_that_is_no_policy_is_refused(folder: Path) -> None:
    for content in (b"", b"no archive", (folder / "Hopper.npz").read_bytes()[:200]):
        (folder / "Hopper.npz").write_bytes(content)
        with refused("bad-policy"):
            experts.load("Hopper", folder)


@pytest.mark.parametrize("mean", [float("nan"), float("inf")])
def test_a_measurement_that_is_not_finite_is_refused_and_nothing_is_written(
    tmp_path: Path, mean: float
) -> None:
    measured = msgspec.structs.replace(MEASURED, mean=mean)
    with refused("bad-card"):
        write_expert(POLICY, msgspec.structs.replace(CARD, measurement=measured), tmp_path / "Hopper.json")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("change", [{"task": "gym_extensions/Walker2d-v0"}, {"policy": 3}, {"surprise": 1}])
def test_a_card_of_another_task_or_form_is_refused(folder: Path, change: dict[str, object]) -> None:
    path = folder / "Hopper.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with refused("bad-card"):
        experts.card("Hopper", folder)


def test_a_card_of_another_definition_of_the_task_is_refused(tmp_path: Path) -> None:
    card = msgspec.structs.replace(CARD, fingerprint="0" * 16)
    write_expert(POLICY, card, tmp_path / "Hopper.json")
    with refused("foreign-fingerprint", "another definition of Hopper"):
        experts.load("Hopper", tmp_path)


def test_a_task_without_expert_and_an_unknown_task_are_named(tmp_path: Path) -> None:
    with refused("no-expert"):
        experts.load("Hopper", tmp_path)
    with refused("unknown-task"):
        experts.load("Hoper")


def test_purposes_never_share_a_seed() -> None:
    for name in ("Hopper", "Pusher"):
        seeds = {purpose: {experts.seed(name, purpose, i) for i in range(1000)} for purpose in PURPOSES}
        assert len(set.union(*seeds.values())) == 1000 * len(PURPOSES)
        assert all(0 <= value < 2**32 for value in set.union(*seeds.values()))


def test_seeds_are_prescribed() -> None:
    row = TASKS["gym_extensions/Hopper-v0"]
    digest = hashlib.sha256(b"expert/gym_extensions/Hopper-v0/7").digest()
    expected = 4 * (int.from_bytes(digest[:4], "little") >> 3) + 2
    assert experts.seed(row, "measure", 7) == experts.seed("Hopper", "measure", 7) == expected


def test_origins_name_the_policies_of_submissions_behind_experts() -> None:
    found = experts.origins()["trpo", "hopper-gravity", "sequential"]
    card = experts.card("HopperGravityOneAndHalf")
    (origin,) = [each for each in found if each.task == "HopperGravityOneAndHalf"]
    place = f"hopper-gravity/sequential-run{origin.run}-stage{origin.stage}"
    assert card.history[-1].name == f"stored:trpo/{place}"
    assert origin.is_expert
    assert all(experts.card(each.task).from_submission for each in found)
