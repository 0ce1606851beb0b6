"""What training did to networks, on the page of a submission and on Compare."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.submissions.test_diagnostics import HERE, write

from ..browser import Reader, files


def test_networks_are_on_the_page_of_a_submission_and_on_compare(
    document: dict[str, Any], make_submission: Callable[..., Path]
) -> None:
    folders = {name: make_submission(name=name, protocols=("sequential",)) for name in ("agile", "keeper")}
    write(folders["agile"])
    texts = dict(files(document, **folders))
    page = Reader(texts["submissions/agile.html"])
    assert page.errors == []
    section = page.text[page.text.index("Networks") :]
    assert "2.00 → 3.50 → 9.50 6.00" in section
    assert "Networks" not in Reader(texts["submissions/keeper.html"]).text
    script = json.loads(texts["api/compare.js"].removeprefix("compareIndex(").removesuffix(");\n"))
    assert script["networks"] == {"agile": {HERE.name: [[3.5, 9.5], [0.0, 1.0]]}, "keeper": {}}
