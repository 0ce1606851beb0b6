"""The documentation says what the code does."""

import re
from pathlib import Path

import msgspec

from gym_extensions.catalog.protocol import BUDGETS
from gym_extensions.submissions import layout
from gym_extensions.submissions.log import LOG_COLUMNS
from gym_extensions.submissions.manifest import SECTIONS, Manifest
from gym_extensions.submissions.policies.mlp_arrays import KEYS
from gym_extensions.submissions.review import Decision, Verification
from gym_extensions.submissions.run import Machine, Memory, PolicyFile, RunDocument, Versions

PAGE = (Path(__file__).parents[2] / "docs" / "rollout-log.md").read_text(encoding="utf-8")


def section(title: str) -> str:
    start = PAGE.index(f"\n## {title}")
    end = PAGE.find("\n## ", start + 1)
    return PAGE[start : end if end >= 0 else len(PAGE)]


def test_the_page_states_the_limits() -> None:
    limits = section("Limits")
    sizes = [
        layout.MAX_POLICY_BYTES,
        *(layout.MAX_FILE_BYTES[suffix] for suffix in (".csv", ".json", ".npz")),
    ]
    stated = [f"{size // 2**20} MiB" for size in sizes]
    stated += [f"{layout.MAX_FILE_BYTES[suffix] // 2**10} KiB" for suffix in (".toml", ".md")]
    stated += [f"{layout.MAX_FILES:,}", f"{layout.MAX_SUBMISSION_BYTES // 2**30} GiB", f"{layout.MAX_RUNS}"]
    assert [text for text in stated if text not in limits] == []


def test_the_page_lists_the_arrays_of_a_policy_and_their_choices() -> None:
    policies = section("Policies")
    for name, key in KEYS.items():
        row = re.search(rf"^\| `{name}(_<i>)?`.*$", policies, re.MULTILINE)
        assert row is not None, name
        assert [choice for choice in key.choices if f"`{choice}`" not in row[0]] == []
        assert ("T" in row[0].split("|")[3]) == key.has_tasks, name


def test_the_page_has_every_column_and_key() -> None:
    assert ",".join(LOG_COLUMNS) in PAGE
    document, manifest, review = section("run0.json"), section("submission.toml"), section("review.toml")
    for part in (RunDocument, Versions, Machine, Memory, PolicyFile):
        assert [key for key in part.__struct_fields__ if f"`{key}`" not in document] == []
    assert [name for name in BUDGETS if name not in manifest] == []
    for name, keys in SECTIONS.items():
        assert f"[{name}]" in manifest
        assert [key for key in keys.__struct_fields__ if f"{key} = " not in manifest] == []
    plain = {field.name for field in msgspec.structs.fields(Manifest)} - {*SECTIONS, "hyperparameters"}
    assert [key for key in plain if f"{key} = " not in manifest] == []
    for table in (Verification, Decision):
        assert [key for key in table.__struct_fields__ if key not in review] == []
