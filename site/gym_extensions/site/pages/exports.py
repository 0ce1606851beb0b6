"""What readers take away: an entry's citation and metrics, and the commands that check and repeat it."""

from __future__ import annotations

import re
import shlex
import unicodedata
from collections.abc import Iterator

from gym_extensions.scoring.output.tables import csv_text
from gym_extensions.scoring.scorecard import Scorecard, ScorecardDocument
from gym_extensions.site import paths
from gym_extensions.site.entry_results import SEQUENTIAL, group_results
from gym_extensions.site.pages.page import Draft, File, Render
from gym_extensions.site.text import split_version

ESCAPED = {character: f"\\{character}" for character in "&%$#_"} | {
    "\\": r"\textbackslash{}",
    "{": r"\textbraceleft{}",
    "}": r"\textbraceright{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
}
URL = re.compile(r"[^\s{}\\%]+")


def publish_entry(entry: Scorecard, render: Render) -> Iterator[File]:
    """The files that the page of an entry offers: metrics as CSV and a citation."""
    if not entry.problems:
        document = ScorecardDocument(references=render.references, submissions=(entry,))
        path = paths.entry_file(entry.name, "metrics.csv")
        yield path, Draft(render.inputs[entry.name], lambda: csv_text(document))
        yield paths.entry_file(entry.name, "citation.bib"), bibtex(entry)


def bibtex(card: Scorecard) -> str:
    """An entry of type ``misc`` with title, authors, code and the date of its acceptance.

    Text of the submission is escaped.
    """
    facts = card.manifest
    fields = {"title": f"{{{_escaped(card.title)}}}"}
    if facts is not None and facts.authors:
        fields["author"] = " and ".join(f"{{{_escaped(author)}}}" for author in facts.authors)
    if card.accepted:
        fields["year"] = card.accepted.partition("-")[0]
    fields["howpublished"] = "Entry of the gym-extensions leaderboard"
    fields["note"] = f"Submission {_escaped(card.name)}"
    url = facts.code.url if facts is not None else ""
    if URL.fullmatch(url):
        fields["url"] = url
    if facts is not None and facts.code.commit:
        fields["note"] += f", code at commit {_escaped(facts.code.commit)}"
    if card.accepted:
        fields["note"] += f", accepted on {card.accepted}"
    lines = [f"  {name} = {{{value}}}," for name, value in fields.items()]
    return "\n".join([f"@misc{{gym-extensions-{paths.slug(card.name)},", *lines, "}", ""])


def _escaped(text: str) -> str:
    """Text on one line, with the characters that BibTeX and TeX read as commands escaped.

    BibTeX counts braces after a backslash, too, so a brace is a command with balanced ones.
    """
    line = " ".join(unicodedata.normalize("NFC", text).split())
    return "".join(ESCAPED.get(character, character) for character in line)


def commands(card: Scorecard) -> str:
    """The commands that check an entry, repeat a run of it and load one of its policies, in a clone."""
    folder = f"submissions/{card.name}"
    lines = [
        "# repeat the logged episodes with the published policies, and run these on new seeds",
        f"gym-extensions verify {shlex.quote(folder)}",
    ]
    results = [result for result in group_results(card) if result.detail and result.detail.provenance]
    if not results:
        return lines[1]
    made = results[0].detail.provenance[0] if results[0].detail else None
    if made and made.command:
        lines += [f"# what trained run {made.run} on {results[0].group}", made.command]
    sequential = next((result for result in results if result.protocol == SEQUENTIAL), None)
    if sequential and sequential.detail and sequential.detail.provenance[0].policies:
        group = split_version(sequential.group)[0]
        lines += [
            "# a policy, in Python: of a run, after any stage",
            "from gym_extensions import policies",
            f"policy = policies.load({folder!r}, {group!r}, run={sequential.runs[0]}, "
            f"stage={len(sequential.tasks)})",
        ]
    return "\n".join(lines)
