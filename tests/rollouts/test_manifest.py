"""submission.toml as a value."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from gym_extensions.rollouts.manifest import FORMAT, Manifest, Observes, findings, manifest_of, parse

from ..conftest import MANIFEST

SUBMISSIONS = Path(__file__).parents[2] / "submissions"


def test_a_manifest_has_the_values_of_its_tables() -> None:
    parsed = manifest_of(parse(MANIFEST.encode()))
    assert (parsed.format, parsed.title, parsed.authors) == (FORMAT, "An entry", ("A. Nonymous",))
    assert (parsed.protocol.budget, parsed.protocol.algorithm) == ("smoke", "formula")
    assert (parsed.protocol.steps, parsed.reported) == ("recorded", "")
    assert parsed.observes == Observes(False, False, False)
    assert parsed.hyperparameters == {"step": 0.01}


def test_a_manifest_cannot_be_changed() -> None:
    parsed = manifest_of(parse(MANIFEST.encode()))
    with pytest.raises(AttributeError):
        parsed.title = "Another"  # type: ignore[misc]


@pytest.mark.parametrize("path", sorted(SUBMISSIONS.glob("*/submission.toml")), ids=lambda p: p.parent.name)
def test_a_committed_manifest_is_read_whole(path: Path) -> None:
    tables = parse(path.read_bytes())
    assert list(findings(tables)) == []
    read = msgspec.json.decode(msgspec.json.encode(manifest_of(tables)))
    for name, value in tables.items():
        assert read[name] == (read[name] | value if isinstance(value, dict) else value), name


def test_every_key_has_a_kind_in_words() -> None:
    for name in Manifest.__struct_fields__:
        assert [rule for rule, _ in findings({name: object()}) if rule == "bad-value"], name
