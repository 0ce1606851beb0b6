"""The generated tables of docs/ are those of the code, and docs/results.md shows what its code prints."""

from pathlib import Path

import pytest

from gym_extensions.submissions.rules import RULES
from tools import ROOT, docs

PAGES = sorted((ROOT / "docs").glob("*.md"))
HINT = "Run: make docs"
MANIFEST = {"keys Code", "keys Memory", "keys Observes", "keys Protocol", "keys Tuning"}
"""Sections of submission.toml, which docs/rollout-log.md documents."""
HAND_WRITTEN = {"keys Problem", "keys PaperColumns", *MANIFEST}
"""Types that docs/scorecard.md describes in a sentence."""


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_the_tables_are_up_to_date(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert docs.updated(text) == text, HINT


def test_a_table_replaces_an_older_one() -> None:
    page = "# Page\n<!-- table: rules -->\n{}\n<!-- end -->\nText."
    assert docs.updated(page.format("| an | old table |")) == page.format(docs.tables()["rules"])
    assert docs.tables()["rules"].count("\n| `") == len(RULES)


def test_every_table_is_on_a_page() -> None:
    text = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    absent = {name for name in docs.tables() if f"<!-- table: {name} -->" not in text}
    assert absent == HAND_WRITTEN


@pytest.mark.committed
def test_the_page_of_results_shows_what_its_code_prints() -> None:
    text = docs.PAGE.read_text(encoding="utf-8")
    assert len(docs.CELL.findall(text)) == text.count("```python") > 5
    assert docs.executed(text) == text, HINT
