"""Measures the build of the site at scale: processor time, memory and sizes.

    python -m tools.benchmarks.measure_site [--submissions 1000] [--out FOLDER] [--browser]

Synthetic submissions with training curves on the four gravity groups are written as scorecards first; making
them is not measured. Then the site is built in this process.
``--browser`` sorts and filters its longest table in Chromium (Linux only).
"""

import resource
import shutil
import statistics
import sys
import tempfile
import time
from pathlib import Path

import msgspec
import numpy as np

from gym_extensions.catalog.groups import SUITES, group
from gym_extensions.references import Expert, Floor, Reference, References
from gym_extensions.scoring.scorecard import ManifestSummary, Scorecard
from gym_extensions.scoring.submission.normalization import GroupReturns
from gym_extensions.scoring.submission.scorer import completed, score_group
from gym_extensions.scoring.submission.suites import suite_scores
from gym_extensions.site.build import build_site
from gym_extensions.site.pages import PAGES
from gym_extensions.site.pages.page import Render
from gym_extensions.submissions.manifest import Code, Observes, Protocol, Tuning
from gym_extensions.submissions.review import CLAIMED, VERIFIED
from gym_extensions.submissions.run import Memory
from tools import argument_parser

LARGEST_PAGE = 300_000
LARGEST_OVERVIEW = 40_000
GROUPS = SUITES["gravity"]
BUDGET, STEPS, POINTS = "100k", 100_000, 50
RUNS, EPISODES = 5, 20
SPAN = 1000.0
"""Expert of every task; the floor is 0."""

REFERENCES = References(
    "synthetic",
    tasks={task: Reference(Floor(0.0), Expert(SPAN)) for name in GROUPS for task in group(name).task_ids},
)


def submission(number: int, rng: np.random.Generator) -> Scorecard:
    """The scorecard of a submission with sequential runs; every tenth has two, the others five."""
    strength, keeps = rng.uniform(0.05, 1.2), rng.uniform(0.6, 1.02)
    groups = {}
    for group_id in GROUPS:
        returns = group_returns(group_id, strength, keeps, RUNS if number % 10 else 2, rng)
        groups[group_id] = {"sequential": score_group(returns, REFERENCES, "sequential", BUDGET)}
    algorithm = ("TRPO", "PPO", "SAC", "EWC")[int(rng.integers(4))]
    level, is_aware = VERIFIED if rng.random() < 0.3 else CLAIMED, bool(rng.random() < 0.1)
    manifest = ManifestSummary(
        authors=("A. Researcher",),
        description="A synthetic submission.",
        code=Code("", ""),
        protocol=Protocol(BUDGET, algorithm, "sampled"),
        hyperparameters={"step_size": 0.01},
        observes=Observes(task_in_training=is_aware, task_in_evaluation=False, boundaries=is_aware),
        tuning=Tuning(0, ()),
        memory=Memory(stored_steps=2000, parameters_first=12345, parameters_last=12345),
    )
    return Scorecard(
        name=f"submission-{number:04d}",
        title=f"{algorithm} variant {number:04d}",
        level=level,
        manifest=manifest,
        groups=groups,
        suites=suite_scores(groups),
    )


