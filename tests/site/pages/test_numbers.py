"""What a number opens: interval, runs, test, command and links of a row of a board, and of the core."""

import json
import re
from typing import Any
from xml.etree import ElementTree

import pytest

from gym_extensions.site.paths import number_file

from ..browser import Reader, files
from .test_core import GROUPS, method, trained_here

BOARD = number_file("agile", "hopper-gravity-v0", "sequential", "100k")


def opened(texts: dict[str, str], path: str) -> Reader:
    """The markup that a script hands over."""
    call = texts[path].removeprefix("openNumber(").removesuffix(");\n")
    file, markup = json.loads(f"[{call}]")
    assert file == path
    return Reader(markup)


def names(found: Reader) -> list[str]:
    """The rows, one of which is marked."""
    return [each["data-number-of"] for _, each in found.elements if "data-number-of" in each]


def test_a_number_of_a_board_opens_its_runs_its_test_and_the_command(document: dict[str, Any]) -> None:
    found = opened(dict(files(document)), BOARD)
    assert found.errors == []
    assert "gym-extensions score submissions/agile --group hopper-gravity" in found.text
    assert "hopper-gravity, Sequential, 100k (quick): 5 runs (0, 1, 2, 3, 4)" in found.text
    rows = names(found)
    assert rows[:3] == ["Kept", "Learned", "Forgotten"]
    dots = [each for each, attributes in found.elements if attributes.get("class") == "run"]
    assert len(dots) == 5 * len(rows)


def test_a_number_of_the_core_opens_every_group_with_the_compared_runs(document: dict[str, Any]) -> None:
    document["submissions"] = [method("keeper", 0.8, 0.98), method("loser", 0.8, 0.5)]
    found = opened(dict(files(document)), number_file("loser"))
    assert found.errors == []
    assert "gym-extensions score submissions/loser --group core" in found.text
    assert names(found) == ["Kept", *GROUPS]
    assert "significantly below Keeper: difference" in found.text
    assert "Significant difference over the core" in found.text
    assert "Keeper (p " in found.text
    assert re.search(r"Mean of 7 groups 0\.\d\d 0\.\d\d to 0\.\d\d rank 2", found.text), "beside the mean"


@pytest.mark.parametrize("page", ["groups/hopper-gravity-v0.html", "submissions/agile.html"])
def test_links_of_what_opens_lead_to_pages_and_the_page_names_its_script(
    document: dict[str, Any], page: str
) -> None:
    texts = dict(files(document))
    assert f'data-number="{BOARD}"' in texts[page]
    for path in (path for path in texts if texts[path].startswith("openNumber(")):
        for target, anchor in opened(texts, path).links(path):
            assert target in texts, f"{path} links to {target}"
            assert not anchor or f'id="{anchor}"' in texts[target], f"{path} links to {target}#{anchor}"


def test_a_method_of_the_core_has_a_badge_with_its_score_and_rank(document: dict[str, Any]) -> None:
    document["submissions"] = [method("keeper", 0.8, 0.98), method("loser", 0.8, 0.5)]
    texts = dict(files(document))
    said = ElementTree.fromstring(texts["submissions/loser/badge.svg"]).get("aria-label")
    assert re.fullmatch(r"gym-extensions: kept 0\.\d\d \(0\.\d\d to 0\.\d\d\), rank 2", said or "")
    assert 'src="../submissions/loser/badge.svg"' in texts["submissions/loser.html"]


def test_a_number_of_the_core_opens_the_runs_that_were_trained_here(document: dict[str, Any]) -> None:
    document["submissions"] = [trained_here("trpo"), method("keeper", 0.8, 0.98)]
    texts, path = dict(files(document)), number_file("trpo")
    found = opened(texts, path)
    assert "runs 0 to 4 of every group, trained here" in found.text
    anchors = {anchor: target for target, anchor in found.links(path) if anchor.endswith("sequential")}
    assert list(anchors) == [f"{group}-v0-sequential" for group in GROUPS]
    assert all(anchor in Reader(texts[target]).ids for anchor, target in anchors.items())
    assert "significantly below Keeper" in found.text, "on a group's board"
