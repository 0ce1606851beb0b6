"""Measures sorting, filtering and searching the table of all rows in Chromium.

    python tests/benchmarks/measure_table.py [--entries 1000]

The entries are those of ``measure_site.py``, on one group. Printed is the median of five times, from
the event until the page is laid out again, and which part of it the script took.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

from measure_site import REFERENCES, entries
from playwright.sync_api import sync_playwright

from gym_extensions.scoring.pipeline.score import references_info
from gym_extensions.site.build import Site
from gym_extensions.site.page import Draft, pages

GROUP = "hopper-gravity-v0"
TIMES = """async () => {
  const search = document.querySelector("input[type=search]"), runs = document.querySelector(".tools select");
  const [sort] = document.querySelectorAll("th[data-key=forgetting] .sort");
  const type = (text) => { search.value = text; search.dispatchEvent(new Event("input")); };
  const choose = (text) => { runs.value = text; runs.dispatchEvent(new Event("change")); };
  const actions = { sort: () => sort.click(), search: () => type("entry-01"), filter: () => choose("5") };
  const times = {};
  for (const [name, act] of Object.entries(actions)) {
    const all = [];
    for (let round = 0; round < 5; round += 1) {
      type(""); choose(""); document.body.offsetHeight;
      await new Promise((done) => setTimeout(done, 50));
      const start = performance.now();
      act();
      const acted = performance.now();
      document.body.offsetHeight;
      all.push([performance.now() - start, acted - start]);
    }
    times[name] = all.sort((a, b) => a[0] - b[0])[2];
  }
  return times;
}"""


def write(folder: Path, count: int) -> Path:
    """Writes the boards of one group and returns the page of all rows."""
    groups = [
        replace(card, groups={name: score for name, score in card.groups.items() if name == GROUP}, suites={})
        for card in entries(count)
    ]
    kinds = tuple(page for page in pages() if page.title == "Boards")
    largest = folder
    for path, content in Site(references_info(REFERENCES), None, kinds).files(groups):
        target = folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        text = content.write() if isinstance(content, Draft) else content
        target.write_bytes(text.encode() if isinstance(text, str) else text)
        if path.endswith("-all.html"):
            largest = target
    return largest


def main(count: int) -> None:
    """Prints the times."""
    path = shutil.which("chromium") or shutil.which("google-chrome")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        file = write(Path(folder), count)
        browser = playwright.chromium.launch(executable_path=path, timeout=120_000)
        page = browser.new_page()
        page.goto(file.as_uri())
        times = page.evaluate(TIMES)
        browser.close()
    rows = ", ".join(
        f"{name} {whole:.0f} ms (script {script:.0f})" for name, (whole, script) in times.items()
    )
    sys.stdout.write(f"{count} rows: {rows}\n")


if __name__ == "__main__":
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--entries", type=int, default=1000)
    main(options.parse_args().entries)
