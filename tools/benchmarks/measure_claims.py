"""False alarms and power of the test of an author's claim, from the committed runs on the core.

``python -m tools.benchmarks.measure_claims``: of every method, 4,000 honest submissions of five runs against
five others, drawn per group without replacement; and submissions whose scores are raised.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

from gym_extensions.catalog.groups import CORE, CORES
from gym_extensions.metrics.formulas import FINAL
from gym_extensions.scoring.pipeline import score_folder
from gym_extensions.scoring.submission.core_score import claim_of, core_logs

ROOT = Path(__file__).resolve().parents[2]
SIMULATED, RUNS, RAISED = 4000, 5, (0.0, 0.03, 0.10, 0.15)


def main() -> int:
    """Prints a table: a row per method, a column per raise."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    rng = np.random.default_rng(0)
    out = sys.stdout
    head = " | ".join(f"+{each:.2f}" for each in RAISED)
    out.write(f"| method | runs | {head} |\n|---|---:|{'---:|' * len(RAISED)}\n")
    for folder in sorted((ROOT / "submissions").iterdir()):
        card = score_folder(folder)
        logs = core_logs(card)
        values = [np.array(log.metrics[FINAL.name].runs) for log in logs.values()]
        if len(logs) < len(CORES[CORE]) or min(map(len, values)) < 2 * RUNS:
            continue
        found = np.zeros(len(RAISED))
        for _ in range(SIMULATED):
            drawn = [rng.permutation(each)[: 2 * RUNS] for each in values]
            for at, raised in enumerate(RAISED):
                pairs = [((each[:RUNS] + raised).tolist(), each[RUNS:].tolist()) for each in drawn]
                found[at] += not claim_of(pairs).agrees
        cells = " | ".join(f"{each / SIMULATED:.3f}" for each in found)
        out.write(f"| `{card.name}` | {min(map(len, values))} | {cells} |\n")
        out.flush()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
