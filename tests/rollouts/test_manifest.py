"""submission.toml as dataclasses, from which its keys follow."""

from __future__ import annotations

from dataclasses import FrozenInstanceError, asdict, fields
from pathlib import Path

import pytest

from gym_extensions.catalog.budgets import BUDGETS
from gym_extensions.rollouts.manifest import (
    EVALUATIONS,
    FORMAT,
    FREE_SECTIONS,
    SECTION_TYPES,
    SECTIONS,
    Manifest,
    Memory,
    Observes,
    manifest_of,
)
from gym_extensions.rollouts.manifest_values import Key, hyperparameter_error, value_error
from gym_extensions.rollouts.reading.toml_text import parse

SUBMISSIONS = Path(__file__).parents[2] / "submissions"


def test_a_manifest_has_the_values_of_its_tables(manifest_text: str) -> None:
    parsed = manifest_of(parse(manifest_text.encode()))
    assert (parsed.format, parsed.title, parsed.authors) == (FORMAT, "An entry", ("A. Nonymous",))
    assert (parsed.protocol.budget, parsed.protocol.algorithm) == ("smoke", "formula")
    assert parsed.observes == Observes(False, False, False)
    assert parsed.memory == Memory(2000, 100, 100)
    assert parsed.hyperparameters == {"step": 0.01}
    assert (parsed.archive, parsed.reported) == (None, "")


def test_a_manifest_cannot_be_changed(manifest_text: str) -> None:
    parsed = manifest_of(parse(manifest_text.encode()))
    with pytest.raises(FrozenInstanceError):
        parsed.title = "Another"  # type: ignore[misc]


@pytest.mark.parametrize("path", sorted(SUBMISSIONS.glob("*/submission.toml")), ids=lambda p: p.parent.name)
def test_a_committed_manifest_is_read_whole(path: Path) -> None:
    tables = parse(path.read_bytes())
    parsed = manifest_of(tables)
    sections = {name: asdict(getattr(parsed, name)) for name in SECTION_TYPES if name in tables}
    written = {name: dict(tables[name]) for name in SECTION_TYPES if name in tables}
    if "tuning" in written:
        written["tuning"]["tasks"] = tuple(written["tuning"]["tasks"])
    if "versions" in written:
        written["versions"].setdefault("blas", "")  # older manifests lack it
    assert sections == written
    assert parsed.reported == tables.get("reported", "")


def test_the_keys_are_the_fields_of_the_dataclasses() -> None:
    assert list(SECTIONS["observes"]) == ["task_in_training", "task_in_evaluation", "boundaries"]
    for name, section in SECTION_TYPES.items():
        assert list(SECTIONS[name]) == [field.name for field in fields(section)]
    top = [field.name for field in fields(Manifest)]
    assert sorted(top) == sorted([*SECTIONS[""], *SECTION_TYPES, *FREE_SECTIONS])


def test_the_choices_are_those_of_the_benchmark() -> None:
    assert SECTIONS["protocol"]["budget"].choices == tuple(BUDGETS)
    assert SECTIONS["protocol"]["evaluation"].choices == EVALUATIONS == ("sampled", "deterministic")
    assert SECTIONS[""]["format"].choices == (1,)


@pytest.mark.parametrize("section", list(SECTIONS))
def test_every_kind_of_key_refuses_a_value_of_another_kind(section: str) -> None:
    for key in SECTIONS[section].values():
        assert value_error(key, {"a": "table"})
        assert value_error(key, 1.5)


@pytest.mark.parametrize(("text", "error"), [("x" * 100, ""), ("x" * 101, "The string has 101 characters")])
def test_a_string_has_a_limit(text: str, error: str) -> None:
    assert value_error(Key("a string"), text).startswith(error)
    assert bool(value_error(Key("a string"), text)) == bool(error)


@pytest.mark.parametrize(
    "value", [0, True, -1.5, "", "x" * 4000, [1, "a", 0.5], (1, 2), [0] * 100, 1 - 2**63]
)
def test_hyperparameters(value: object) -> None:
    assert hyperparameter_error(value) == ""


@pytest.mark.parametrize(
    ("value", "error"),
    [
        (float("nan"), "is not finite"),
        ("x" * 4001, "has 4001 characters; the limit is 4000"),
        ([0] * 101, "has 101 elements; the limit is 100"),
        ([float("inf")], "is not finite"),
        ([[1]], "contains an element of type list"),
        (2**63, "is too large"),
        (None, "is of type NoneType"),
        ({}, "is of type dict"),
    ],
)
def test_other_values_are_not_hyperparameters(value: object, error: str) -> None:
    assert hyperparameter_error(value) == error
