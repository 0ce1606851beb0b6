"""Takes the pictures of the README from a built site, in Chromium: ``make screenshots``.

    python docs/images/take.py _site docs/images

The board is the one with the most entries. The entry is the first of that board whose page has a Watch panel
of its group. A picture that cannot be taken stays as it is, with a message.
"""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright

NAMES = ("chromium", "chromium-browser", "google-chrome")
WIDTH, HEIGHT = 1200, 720
COLORS = 64
PLAYED = 0.4
"""The moment of the Watch panel, as a part of the longest episode."""


def boards(site: Path) -> list[dict[str, Any]]:
    """The boards of sequential training by number of entries, then in the order of the overview."""
    index = json.loads((site / "api/index.json").read_text("utf-8"))
    overview = (site / "index.html").read_text("utf-8")
    rows = [row for row in index["boards"] if row["protocol"] == "sequential" and row["entries"]]
    return sorted(rows, key=lambda row: (-row["entries"], overview.find(row["page"]) % (len(overview) + 1)))


def watched(site: Path, rows: list[dict[str, Any]]) -> Iterator[tuple[Path, str]]:
    """Page and id of every Watch panel, in the order of boards and ranks."""
    for row in rows:
        for entry in json.loads((site / row["path"]).read_text("utf-8"))["boards"][0]["rows"]:
            index = json.loads((site / "api/index.json").read_text("utf-8"))
            page = next(item["page"] for item in index["entries"] if item["name"] == entry["name"])
            folder = (site / page).with_suffix("")
            for file in (site / page, folder / f"{row['group']}.html"):
                if file.is_file() and f'data-poses="watch-{row["group"]}-sequential"' in file.read_text(
                    "utf-8"
                ):
                    yield file, row["group"]


def main(site: Path, out: Path) -> int:
    """Writes overview.png, group.png and watch.png; returns 1 if one is missing."""
    path = next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        sys.stderr.write("Chromium is not installed (on Debian: apt-get install chromium).\n")
        return 1
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, timeout=120_000, args=["--disable-gpu"])
        missing = take(browser, site.resolve(), out)
        browser.close()
    for name in missing:
        sys.stderr.write(f"{name} was not taken: the site has no page for it.\n")
    return bool(missing)


def take(browser: Browser, site: Path, out: Path) -> list[str]:
    """Takes the pictures and returns the names of those for which the site has no page."""
    page = browser.new_page(
        viewport={"width": WIDTH, "height": HEIGHT}, color_scheme="light", reduced_motion="reduce"
    )
    page.set_default_timeout(120_000)
    rows = boards(site)
    page.goto((site / "index.html").as_uri())
    save(page, out / "overview.png")
    if not rows:
        return ["group.png", "watch.png"]
    page.goto((site / rows[0]["page"]).as_uri())
    save(page, out / "group.png")
    panel = next(watched(site, rows), None)
    if panel is None:
        return ["watch.png"]
    page.goto(panel[0].as_uri())
    play(page, panel[1])
    save(page, out / "watch.png")
    return []


def play(page: Page, group: str) -> None:
    """Opens the player of the first task of a group's panel and stops at a moment with the most to see."""
    section = page.locator(f'.watch[data-poses="watch-{group}-sequential"]').first
    section.locator("button.play").click()
    time = section.get_by_role("slider")
    time.wait_for()
    time.evaluate(
        "(input, part) => { input.value = input.max * part; input.dispatchEvent(new Event('input')); }",
        PLAYED,
    )
    section.evaluate("(element) => element.previousElementSibling.scrollIntoView({ behavior: 'instant' })")


def save(page: Page, file: Path) -> None:
    """A picture of the screen with few colors, so that it is small."""
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    page.screenshot(path=file)
    with Image.open(file) as picture:
        picture.convert("RGB").quantize(COLORS).save(file, optimize=True)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), Path(sys.argv[2])))
