"""Writes docs/findings.md and its figures from the committed submissions: ``make findings``.

Every number and verdict is computed from the submissions. The text is in ``page.md.jinja``; ``groups.py``
says what is compared.
"""

from __future__ import annotations

import sys
from pathlib import Path

from figures import draw_learned_and_final, draw_retention
from groups import FINE_TUNING, group_of, group_rows, groups_without_score, open_tasks
from page import render
from retention import as_scores, most_forgotten
from suites import suites_of
from transfer import transfer

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.protocol import STANDARD_BUDGET
from gym_extensions.files import write_text
from gym_extensions.results.frames import evaluations
from gym_extensions.scoring.pipeline import make_scorer
from gym_extensions.scoring.references import ALONE, load_references

ROOT = Path(__file__).resolve().parents[2]
FOLDER, PAGE = ROOT / "docs" / "findings", ROOT / "docs" / "findings.md"


def main(submissions: Path = ROOT / "submissions") -> None:
    """Writes the page and its figures."""
    if not submissions.is_dir():
        raise SystemExit(f"{submissions}: no such folder. Give the folder with the submissions.")
    scorer = make_scorer()
    folders = [path.parent for path in sorted(submissions.glob("*/submission.toml"))]
    cards = [card for card in map(scorer, folders) if not card.problems]
    groups = [
        group_of(group.name, rows)
        for group in GROUPS.values()
        if (rows := group_rows(cards, group.id)) and rows[0].name == FINE_TUNING
    ]
    for group in groups:
        if group.is_compared:
            points = [(row.title, row.learned, row.final) for row in group.all_rows]
            draw_learned_and_final(points, FOLDER / f"{group.name}.svg")
    if forgotten := most_forgotten(
        {group.name: group.rows[0].forgetting for group in groups if group.is_learned}
    ):
        scores = as_scores(evaluations(submissions / FINE_TUNING), load_references().tasks)
        draw_retention(scores, forgotten, FOLDER / "retention.svg")
    compared = {group.name for group in groups}
    transfers = [
        transfer(card, group.id, group.name)
        for card in cards
        for group in GROUPS.values()
        if card.name == FINE_TUNING and group.name in compared
    ]
    without_score = groups_without_score(cards)
    suites = [
        suite for card in cards if card.name == FINE_TUNING for suite in suites_of(card, STANDARD_BUDGET)
    ]
    alone = [make_scorer(ruler=ALONE)(submissions / FINE_TUNING)] if groups else []
    by_alone = {group.name: row for group in groups for row in group_rows(alone, GROUPS[group.name].id)}
    write_text(PAGE, render(groups, without_score, transfers, open_tasks(), suites, by_alone=by_alone))


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
