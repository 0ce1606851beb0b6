"""Every page: well formed, linked, without a request to anywhere, safe against a stranger's words."""

from __future__ import annotations

import posixpath
import re
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

from gym_extensions.site.build import files
from gym_extensions.site.page import addresses, pages

VOID = {"meta", "link", "br", "col", "wbr", "img", "input", "hr"}
SELF_CLOSING = {"line", "circle", "polygon", "polyline", "rect"}
LOADING = {"src", "srcset", "data", "poster", "action", "formaction", "background", "xlink:href"}
HOSTILE = '<script>alert("1")</script><img src=x onerror=alert(1)>{{ 7*7 }}'


class Reader(HTMLParser):
    """Reads a page strictly: what is opened is closed, in order."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.faults: list[str] = []
        self.ids: list[str] = []
        self.elements: list[tuple[str, dict[str, str]]] = []
        self.words: list[str] = []
        self.feed(text)
        self.close()
        self.faults += [f"<{tag}> is never closed" for tag in self.open]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        names = [name for name, _ in attrs]
        self.faults += [f"{name} twice in <{tag}>" for name in set(names) if names.count(name) > 1]
        self.elements.append((tag, {name: value or "" for name, value in attrs}))
        self.ids += [value or "" for name, value in attrs if name == "id"]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in SELF_CLOSING:
            self.faults.append(f"<{tag}/> closes itself")
        self.elements.append((tag, {name: value or "" for name, value in attrs}))

    def handle_endtag(self, tag: str) -> None:
        if not self.open or self.open[-1] != tag:
            self.faults.append(f"</{tag}> where {self.open[-1:]} is open")
        else:
            self.open.pop()

    def handle_data(self, data: str) -> None:
        self.words.append(data)

    @property
    def said(self) -> str:
        """All text, spaces evened."""
        return re.sub(r"\s+", " ", " ".join(self.words))


def read(document: dict[str, Any]) -> dict[str, Reader]:
    """Every HTML page of the site by its path."""
    return {path: Reader(text) for path, text in files(document) if path.endswith(".html")}


def test_every_page_is_well_formed(document: dict[str, Any]) -> None:
    found = {path: page.faults for path, page in read(document).items() if page.faults}
    assert found == {}


def test_the_reader_of_these_tests_finds_what_is_wrong() -> None:
    assert Reader("<p><b>x</p>").faults == [
        "</p> where ['b'] is open",
        "<p> is never closed",
        "<b> is never closed",
    ]
    assert Reader('<a id="x" id="y"></a>').faults == ["id twice in <a>"]


def test_every_id_of_a_page_is_its_only_one(document: dict[str, Any]) -> None:
    for path, page in read(document).items():
        assert sorted(set(page.ids)) == sorted(page.ids), path


def test_every_link_inside_the_site_leads_to_a_page_and_a_place_on_it(document: dict[str, Any]) -> None:
    everything = dict(files(document))
    ids = {path: page.ids for path, page in read(document).items()}
    followed = 0
    for path, page in read(document).items():
        for _, attributes in page.elements:
            address = urlsplit(attributes.get("href", ""))
            if not attributes.get("href") or address.scheme:
                continue
            target = (
                posixpath.normpath(posixpath.join(posixpath.dirname(path), address.path))
                if address.path
                else path
            )
            assert target in everything, f"{path} links to {attributes['href']}"
            if address.fragment:
                assert address.fragment in ids[target], f"{path} links to {attributes['href']}"
            followed += 1
    assert followed > 50


def test_every_label_by_id_names_something_on_the_page(document: dict[str, Any]) -> None:
    for path, page in read(document).items():
        for tag, attributes in page.elements:
            label = attributes.get("aria-labelledby")
            assert label is None or label in page.ids, f"{path}: <{tag}> is labelled by {label}"


def test_no_page_asks_another_host_for_anything(document: dict[str, Any]) -> None:
    for path, page in read(document).items():
        for tag, attributes in page.elements:
            assert not LOADING & set(attributes), f"{path}: <{tag}> loads something"
            assert tag not in {"script", "iframe", "object", "embed", "base", "form"}, path
            address = urlsplit(attributes.get("href", ""))
            if address.scheme and tag != "a":
                assert attributes["href"] == "data:,", f"{path}: <{tag}> {attributes['href']}"
            if tag == "a" and address.scheme:
                assert address.scheme in {"http", "https"}, f"{path}: {attributes['href']}"
    sheet = dict(files(document))["static/style.css"]
    assert "url(" not in sheet
    assert "@import" not in sheet


def test_the_only_way_out_is_the_code_that_a_submitter_names(document: dict[str, Any]) -> None:
    out = {
        attributes["href"]
        for page in read(document).values()
        for tag, attributes in page.elements
        if tag == "a" and urlsplit(attributes["href"]).scheme
    }
    assert out == {"https://example.org/agent"}


@pytest.mark.parametrize(
    "url",
    [
        "javascript:alert(1)",
        " javascript:alert(1)",
        "data:text/html,x",
        "//example.org",
        "https:",
        "file:///etc",
    ],
)
def test_a_code_address_that_is_not_of_the_web_is_text_and_no_link(
    document: dict[str, Any], url: str
) -> None:
    document["submissions"][0]["manifest"]["code"]["url"] = url
    page = read(document)["submissions/agile.html"]
    assert url.strip() in page.said
    assert url not in {attributes.get("href") for _, attributes in page.elements}


def test_a_strangers_words_are_only_ever_text(document: dict[str, Any]) -> None:
    first, broken = document["submissions"][0], document["submissions"][-1]
    first["title"] = broken["title"] = HOSTILE
    first["manifest"].update(
        description=HOSTILE,
        authors=[HOSTILE],
        code={"url": f"https://x/{HOSTILE}", "commit": HOSTILE},
        protocol={"budget": "100k", "algorithm": HOSTILE, "evaluation": HOSTILE},
        hyperparameters={HOSTILE: [HOSTILE]},
        versions={HOSTILE: HOSTILE},
    )
    first["notes"] = [HOSTILE]
    broken["problems"] = [{"rule": HOSTILE, "where": HOSTILE, "message": HOSTILE, "hint": HOSTILE}]
    scores = first["groups"]["hopper-gravity-v0"]["sequential"]
    scores["metrics"]["forward_transfer"]["why"] = scores["metrics"]["forgetting"]["why"] = HOSTILE
    scores["metrics"]["forgetting"]["mean"] = None
    for path, page in read(document).items():
        assert page.faults == [], path
        tags = {tag for tag, _ in page.elements}
        assert not tags & {"script", "img"}, path
        assert not [
            name for _, attributes in page.elements for name in attributes if name.startswith("on")
        ], path
    said = read(document)["submissions/agile.html"].said
    assert said.count(re.sub(r"\s+", " ", HOSTILE)) >= 8
    assert "49" not in read(document)["index.html"].said.split("leads")[0]


def test_a_hostile_name_stays_inside_the_folder() -> None:
    found = addresses(["../../etc/passwd", "..", "a/b", "Random", "random", "é", "x" * 300, "plain-1"])
    assert found["plain-1"] == "submissions/plain-1.html"
    assert found["random"] == "submissions/random.html"
    assert len({path.lower() for path in found.values()}) == len(found)
    for path in found.values():
        assert re.fullmatch(r"submissions/[a-z0-9-]{1,100}\.html", path), path


@pytest.mark.parametrize("path", ["index.html", "submissions/agile.html", "metrics.html"])
def test_a_page_can_be_read_by_a_machine_that_reads_aloud(document: dict[str, Any], path: str) -> None:
    page = read(document)[path]
    tags = [tag for tag, _ in page.elements]
    assert dict(page.elements)["html"] == {"lang": "en"}
    assert {"name": "viewport", "content": "width=device-width, initial-scale=1"} in [
        a for _, a in page.elements
    ]
    assert tags.count("h1") == tags.count("main") == 1
    assert tags.index("title") < tags.index("body")
    assert tags.count("caption") == tags.count("table")
    assert all(attributes.get("scope") for tag, attributes in page.elements if tag == "th")
    for tag, attributes in page.elements:
        if tag == "svg":
            assert attributes.get("aria-hidden") or (attributes["role"], bool(attributes["aria-label"])) == (
                "img",
                True,
            )


def test_headings_go_down_one_step_at_a_time(document: dict[str, Any]) -> None:
    for path, page in read(document).items():
        levels = [int(tag[1]) for tag, _ in page.elements if re.fullmatch("h[1-6]", tag)]
        assert levels[0] == 1
        assert all(after <= before + 1 for before, after in pairwise(levels)), path


def test_a_null_says_why_and_is_not_shown_as_zero(document: dict[str, Any]) -> None:
    document["submissions"] = document["submissions"][:1]
    built = read(document)
    assert "there is no single.csv to pair with" in built["index.html"].said
    assert "there is no single.csv to pair with" in built["submissions/agile.html"].said
    row = dict(files(document))["index.html"].split('data-label="Forward transfer"')[1].split("</td>")[0]
    assert "0.00" not in row
    assert 'class="none"' in row


def test_a_refused_submission_is_listed_with_what_to_do(document: dict[str, Any]) -> None:
    for path in ("index.html", "submissions/broken.html"):
        said = read(document)[path].said
        assert "missing-cell hopper-gravity/sequential.csv, row 7" in said
        assert "Run 0, stage 2 has no episode of gym_extensions/Hopper-v0." in said
        assert "Evaluate every task after every stage." in said


def test_provisional_references_are_said_on_every_page_that_uses_them(document: dict[str, Any]) -> None:
    for path in ("index.html", "submissions/agile.html"):
        assert "rovisional references" in read(document)[path].said
    document["references"]["provisional"] = False
    for path in ("index.html", "submissions/agile.html"):
        assert "rovisional references" not in read(document)[path].said


def test_an_open_task_is_named_and_shows_its_raw_returns(document: dict[str, Any]) -> None:
    scores = document["submissions"][0]["groups"]["hopper-gravity-v0"]["sequential"]
    scores["reference"]["gym_extensions/Hopper-v0"] = {"floor": 0.0, "ceiling": None, "open": True}
    page = read(document)["submissions/agile.html"]
    assert "Open: Hopper. No reference agent has learned it" in page.said
    assert "raw return (open)" in page.said
    assert any(
        attributes.get("class", "").startswith("open") for tag, attributes in page.elements if tag == "td"
    )


def test_a_group_without_references_is_shown_raw(document: dict[str, Any]) -> None:
    scores = document["submissions"][0]["groups"]["hopper-gravity-v0"]["sequential"]
    for task in scores["tasks"]:
        scores["reference"][task] = {"floor": None, "ceiling": None, "open": None}
    for name in scores["metrics"]:
        scores["metrics"][name] = {
            "mean": None,
            "low": None,
            "high": None,
            "runs": [],
            "why": "There is no reference.",
        }
    page = read(document)["submissions/agile.html"]
    assert "No metrics. There is no reference." in page.said
    assert "900" in page.said


def test_a_published_table_shows_what_it_has_and_says_what_it_lacks(document: dict[str, Any]) -> None:
    table = document["submissions"][1]
    table.update(trust="reported", groups={"hopper-gravity-v0": table["groups"]["hopper-gravity-v0"]})
    scores = table["groups"]["hopper-gravity-v0"]["sequential"]
    null = {"mean": None, "low": None, "high": None, "runs": [], "why": "Reported: no floor."}
    scores.update(
        budget="paper",
        runs=[],
        matrix=[],
        metrics=dict.fromkeys(scores["metrics"], null),
        missing=["logs", "5 runs"],
        printed_total={**scores["total"], "fully_trained": {"mean": 990.95, "std": 1022.32}},
        notes=["The printed total is not the mean of its rows."],
    )
    pages = read(document)
    said = pages["submissions/keeper.html"].said
    for words in (
        "For a full entry it still needs logs, 5 runs.",
        "No metrics. Reported: no floor.",
        "Group, as printed 990.95 ± 1022.32",
        "The printed total is not the mean of its rows.",
    ):
        assert words in said
    assert "Evaluation matrix" not in said
    assert "Reported elsewhere" in pages["index.html"].said
    assert "hopper-gravity-v0-sequential-paper" not in pages["index.html"].ids


def test_a_suite_has_a_board_before_its_groups_and_a_row_on_the_entrys_page(document: dict[str, Any]) -> None:
    card = document["submissions"][0]
    scores = card["groups"]["hopper-gravity-v0"]["sequential"]
    bodies = ("hopper", "walker2d", "halfcheetah", "humanoid")
    card["groups"] = {f"{body}-gravity-v0": {"sequential": scores} for body in bodies}
    metrics = {name: {**found, "runs": []} for name, found in scores["metrics"].items()}
    card["suites"] = {
        "gravity": {"sequential": {"budget": "100k", "groups": list(card["groups"]), "metrics": metrics}}
    }
    pages = read(document)
    ids = [name for name in pages["index.html"].ids if name.endswith("-sequential-100k")]
    assert ids[0] == "gravity-sequential-100k"
    assert "gravity suite, mean of 4 groups" in pages["index.html"].said
    assert "gravity suite, mean of 4 groups" in pages["submissions/agile.html"].said


def test_an_agent_that_learned_nothing_is_not_praised_for_forgetting_nothing(
    document: dict[str, Any],
) -> None:
    assert "nothing learned to forget" in read(document)["submissions/still.html"].said
    assert "nothing learned to forget" not in read(document)["submissions/agile.html"].said


def test_the_metrics_page_has_every_formula_of_the_scorer() -> None:
    from gym_extensions.scoring.metrics import METRICS

    page = read(
        {"format": 1, "references": {"version": "x", "provisional": False, "sha256": ""}, "submissions": []}
    )
    said = page["metrics.html"].said
    for metric in (metric for protocol in METRICS.values() for metric in protocol):
        assert re.sub(r"\s+", " ", metric.formula) in said
        assert metric.name in page["metrics.html"].ids


def test_every_page_module_is_on_the_site_by_being_in_the_folder() -> None:
    import gym_extensions.site.pages as folder

    modules = {path.stem for path in Path(folder.__path__[0]).glob("*.py")} - {"__init__"}
    assert len(pages()) == len(modules) >= 4
    assert [page.order for page in pages()] == sorted(page.order for page in pages())


def test_curves_are_drawn_where_the_document_has_them(document: dict[str, Any]) -> None:
    scores = document["submissions"][0]["groups"]["hopper-gravity-v0"]["sequential"]
    assert "Learning curves" not in read(document)["submissions/agile.html"].said
    points = [[2000 * step, 10.0 * step] for step in range(1, 11)]
    scores["curves"] = [{"run": 0, "task": "gym_extensions/Hopper-v0", "points": points}]
    page = read(document)["submissions/agile.html"]
    assert "Learning curves" in page.said
    assert "gym_extensions/Hopper-v0: training returns, at the end 100" in str(page.elements)
