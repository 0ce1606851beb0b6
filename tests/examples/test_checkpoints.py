"""examples/checkpoints.py: short, and its submission can be scored and replayed."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

from gym_extensions.scoring.replay.verify import verify

EXAMPLE = Path(__file__).parents[2] / "examples/checkpoints.py"
MAX_LINES = 15


@pytest.fixture
def example(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    pytest.importorskip("torch")
    spec = importlib.util.spec_from_file_location("checkpoints", EXAMPLE)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "checkpoints", module)
    spec.loader.exec_module(module)
    return module


def test_the_marked_code_and_its_import_are_at_most_fifteen_lines() -> None:
    text = EXAMPLE.read_text(encoding="utf-8")
    marked = text.partition("# --- from checkpoints to a submission ---")[2].partition("# --- end ---")[0]
    imported = "from gym_extensions.baselines import Card, record"
    assert imported in text
    lines = [imported, *(line for line in marked.splitlines() if line.strip())]
    assert 10 < len(lines) <= MAX_LINES


def test_the_page_shows_the_code_of_the_example() -> None:
    page = (EXAMPLE.parents[1] / "docs/checkpoints.md").read_text(encoding="utf-8")
    imported, function = page.partition("```python\n")[2].partition("```")[0].split("\n\n\n")
    text = EXAMPLE.read_text(encoding="utf-8")
    assert imported in text
    assert function in text


def test_the_submission_of_a_run_can_be_replayed(
    example: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert (example.GROUP, example.STAGES) == ("hopper-gravity", 6)
    for name, value in {"GROUP": "hopper-motor-noise", "STAGES": 3, "RUNS": (0,)}.items():
        monkeypatch.setattr(example, name, value)  # two tasks instead of five
    example.pretend_to_train(tmp_path / "checkpoints")
    example.record_checkpoints(tmp_path / "checkpoints", tmp_path / "mine")
    verification = verify(tmp_path / "mine")
    assert verification.problems == ()
    assert verification.level == "replayed (sample: 4 of 120 episodes)"
