"""What the box of ``train --isolated`` costs: processor time of whole runs, inside against outside.

    python -m tools.benchmarks.measure_box [--group hopper-gravity] [--budget 300k] [--pairs 1]

Three agents are trained in turn, outside and inside: the hill climber of docs/submit.md, ``trpo``, and the
PPO of Stable-Baselines3. Each figure is the processor time of world and guest, as the run's document states
it. Run it as an ordinary user on a machine that does nothing else; root may not start a box.
"""

from __future__ import annotations

import argparse
import json
import re
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PPO = """
from stable_baselines3 import PPO
from gym_extensions.baselines import sb3

ppo = sb3(PPO, n_steps=80, batch_size=50)
"""


def cpu_seconds(agent: str, folder: str, group: str, budget: str, *, isolated: bool) -> float:
    """Processor time in seconds of one run of one group by an agent, whose file is in the folder."""
    with tempfile.TemporaryDirectory() as temporary:
        out = Path(temporary, "measured")
        module, colon, factory = agent.partition(":")
        name = f"{module}.py:{factory}" if isolated and colon else agent
        options = ["--groups", group, "--budget", budget, "--out", str(out), "--quiet"]
        command = [sys.executable, "-m", "gym_extensions", "train", name, *options]
        subprocess.run(command + ["--isolated"] * isolated, check=True, stdout=subprocess.DEVNULL, cwd=folder)
        (document,) = out.rglob("run*.json")
        return float(json.loads(document.read_text(encoding="utf-8"))["cpu_seconds"])


def main() -> int:
    """Prints a table: a row per agent, and their total."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--group", default="hopper-gravity")
    parser.add_argument("--budget", default="300k")
    parser.add_argument("--pairs", type=int, default=1)
    args = parser.parse_args()
    page = (ROOT / "docs/submit.md").read_text(encoding="utf-8")
    climber = re.findall(r"```python\n(.*?)```", page, re.DOTALL)[0]
    agents = {
        "hill climber": "climber:HillClimber",
        "trpo": "trpo",
        "PPO of Stable-Baselines3": "sb3_ppo:ppo",
    }
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "climber.py").write_text(climber, encoding="utf-8")
        Path(folder, "sb3_ppo.py").write_text(PPO, encoding="utf-8")
        sums = [0.0, 0.0]
        sys.stdout.write("| agent | outside, s | inside, s | cost |\n|---|---:|---:|---:|\n")
        for name, agent in agents.items():
            pairs = [
                [cpu_seconds(agent, folder, args.group, args.budget, isolated=box) for box in (False, True)]
                for _ in range(args.pairs)
            ]
            medians = [statistics.median(each) for each in zip(*pairs, strict=True)]
            sums = [total + each for total, each in zip(sums, medians, strict=True)]
            sys.stdout.write(row(name, *medians))
            sys.stdout.flush()
        sys.stdout.write(row("total", *sums))
    return 0


def row(name: str, outside: float, inside: float) -> str:
    return f"| {name} | {outside:.1f} | {inside:.1f} | {100 * (inside / outside - 1):+.0f} % |\n"


if __name__ == "__main__":
    sys.exit(main())
