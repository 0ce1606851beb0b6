"""Pages of submissions, the overview, and the pages that explain."""

import copy
import re
from typing import Any

import pytest

from ..browser import files, read
from ..conftest import make_submission, scores_of
from .test_changes import PART
from .test_core import GROUPS, trained_here

GROUP = "groups/hopper-gravity-v0.html"


def test_the_dash_of_a_missing_value_links_to_its_reason(document: dict[str, Any]) -> None:
    metrics = scores_of(document)["metrics"]
    metrics["zero_shot_transfer"] = metrics["asymptotic_transfer"]
    pages = dict(files(document))
    page = pages[GROUP]
    assert '<p class="small">No asymptotic transfer: It needs single-task runs' in page, (
        "a column without a value"
    )
    assert 'data-key="asymptotic_transfer"' not in pages["boards/hopper-gravity-v0-sequential-100k.html"]
    cell = page.split('data-label="Transfer"')[1].split("</td>")[0]
    (note,) = re.findall(r'– <a class="see" href="#([a-z0-9-]+)" title="[^"]+"><sup>1</sup></a>', cell)
    assert f'<li id="{note}">It needs single-task runs: there' in page


def test_the_readme_of_a_submission_has_its_paragraphs_and_line_breaks(document: dict[str, Any]) -> None:
    document["submissions"][0]["readme"] = "\n# Agile & quick\n\n\tlearns\n  *fast*\n"
    page = dict(files(document))["submissions/agile.html"]
    assert '<pre class="readme"># Agile &amp; quick\n\n\tlearns\n  *fast*</pre>' in page


def test_a_refused_submission_is_listed_with_its_problems_and_hints(document: dict[str, Any]) -> None:
    pages = read(document)
    for part in ("missing-cell hopper-gravity/sequential.csv, row 7", "no episode of", "Evaluate every task"):
        assert part in pages["submissions/broken.html"].text
    assert "Broken broken refused 1 problem: missing-cell" in pages["submissions.html"].text


def test_a_copy_stands_below_the_other_submission_without_a_rank(document: dict[str, Any]) -> None:
    assert "Has most episodes" not in read(document)[GROUP].text
    for protocols in document["submissions"][0]["groups"].values():
        for scores in protocols.values():
            scores["episode_sketches"] = [["00c0ffee"]]
    copied = copy.deepcopy(document["submissions"][0])
    copied.update(name="copied", title="Something new")
    document["submissions"].insert(1, copied)
    board = dict(files(document))[GROUP]
    assert re.findall(r'data-submission="(\w+)"', board)[:2] == ["agile", "copied"]
    assert "Not ranked: Has most episodes of agile." in board


def text_of(document: dict[str, Any], path: str = "submissions/agile.html") -> str:
    return read(document)[path].text


def test_a_submission_shows_what_its_verification_found(document: dict[str, Any]) -> None:
    found = {
        **PART,
        "p_value": 0.31,
        "episodes": 3000,
        "repeated": 2999,
        "difference": "run 1, stage 2: 1e-12",
    }
    part = {**PART, "current": 3, "episodes": 600}  # two of its runs were changed since, and have episodes
    document["submissions"][0]["verifications"] = [found, part]
    text = text_of(document)
    for fact in ("2026-11-24", "run 1, stage 2: 1e-12", "0.310", "the policies of 8 runs were run"):
        assert fact in text
    assert text.count("2 999 of 3 000") == 2, "in the head and in the table"
    assert "gym-extensions verify submissions/agile" in text


@pytest.mark.parametrize(
    ("runtime", "how"),
    [("", "bit for bit"), ("onnxruntime 1.32.0", "within 0.1 % of the return, by onnxruntime 1.32.0")],
)
def test_a_verification_says_how_closely_episodes_were_repeated(
    document: dict[str, Any], runtime: str, how: str
) -> None:
    document["submissions"][0]["verifications"] = [{**PART, "runtime": runtime}]
    text = text_of(document)
    assert f"logged episodes were repeated {how}" in text
    assert (text.count(how), "bit for bit" in text) == (2, not runtime)


@pytest.mark.parametrize("level", ["claimed", "verified", "trained here"])
def test_the_level_of_a_submission_is_shown_and_verified_ones_are_counted(
    document: dict[str, Any], level: str
) -> None:
    for submission in document["submissions"]:
        submission["level"] = submission["level"] and "claimed"
        for protocols in submission["groups"].values():
            for scores in protocols.values():
                scores["level"] = "claimed"
    document["submissions"][0]["level"] = scores_of(document)["level"] = level
    pages = read(document)
    text = pages["submissions/agile.html"].text
    assert f"agile {level}" in text
    said = "Claimed: the files follow the rules. Not verified yet."
    assert (said in text) == (level == "claimed")
    found = "5 claimed, 1 refused" if level == "claimed" else f"1 {level}, 4 claimed, 1 refused"
    assert f"6 submissions: {found}." in pages["submissions.html"].text


