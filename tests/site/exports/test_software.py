"""The citation of the project agrees with CITATION.cff."""

from __future__ import annotations

import re
from pathlib import Path

from gym_extensions.site.exports.software import software_bibtex

CITATION = (Path(__file__).parents[3] / "CITATION.cff").read_text("utf-8")


def test_the_citation_names_what_citation_cff_names() -> None:
    text = software_bibtex()
    for key in ("title", "url"):
        assert all(value in text for value in re.findall(rf"^ *{key}: (.+)$", CITATION, re.MULTILINE))
    names = re.findall(r"family-names: (.+)\n +given-names: (.+)", CITATION)
    assert len(names) == 6
    assert all(f"{family}, {given}" in " ".join(text.split()) for family, given in names)
    assert "The gym-extensions authors" in text
