"""Metrics of Continual World's own logs: `python examples/foreign_logs.py FOLDER`.

Every folder below FOLDER with `progress.tsv` and `config.json` is a run. A method's runs on the whole
sequence give its matrix of success rates, runs on a single task what forward transfer is compared with. For
other logs, change `read`: the rest needs arrays alone. Such results are not verified; no board ranks them.
"""

import json
import re
import sys
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from gym_extensions.metrics import compute

SUCCESS = re.compile(r"test/stochastic/(\d+)/(.+)/success")
LAST = 5  # evaluations of a stage that Continual World's own tables average


def read(folder: Path) -> tuple[dict[str, str], list[str], list[Any]]:
    """The settings of a run, its tasks, and per stage the success rates (evaluations, tasks)."""
    config = json.loads((folder / "config.json").read_text())
    log = pd.read_csv(folder / "progress.tsv", sep="\t")
    matches = (found for name in log if (found := SUCCESS.fullmatch(str(name))))
    columns = sorted(matches, key=lambda found: int(found[1]))
    values = log[[column[0] for column in columns]].to_numpy()
    tasks = [column[2] for column in columns]
    if "task" in config:
        return config, tasks, [values]
    return config, tasks, [values[log["train/active_env"] == stage] for stage in range(len(tasks))]


def board(folder: Path) -> pd.DataFrame:
    """One row per method, best final performance first: every metric's mean over runs."""
    matrices, areas, alone = (defaultdict[str, list[Any]](list) for _ in range(3))
    names: list[str] = []
    for path in sorted(folder.rglob("progress.tsv")):
        config, tasks, stages = read(path.parent)
        if "task" in config:
            alone[config["task"]].append((stages[0][-LAST:].mean(), stages[0].mean()))
            continue
        names, method = tasks, config.get("cl_method") or "finetuning"
        matrices[method].append([values[-LAST:].mean(axis=0) for values in stages])
        areas[method].append([values[:, at].mean() for at, values in enumerate(stages)])
    rows = {}
    for method, runs in matrices.items():
        known: dict[str, Any] = {}
        if all(task in alone for task in names):
            single, auc = np.array([np.mean(alone[task], axis=0) for task in names]).T
            known = {"single": [single] * len(runs), "auc": areas[method], "single_auc": [auc] * len(runs)}
        rows[method] = {name: value.mean for name, value in compute(runs, **known).items()}
    return pd.DataFrame.from_dict(rows, orient="index").sort_values("final_performance", ascending=False)


if __name__ == "__main__":
    if len(sys.argv) != 2 or not next(Path(sys.argv[1]).rglob("progress.tsv"), None):
        sys.exit("Name a folder with logs of Continual World: no progress.tsv is below it.")
    print(board(Path(sys.argv[1])).dropna(axis="columns").to_string())
