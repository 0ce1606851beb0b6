"""The decision records: the index is complete, and superseded records point to their successors."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

ADR = Path(__file__).resolve().parent.parent / "docs" / "adr"


@pytest.fixture(scope="module")
def script() -> ModuleType:
    """docs/adr/index.py as a module."""
    spec = importlib.util.spec_from_file_location("adr_index", ADR / "index.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


def write(folder: Path, number: int, status: str) -> None:
    (folder / f"{number:04}-title.md").write_text(
        f"# {number}. Title {number}\n\n{status}\n\nText.\n", "utf-8"
    )


def test_the_index_is_up_to_date(script: ModuleType) -> None:
    assert (ADR / "README.md").read_text("utf-8") == script.index(script.records()), (
        "run python docs/adr/index.py"
    )


def test_both_records_of_a_replacement_name_each_other(script: ModuleType) -> None:
    decisions = script.records()
    forward = {(old, record.number) for record in decisions for old in record.supersedes}
    backward = {(record.number, new) for record in decisions for new in record.superseded_by}
    assert forward == backward


def test_every_successor_exists(script: ModuleType) -> None:
    decisions = script.records()
    successors = {new for record in decisions for new in record.superseded_by}
    assert successors <= {record.number for record in decisions}


def test_every_status_is_accepted_or_superseded(script: ModuleType) -> None:
    states = {record.status.split(",")[0].split(" by ADR")[0] for record in script.records()}
    assert states <= {"accepted", "superseded"}


def test_a_superseded_record_links_to_its_successor(
    script: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(tmp_path, 1, "Status: superseded by ADR 3")
    write(tmp_path, 2, "Status: superseded by ADR 3")
    write(tmp_path, 3, "Status: accepted, supersedes ADR 1 and ADR 2")
    monkeypatch.setattr(script, "FOLDER", tmp_path)
    assert script.index(script.records()).splitlines()[-3:] == [
        "| 1 | [Title 1](0001-title.md) | superseded | [ADR 3](0003-title.md) |",
        "| 2 | [Title 2](0002-title.md) | superseded | [ADR 3](0003-title.md) |",
        "| 3 | [Title 3](0003-title.md) | accepted |  |",
    ]
    assert script.records()[2].supersedes == (1, 2)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("# 4. Title\n\nText.\n", "0004-title.md: add a line 'Status: accepted' below the title."),
        (
            "# 5. Title\n\nStatus: accepted\n",
            "0004-title.md: the first line must be '# 4. Title'.",
        ),
    ],
)
def test_an_incomplete_record_is_named(script: ModuleType, tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "0004-title.md").write_text(text, "utf-8")
    with pytest.raises(SystemExit) as stop:
        script.read(tmp_path / "0004-title.md")
    assert str(stop.value) == message
