"""examples/checkpoints.py: its page shows it, and its submission has all policies."""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest

from gym_extensions.submissions.reader import read

EXAMPLE = Path(__file__).parents[2] / "examples/checkpoints.py"


def test_the_page_shows_the_code_of_the_example() -> None:
    page = (EXAMPLE.parents[1] / "docs/checkpoints.md").read_text(encoding="utf-8")
    imports, function = page.partition("```python\n")[2].partition("```")[0].split("\n\n\n")
    text = EXAMPLE.read_text(encoding="utf-8")
    assert imports in text
    assert function in text


def test_the_submission_has_no_problems_and_all_policies(
    load_example: Callable[[str], ModuleType], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    example = load_example("checkpoints")
    assert (example.GROUP, example.STAGES) == ("hopper-gravity", 6)
    for name, value in {"GROUP": "hopper-motor-noise", "STAGES": 3, "RUNS": (0,)}.items():
        monkeypatch.setattr(example, name, value)  # two tasks instead of five
    example.pretend_to_train(tmp_path / "checkpoints")
    example.record_checkpoints(tmp_path / "checkpoints", tmp_path / "mine")
    submission = read(tmp_path / "mine", policies=True)
    assert submission.problems == ()
    assert all(document.policies for document in submission.documents.values())