def test_a_board_has_the_level_of_its_own_logs(document: dict[str, Any]) -> None:
    scores_of(document)["level"] = "trained here"
    assert document["submissions"][0]["level"] == "verified"
    texts = dict(files(document))
    assert 'class="badge badge-trained here"' in texts[GROUP]
    assert "<td>trained here" in texts["boards/hopper-gravity-v0-sequential-100k.html"]


def test_a_submission_whose_verification_failed_says_so(document: dict[str, Any]) -> None:
    scores = scores_of(document)
    document["submissions"][0]["level"] = scores["level"] = "claimed"
    scores["why_claimed"] = "The verification of 2026-11-24 did not pass."
    document["submissions"][0]["verifications"] = [{**PART, "passed": False}]
    text = text_of(document)
    assert "follow the rules. The verification of 2026-11-24 did not pass." in text
    assert "verified on" not in text


def test_a_submission_of_code_alone_waits_and_states_nothing_on_steps(document: dict[str, Any]) -> None:
    document["submissions"].append(make_submission("waits", {}) | {"level": "claimed"})
    pages = read(document)
    assert "no runs yet" in pages["submissions.html"].text.split("waits waits")[1].split("–")[0]
    assert "Training steps" in pages["submissions/agile.html"].text
    assert "Training steps" not in pages["submissions/waits.html"].text


def test_decisions_are_shown_as_they_are_and_escaped(document: dict[str, Any]) -> None:
    decisions = [
        {"action": "accepted", "by": "one", "date": "2026-11-22", "reason": "Verified."},
        {"action": "challenged", "by": "two", "date": "2026-11-23", "reason": "<script>x</script> doubt"},
    ]
    document["submissions"][0]["decisions"] = decisions
    pages = read(document)
    page = pages["submissions/agile.html"]
    assert "by A. Researcher, accepted on 2026-11-22" in page.text
    assert "Challenged on 2026-11-23 by two: <script>x</script> doubt" in page.text
    assert page.errors == []
    assert "challenged" in pages[GROUP].text
    decisions.append({"action": "withdrawn", "by": "one", "date": "2026-11-24", "reason": "An error."})
    text = text_of(document, "submissions.html")
    assert "Agile agile verified withdrawn 1 accepted on 2026-11-22 –" in text


def test_what_the_project_trained_is_shown_with_attempts_seeds_and_failures(document: dict[str, Any]) -> None:
    document["submissions"][0]["training"] = {
        **{"attempts": 3, "date": "2026-01-02", "version": "1.0.0", "commit": "3f" * 20, "value": ""},
        **{"agent": "4e" * 32, "outdated": True},
        "failed": {"hopper-gravity/sequential/run2": "learn(), stage 1: <b>too late</b>"},
    }
    text = text_of(document)
    for fact in (
        *("2026-01-02, gym-extensions 1.0.0; its code was changed", "Attempts 3", "commit 3f3f3f3f3f"),
        *("code 4e4e4e4e4e", "run2 failed, counts as the floor learn(), stage 1: <b>too late</b>"),
    ):
        assert fact in text


def test_runs_that_were_trained_here_are_shown_before_the_authors_own(document: dict[str, Any]) -> None:
    document["submissions"] = [trained_here("trpo")]
    pages = read(document)
    page = pages["submissions/trpo.html"]
    titles = ("Sequential training", "The author’s own runs")
    first, second = (page.text.index(f"{title}, group by group") for title in titles)
    assert first < second
    assert "of groups whose runs above the project trained on 2026-01-02" in page.text
    assert "The project trained the sequential runs on the core itself." in page.text
    assert "policies.load('submissions/trpo/trained/2', 'hopper-gravity', run=0" in page.text
    for group in GROUPS:
        on_group = pages[f"submissions/trpo/{group}-v0.html"]
        for title in ("Sequential, trained here", "Sequential, the author’s own runs"):
            assert f"{title} budget 300k (standard)" in on_group.text
        names = (f"{group}-v0-sequential", f"{group}-v0-own")
        assert tuple(each for each in on_group.ids if each in names) == names
        assert f"{group}-v0-sequential-experts" not in on_group.ids
        assert page.errors == on_group.errors == []


def test_a_submission_that_was_trained_here_has_the_date_of_its_training(document: dict[str, Any]) -> None:
    document["submissions"] = [trained_here("trpo") | {"level": "trained here"}]
    pages = dict(files(document))
    assert ", trained on 2026-01-02</p>" in pages["submissions/trpo.html"]
    assert ">trained on 2026-01-02</td>" in pages["submissions.html"]
    citation = pages["submissions/trpo/citation.bib"]
    assert "year = {2026}" in citation
    assert ", trained on 2026-01-02, core score" in citation


@pytest.mark.parametrize(
    ("counted", "steps"),
    [(True, "counted by the training loop"), (False, "claimed of the author’s own runs")],
)
def test_claimed_steps_are_those_of_the_authors_own_runs(
    document: dict[str, Any], counted: bool, steps: str
) -> None:
    document["submissions"] = [trained_here("trpo") | {"steps_counted": counted}]
    assert f"Training steps {steps}" in text_of(document, "submissions/trpo.html")
