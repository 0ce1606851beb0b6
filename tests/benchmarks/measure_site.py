"""Measures the build of the site at scale: processor time, memory and sizes.

    python tests/benchmarks/measure_site.py [--entries 1000] [--out FOLDER] [--one-more]

Synthetic entries with training curves on the four gravity groups are written as scorecards first; their making
is not measured. Then the site is built in this process, and with ``--one-more`` again with one entry more.
"""

from __future__ import annotations

import argparse
import resource
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import msgspec
from synthetic_entries import REFERENCES, entries

from gym_extensions.scoring.pipeline.score import references_info
from gym_extensions.scoring.scorecard.model import Scorecard
from gym_extensions.site.build import build_site

LARGEST_PAGE = 300_000
LARGEST_OVERVIEW = 40_000


def read(files: Sequence[Path]) -> Iterator[Scorecard]:
    """The scorecards of these files, one at a time."""
    for file in files:
        yield msgspec.json.decode(file.read_bytes(), type=Scorecard)


def measured(files: Sequence[Path], out: Path) -> None:
    """Builds the site and prints what it took."""
    before = time.process_time()
    built = build_site(read(files), references_info(REFERENCES), out)
    seconds = time.process_time() - before
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(f"{len(files)} entries: {seconds:.1f} s of processor time, peak {peak:.2f} GB, {built.written} written")


def sizes(out: Path) -> int:
    """Prints the largest pages; 1 if one is above its limit."""
    pages = sorted(out.rglob("*.html"), key=lambda page: -page.stat().st_size)
    for page in pages[:5]:
        print(f"{page.stat().st_size:>8} B  {page.relative_to(out)}")
    overview = (out / "index.html").stat().st_size
    total = sum(file.stat().st_size for file in out.rglob("*") if file.is_file())
    print(f"{overview:>8} B  index.html; {total / 1e6:.0f} MB in all")
    return int(pages[0].stat().st_size > LARGEST_PAGE or overview > LARGEST_OVERVIEW)


def main() -> int:
    """Measures, prints, and returns 1 if a page is too large."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--entries", type=int, default=1000)
    options.add_argument("--out", type=Path, default=None, help="where to leave the site")
    options.add_argument("--one-more", action="store_true", help="build again with one entry more")
    chosen = options.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        files = []
        for card in entries(chosen.entries):
            files.append(Path(folder) / f"{card.name}.json")
            files[-1].write_bytes(msgspec.json.encode(card))
        out = chosen.out or Path(folder) / "site"
        measured(files, out)
        if chosen.one_more:
            (last,) = read(files[-1:])
            more = Path(folder) / "one-more.json"
            more.write_bytes(msgspec.json.encode(replace(last, name="one-more", title="One more")))
            measured([*files, more], out)
        return sizes(out)


if __name__ == "__main__":
    sys.exit(main())
