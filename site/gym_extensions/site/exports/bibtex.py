"""The citation of an entry as BibTeX."""

from __future__ import annotations

import re
import unicodedata

from gym_extensions.scoring.scorecard.model import Scorecard
from gym_extensions.site.addresses import slug
from gym_extensions.site.text.labels import web_address

ESCAPED = {character: f"\\{character}" for character in "&%$#_"} | {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
}
URL = re.compile(r"[^\s{}\\%]+")


def bibtex(card: Scorecard) -> str:
    """An entry of type ``misc`` with title, authors, code and the date on which the ledger accepted it.

    Text of the submission is escaped.
    """
    facts = card.manifest
    fields = {"title": f"{{{_escaped(card.title)}}}"}
    if facts is not None and facts.authors:
        fields["author"] = " and ".join(f"{{{_escaped(author)}}}" for author in facts.authors)
    accepted = card.ledger.accepted if card.ledger is not None else ""
    if accepted:
        fields["year"] = accepted.partition("-")[0]
    fields["howpublished"] = "Entry of the gym-extensions leaderboard"
    fields["note"] = f"Submission {_escaped(card.name)}"
    url = web_address(facts.code.url) if facts is not None else ""
    if URL.fullmatch(url):
        fields["url"] = url
    if facts is not None and facts.code.commit:
        fields["note"] += f", code at commit {_escaped(facts.code.commit)}"
    if accepted:
        fields["note"] += f", accepted on {accepted}"
    lines = [f"  {name} = {{{value}}}," for name, value in fields.items()]
    return "\n".join([f"@misc{{gym-extensions-{slug(card.name)},", *lines, "}", ""])


def _escaped(text: str) -> str:
    """Text on one line, with the characters that BibTeX and TeX read as commands escaped."""
    line = " ".join(unicodedata.normalize("NFC", text).split())
    return "".join(ESCAPED.get(character, character) for character in line)
