"""The generated tables of the documentation are up to date and complete."""

from __future__ import annotations

from pathlib import Path

import pytest

from gym_extensions.scoring.metrics.definitions import TABLE
from gym_extensions.scoring.metrics.metric import Metric
from gym_extensions.scoring.output.docs import main, tables, updated

DOCS = Path(__file__).parents[3] / "docs"
PAGES = ("metrics.md", "scorecard.md")
MANIFEST = {"keys Archive", "keys Code", "keys Memory", "keys Observes", "keys Protocol", "keys Tuning"}
"""Sections of submission.toml, which docs/rollout-log.md documents."""
HAND_WRITTEN = {"keys Problem", "keys PaperColumns", *MANIFEST}
"""Types that docs/scorecard.md describes in a sentence."""


@pytest.mark.parametrize("page", PAGES)
def test_the_tables_are_up_to_date(page: str) -> None:
    text = (DOCS / page).read_text(encoding="utf-8")
    assert updated(text) == text, "Run: make docs"


def test_every_type_of_the_documents_has_a_table() -> None:
    text = (DOCS / "scorecard.md").read_text(encoding="utf-8")
    absent = {name for name in tables() if f"<!-- table: {name} -->" not in text}
    assert absent == HAND_WRITTEN


def test_every_key_of_a_table_has_a_description() -> None:
    rows = [row for name, table in tables().items() if name not in HAND_WRITTEN for row in table.splitlines()]
    assert [
        row for row in rows if row.endswith("| |") or (row.endswith("|  |") and row.count("|") == 3)
    ] == []


@pytest.mark.parametrize("metric", TABLE, ids=lambda metric: metric.name)
def test_every_metric_is_on_both_pages_with_its_formula(metric: Metric) -> None:
    for page in PAGES:
        text = (DOCS / page).read_text(encoding="utf-8")
        assert f"| `{metric.name}` {metric.title} | {metric.formula} |" in text


def test_a_stale_table_is_written_anew_and_the_rest_stays(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("Before.\n<!-- table: metrics single -->\nold\n<!-- end -->\nAfter.\n", encoding="utf-8")
    main(str(tmp_path))
    table = tables()["metrics single"]
    text = f"Before.\n<!-- table: metrics single -->\n{table}\n<!-- end -->\nAfter.\n"
    assert page.read_text(encoding="utf-8") == text


def test_an_unknown_table_is_an_error() -> None:
    with pytest.raises(KeyError, match="metrics double"):
        updated("<!-- table: metrics double -->\n<!-- end -->\n")
