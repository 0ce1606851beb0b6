"""False alarms and power of the test of an author's claim, from the committed runs on the core.

    python -m tools.benchmarks.measure_claims

Of every method, 4,000 honest submissions of five runs are compared with five others, drawn per group without
replacement; and submissions whose scores are raised.
"""

import numpy as np

from gym_extensions.catalog.groups import CORE, CORES
from gym_extensions.metrics.formulas import FINAL
from gym_extensions.scoring.pipeline import find_submissions, make_scorer
from gym_extensions.scoring.submission.core_score import claim_of, core_logs
from tools import ROOT, argument_parser

SIMULATED, RUNS, RAISED = 4000, 5, (0.0, 0.03, 0.10, 0.15)


def main() -> None:
    """Prints a table: a row per method, a column per raise."""
    argument_parser("tools.benchmarks.measure_claims", __doc__).parse_args()
    rng = np.random.default_rng(0)
    head = " | ".join(f"+{each:.2f}" for each in RAISED)
    print(f"| method | runs | {head} |\n|---|---:|{'---:|' * len(RAISED)}")
    scorer = make_scorer(only=("core",))
    for folder in find_submissions(ROOT / "submissions"):
        logs = core_logs(scorer(folder))
        values = [np.array(log.metrics[FINAL.name].runs) for log in logs.values()]
        if len(logs) < len(CORES[CORE]) or min(map(len, values)) < 2 * RUNS:
            continue
        refused = np.zeros(len(RAISED))
        for _ in range(SIMULATED):
            drawn = [rng.permutation(each)[: 2 * RUNS] for each in values]
            for at, raised in enumerate(RAISED):
                pairs = [((each[:RUNS] + raised).tolist(), each[RUNS:].tolist()) for each in drawn]
                refused[at] += not claim_of(pairs).agrees
        cells = " | ".join(f"{each / SIMULATED:.3f}" for each in refused)
        print(f"| `{folder.name}` | {min(map(len, values))} | {cells} |", flush=True)


if __name__ == "__main__":
    main()
