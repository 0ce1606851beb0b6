"""Citation, CSV and commands of a submission."""

from typing import Any

import pytest

from gym_extensions.site.pages.submissions import bibtex, commands
from gym_extensions.site.paths import NOWHERE, Source

from ..browser import typed
from ..conftest import MADE
from .test_core import method


def test_the_commands_check_and_repeat_a_submission(document: dict[str, Any]) -> None:
    card = document["submissions"][0]
    card.update(name="a b; rm", level="claimed")
    assert "policies" not in commands(typed(document).submissions[0]), "it publishes none"
    made = {**MADE, "command": "gym-extensions train mine"}
    card["groups"]["hopper-gravity-v0"]["sequential"]["provenance"] = [made]
    text = commands(typed(document).submissions[0])
    assert "gym-extensions verify 'submissions/a b; rm'\n" in text
    assert "# what trained run 0 on hopper-gravity-v0\ngym-extensions train mine\n" in text
    assert "policies.load('submissions/a b; rm', 'hopper-gravity', run=0, stage=5)" in text


def test_the_citation_has_title_authors_code_repository_version_core_score_and_date(
    document: dict[str, Any],
) -> None:
    card = document["submissions"][0] = method("agile", 0.8, 0.95)
    plain = bibtex(typed(document).submissions[0], NOWHERE)
    assert plain.startswith(
        "@misc{gym-extensions-agile,\n  title = {{Agile}},\n  author = {{A. Researcher}},\n"
    )
    for line in (
        "  note = {Submission agile, code at commit 0123abc",
        "  url = {https://example.org/agent},",
    ):
        assert line in plain
    accepted = {"action": "accepted", "by": "maintainer", "date": "2026-11-22", "reason": "Verified."}
    card["decisions"] = [accepted]
    (typed_card, *_) = typed(document).submissions
    assert typed_card.core
    citation = bibtex(typed_card, Source("https://example.org/a_b", version="1.0.0"))
    for fact in (
        *("\\url{https://example.org/a\\_b}", "version = {gym-extensions 1.0.0}", "  year = {2026},\n"),
        *(f"core score {typed_card.core.metrics['final_performance'].mean:.2f} (", "accepted on 2026-11-22"),
    ):
        assert fact in citation


@pytest.mark.parametrize(
    ("title", "escaped"),
    [
        ("50 % & more_", r"50 \% \& more\_"),
        (r"\input{secret}", r"\textbackslash{}input\textbraceleft{}secret\textbraceright{}"),
        ("Half {open", r"Half \textbraceleft{}open"),
        ("two\nlines", "two lines"),
        ("Ünïcode 智能", "Ünïcode 智能"),
    ],
)
def test_a_title_cannot_become_a_command(document: dict[str, Any], title: str, escaped: str) -> None:
    document["submissions"][0]["title"] = title
    citation = bibtex(typed(document).submissions[0], NOWHERE)
    assert f"  title = {{{{{escaped}}}}}," in citation
    assert citation.count("{") == citation.count("}")


def test_an_address_that_would_end_its_field_is_left_out(document: dict[str, Any]) -> None:
    document["submissions"][0]["manifest"]["code"]["url"] = "https://example.org/},evil={"
    assert "url" not in bibtex(typed(document).submissions[0], NOWHERE)
