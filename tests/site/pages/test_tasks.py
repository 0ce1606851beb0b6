"""A page per task: what differs, references, best submissions and the expert."""

from pathlib import Path

import pytest

from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.tasks import TASKS, task
from gym_extensions.references import load_references
from gym_extensions.site.pages.tasks import expert_panel
from gym_extensions.site.paths import task_path

from ..browser import Reader, site_files
from ..conftest import everything
from .test_core import trained_here


@pytest.fixture(scope="module")
def pages() -> dict[str, str]:
    """Every text file of the site, with the references. All submissions but *Zero action* were replayed."""
    document, current = everything(), load_references()
    document["references"] = {"version": current.version, "sha256": current.digest}
    for card in document["submissions"]:
        if card["level"] and card["title"] == "Zero action":
            card["level"] = "claimed"
    document["submissions"].append(trained_here("trpo"))
    return dict(site_files(document))


def page(pages: dict[str, str], name: str) -> Reader:
    return Reader(pages[task_path(task(name).id)])


def test_every_published_task_has_a_page_that_the_list_links_to(pages: dict[str, str]) -> None:
    links = {attributes.get("href") for _, attributes in Reader(pages["tasks.html"]).elements}
    assert {task_path(task_id) for task_id in TASKS} <= links
    assert all(task_path(task_id) in pages for task_id in TASKS)


def test_pages_are_valid_and_their_links_lead_somewhere(pages: dict[str, str]) -> None:
    for name in ("HopperBigFoot", "Humanoid", "PusherMovingGoal", "Image-Based-Navigation-2d-Map1-Goal2"):
        path = task_path(task(name).id)
        reader = Reader(pages[path])
        assert reader.errors == []
        targets = {target for target, _ in reader.links(path)}
        assert {target for target in targets if not target.startswith("pictures/")} <= pages.keys()


def test_a_page_says_what_differs_and_by_how_much(pages: dict[str, str]) -> None:
    text = page(pages, "HopperBigFoot").text
    assert "radius and mass × 1.25 (radius: foot_geom 0.06 → 0.075 m; mass 5.316 → 6.644 kg)" in text
    assert "Nothing: it is the base body." in page(pages, "Hopper").text


def test_a_page_has_definition_spaces_fingerprint_versions_and_groups(pages: dict[str, str]) -> None:
    text = page(pages, "HopperGravityHalf").text
    for part in ("motor of thigh_joint", "velocity of rootx", "1 000 steps.", "v0: first published version"):
        assert part in text
    assert published("gym_extensions/HopperGravityHalf-v0") in text
    assert "hopper-gravity-v0 (task 1 of 5)" in text


def test_the_best_submissions_are_sorted_by_the_return_at_the_end(pages: dict[str, str]) -> None:
    text = page(pages, "HopperGravityHalf").text
    assert text.index("Keeper") < text.index("Agile agile hopper-gravity")
    assert "Trpo trpo hopper-gravity" in text
    assert "Zero action" not in text
    assert "No verified submission has trained on this task in sequence yet." in page(pages, "Striker").text


def test_a_page_says_what_1_is(pages: dict[str, str]) -> None:
    assert "takes the fewest steps, −43.0." in page(pages, "State-Based-Navigation-2d-Map0-Goal0").text
    assert "the expert, −3" in page(pages, "Pusher").text


def test_a_long_table_of_references_is_folded(pages: dict[str, str]) -> None:
    folded = pages["references.html"].split('<h2 id="')[1:]
    assert [each.partition('"')[0] for each in folded if "<details>" in each] == ["navigation"]


def test_the_expert_plays(pages: dict[str, str]) -> None:
    path = task_path(task("Hopper").id)
    assert pages[path].count('<div class="stage">') == 1
    assert "play.html#" not in pages[path], "this site has no simulator"
    assert pages[path.replace(".html", "-poses.js")].startswith('watchPoses("watch-policies",')


def test_poses_of_another_policy_are_not_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    assert expert_panel(task("Hopper")) is not None
    monkeypatch.setattr("gym_extensions.references.experts.DATA", Path("nowhere"))
    assert expert_panel(task("Hopper")) is None
