"""What pages show of the ledger, of signs, challenges, related entries and evaluations on new seeds."""

from __future__ import annotations

from typing import Any

import pytest

from ..browser import read

ACCEPTED = {
    "event": "accepted",
    "digest": "ab" * 32,
    "date": "2026-11-22",
    "accepted": "2026-11-22",
    "reason": "Its merge.",
    "level": "replayed",
    "replayed": 220,
    "episodes": 3000,
    "scorer": "1.0.0",
    "salt": "cd" * 32,
}


def text_of(document: dict[str, Any], path: str = "submissions/agile.html") -> str:
    return read(document)[path].text


def test_an_entry_shows_the_line_of_the_ledger(document: dict[str, Any]) -> None:
    document["submissions"][0].update(ledger=ACCEPTED, trust="replayed (salted sample: 220 of 3000 episodes)")
    text = text_of(document)
    assert "accepted on 2026-11-22: Its merge." in text
    assert "220 of 3 000 episodes" in text
    assert "ab" * 32 in text
    assert "cd" * 32 in text


@pytest.mark.parametrize("level", ["replayed", "re-evaluated", "reproduced"])
def test_levels_above_validated_are_explained_and_counted(document: dict[str, Any], level: str) -> None:
    document["submissions"][0].update(ledger={**ACCEPTED, "level": level}, trust=f"{level} (all)")
    pages = read(document)
    assert f"{level} (all)" in pages["submissions/agile.html"].text
    assert "of which 1 was replayed" in pages["index.html"].text
    assert level in pages["metrics.html"].text


def test_an_entry_that_the_ledger_lacks_is_not_accepted_yet(document: dict[str, Any]) -> None:
    document["submissions"][0]["ledger"] = {"event": "pending", "digest": "ab" * 32}
    pages = read(document)
    for path in ("submissions/agile.html", "entries.html", "boards/hopper-gravity-v0-sequential-100k.html"):
        assert "not accepted yet" in pages[path].text
    assert "Not accepted yet:" in pages["submissions/agile.html"].text


def test_a_withdrawn_entry_says_so_where_it_is_listed(document: dict[str, Any]) -> None:
    document["submissions"][0]["ledger"] = {**ACCEPTED, "event": "withdrawn"}
    assert "withdrawn" in text_of(document, "entries.html")


def test_challenges_are_shown_as_they_are_and_escaped(document: dict[str, Any]) -> None:
    challenge = {"file": "challenges/agile/doubt.txt", "text": "<script>x</script>\n  indented **text**"}
    document["submissions"][0]["challenges"] = [challenge]
    page = read(document)["submissions/agile.html"]
    assert "<script>x</script> indented **text**" in page.text
    assert page.errors == []
    assert "1 challenge" in text_of(document, "boards/hopper-gravity-v0-sequential-100k.html")


def test_signs_are_listed_without_a_verdict(document: dict[str, Any]) -> None:
    document["submissions"][0]["signs"] = ["Every return is a multiple of 10."]
    text = text_of(document)
    assert "Every return is a multiple of 10." in text
    assert "none of them is a verdict" in text


def test_the_return_on_new_seeds_is_beside_the_logged_one(document: dict[str, Any]) -> None:
    fresh = {"logged": 700.0, "fresh": 690.5, "cells": []}
    document["submissions"][0]["groups"]["hopper-gravity-v0"]["sequential"]["reevaluation"] = fresh
    assert "return 690.5 on average; the log says 700.0" in text_of(document)


def test_related_entries_are_counted_on_the_row(document: dict[str, Any]) -> None:
    for entry in document["submissions"][:2]:
        entry["manifest"]["protocol"]["algorithm"] = "trpo"
    assert "1 related entry on this board" in text_of(
        document, "boards/hopper-gravity-v0-sequential-100k.html"
    )
