"""Measures how long many submissions take to score.

    python -m tools.benchmarks.measure_speed [--submissions 1000] [--distinct 1000] [--workers N]

Each submission has four groups, five runs of two protocols, training curves and policies. Returns are
synthetic and differ between submissions. ``--distinct`` submissions are written, and linked in turn under
``--submissions`` names. They are scored with synthetic references into scorecards and boards. A thousand
distinct submissions need 2 GB of temporary files and some minutes to write.
"""

import os
import random
import resource
import runpy
import shutil
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.references import Expert, Floor, Reference, References
from gym_extensions.scoring.pipeline import Scorer, publish, scorecards
from tools import ROOT, argument_parser

GROUP_NAMES = ("hopper-gravity", "walker2d-gravity", "halfcheetah-gravity", "humanoid-gravity")


def write(root: Path, seed: int) -> None:
    """Writes one submission into ``root/<seed>`` as the tests do."""
    write_submission = runpy.run_path(str(ROOT / "tests/conftest.py"))["write_submission"]
    rng = random.Random(seed)
    level = rng.gauss(400, 100)
    shift = [rng.gauss(level, 50) for _ in range(5)]
    write_submission(
        root,
        name=str(seed),
        groups=GROUP_NAMES,
        runs=tuple(range(5)),
        curves=10,
        value=lambda protocol, run, stage, position, episode: shift[run] + rng.gauss(0, 100),
    )


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
    parser = argument_parser("tools.benchmarks.measure_speed", __doc__)
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
            shutil.copytree(root / str(number % distinct), folder, copy_function=os.link)
        scoring, boards, processor = measure(folders, Scorer(references), args.workers, root / "out")
    print(f"{len(folders)} submissions: scored in {scoring:.1f} s, boards in {boards:.1f} s, ", end="")
    print(f"{processor:.1f} s of processor time")
    parent, worker = (
        resource.getrusage(who).ru_maxrss // 1024 for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )
    print(f"peak memory: {parent} MiB in the parent, {worker} MiB in the largest worker")


if __name__ == "__main__":
    main()
