"""Measures how long many submissions take to score.

    python -m tools.benchmarks.measure_speed [--submissions 1000] [--distinct 1000] [--workers N]

Each submission has four groups, five runs of two protocols, training curves and policies. Returns are
synthetic and differ between submissions. ``--distinct`` submissions are written, and linked in turn under
``--submissions`` names. They are scored with synthetic references into scorecards and boards. A thousand
distinct submissions need 2 GB of temporary files and some minutes to write.
"""

import argparse
import importlib.util
import os
import random
import resource
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.references import Expert, Floor, Reference, References
from gym_extensions.scoring.pipeline import Scorer, publish, scorecards

GROUP_NAMES = ("hopper-gravity", "walker2d-gravity", "halfcheetah-gravity", "humanoid-gravity")


def write(root: Path, seed: int) -> None:
    """Writes one submission into ``root/<seed>`` as the tests do."""
    path = Path(__file__).parents[2] / "tests" / "conftest.py"
    spec = importlib.util.spec_from_file_location("made_up", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    rng = random.Random(seed)
    level = rng.gauss(400, 100)
    shift = [rng.gauss(level, 50) for _ in range(5)]
    module.write_submission(
        root,
        name=str(seed),
        groups=GROUP_NAMES,
        runs=tuple(range(5)),
        curves=10,
        value=lambda protocol, run, stage, position, episode: shift[run] + rng.gauss(0, 100),
    )


def link(source: Path, target: Path) -> None:
    """The files of a folder under another path, as hard links."""
    for path in source.rglob("*"):
        if path.is_file():
            copy = target / path.relative_to(source)
            copy.parent.mkdir(parents=True, exist_ok=True)
            os.link(path, copy)


def measure(
    folders: Sequence[Path], scorer: Scorer, workers: int | None, out: Path
) -> tuple[float, float, float]:
    """Seconds to score the folders, seconds to write scorecards and boards, and processor time of both."""
    start, before = time.perf_counter(), sum(os.times()[:4])
    cards = list(scorecards(folders, scorer, workers))
    for card in cards:
        if card.problems:
            raise ValueError(card.problems[0])
    scored = time.perf_counter()
    publish(out, cards, scorer.references)
    return scored - start, time.perf_counter() - scored, sum(os.times()[:4]) - before


def main() -> None:
    """Writes the submissions, scores them and prints the times."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--submissions", type=int, default=1000)
    parser.add_argument("--distinct", type=int, default=1000, help="submissions with different returns")
    parser.add_argument("--workers", type=int, help="worker processes, as in score --jobs")
    args = parser.parse_args()
    tasks = {
        task: Reference(Floor(0.0), Expert(1000.0)) for name in GROUP_NAMES for task in GROUPS[name].task_ids
    }
    references = References("synthetic", tasks, "0" * 64)
    with tempfile.TemporaryDirectory() as temporary:
        root = Path(temporary)
        distinct = min(args.distinct, args.submissions)
        with ProcessPoolExecutor(args.workers) as pool:
            list(pool.map(partial(write, root), range(distinct)))
        folders = [root / "submissions" / f"submission{number:04}" for number in range(args.submissions)]
        for number, folder in enumerate(folders):
            link(root / str(number % distinct), folder)
        scoring, boards, processor = measure(folders, Scorer(references), args.workers, root / "out")
    sys.stdout.write(
        f"{len(folders)} submissions: scored in {scoring:.1f} s, boards in {boards:.1f} s, "
        f"{processor:.1f} s of processor time\n"
    )
    peaks = (
        resource.getrusage(who).ru_maxrss // 1024 for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )
    sys.stdout.write("peak memory: {} MiB in the parent, {} MiB in the largest worker\n".format(*peaks))


if __name__ == "__main__":
    main()