def group_returns(
    group_id: str, strength: float, keeps: float, runs: int, rng: np.random.Generator
) -> GroupReturns:
    """Returns of an agent that reaches a share of the expert and keeps a share of that per later stage."""
    members = group(group_id)
    tasks = len(members.tasks)
    reached = strength * SPAN * (1 + 0.15 * rng.standard_normal((runs, 1, tasks)))
    age = np.arange(tasks + 1)[:, None] - np.arange(1, tasks + 1)
    level = np.where(age >= 0, keeps ** np.maximum(age, 0), 0.1) * reached
    returns = level[..., None] + 40 * rng.standard_normal((runs, tasks + 1, tasks, EPISODES))
    steps = [STEPS // POINTS * (point + 1) for point in range(POINTS)]
    rise = 1 - np.exp(-np.arange(1, POINTS + 1) / 15)
    curves = {
        ("sequential", run, task): (steps, (reached[run, 0, at] * rise + 30 * noise).tolist())
        for run in range(runs)
        for at, task in enumerate(members.task_ids)
        for noise in [rng.standard_normal(POINTS)]
    }
    return GroupReturns(
        members, STEPS, {"sequential": tuple(range(runs))}, {"sequential": returns.tolist()}, curves
    )


def sizes(out: Path) -> int:
    """Prints the largest pages; 1 if one is above its limit."""
    pages = sorted(out.rglob("*.html"), key=lambda page: -page.stat().st_size)
    for page in pages[:5]:
        print(f"{page.stat().st_size:>8} B  {page.relative_to(out)}")
    overview = (out / "index.html").stat().st_size
    total = sum(file.stat().st_size for file in out.rglob("*") if file.is_file())
    print(f"{overview:>8} B  index.html; {total / 1e6:.0f} MB in all")
    return int(pages[0].stat().st_size > LARGEST_PAGE or overview > LARGEST_OVERVIEW)


PAINTED = """(act) => new Promise((done) => {
  const begin = performance.now();
  act();
  requestAnimationFrame(() => {
    const { port1, port2 } = new MessageChannel();
    port1.onmessage = () => done(performance.now() - begin);
    port2.postMessage(0);
  });
})"""
"""Milliseconds from an event to the frame after it."""
ACTIONS = {
    "sort": "() => document.querySelector('[data-key=final_performance] .sort').click()",
    "search": """() => {
      const field = document.querySelector("input[type=search]");
      field.value = field.value ? "" : "ppo";
      field.dispatchEvent(new Event("input"));
    }""",
}


def interactions(out: Path) -> None:
    """Prints how long sorting and searching a table take until the next frame, with 50 rows and with all."""
    from playwright.sync_api import sync_playwright

    table = max((out / "boards").glob("*.html"), key=lambda page: page.stat().st_size)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1300, "height": 900})
        for rows, fragment in (("50 rows", ""), ("all rows", "#?all=1")):
            page.goto("about:blank")
            page.goto(f"{table.resolve().as_uri()}{fragment}")
            processes = browser.new_browser_cdp_session().send("SystemInfo.getProcessInfo")["processInfo"]
            pages = [process["id"] for process in processes if process["type"] == "renderer"]
            for name, action in ACTIONS.items():
                cpu, wall = [], []
                for _ in range(10):
                    page.wait_for_timeout(3000 if fragment else 300)  # until all rows are there
                    before = [_main_thread(each) for each in pages]
                    wall.append(page.evaluate(f"({PAINTED})({action})"))
                    cpu.append(max(_main_thread(each) - old for each, old in zip(pages, before, strict=True)))
                for kind, values in (("processor time", cpu), ("elapsed", wall)):
                    median, most = statistics.median(values), max(values)
                    print(f"{name}, {rows}, {kind}: {median:.0f} ms, at most {most:.0f} ms")
        browser.close()


def _main_thread(process: int) -> float:
    """Milliseconds of processor time that the main thread of a process has used."""
    return int(Path(f"/proc/{process}/task/{process}/schedstat").read_text().split()[0]) / 1e6


def main() -> int:
    """Measures, prints, and returns 1 if a page is too large."""
    parser = argument_parser("tools.benchmarks.measure_site", __doc__)
    parser.add_argument("--submissions", type=int, default=1000)
    parser.add_argument("--out", type=Path, default=None, help="where to leave the site")
    parser.add_argument("--browser", action="store_true", help="also measure the longest table in Chromium")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        files = [Path(folder) / f"{number}.json" for number in range(options.submissions)]
        rng = np.random.default_rng(0)
        for number, file in enumerate(files):
            file.write_bytes(msgspec.json.encode(submission(number, rng)))
        cards = (completed(msgspec.json.decode(file.read_bytes(), type=Scorecard)) for file in files)
        out, before = options.out or Path(folder) / "site", time.process_time()
        build_site(cards, Render(REFERENCES, PAGES), out)
        seconds = time.process_time() - before
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
        print(f"{len(files)} submissions: {seconds:.1f} s, peak {peak:.2f} GB")
        if options.browser:
            interactions(out)
        return sizes(out)


if __name__ == "__main__":
    sys.exit(main())
