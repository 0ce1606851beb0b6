"""What the box of ``train --isolated`` costs: processor time of whole runs, inside against outside.

    python -m tools.benchmarks.measure_box [--group hopper-wall] [--budget 300k]

Three agents are trained outside and inside at once, each on a core of its own, and again with the cores
exchanged: the hill climber of docs/submit.md, ``trpo``, and the PPO of Stable-Baselines3. Each figure is the
processor time of world and guest, as the run's document states it. Run it on two cores that do nothing else,
as an ordinary user; root may not start a box.
"""

import json
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from statistics import fmean

from tools import ROOT, argument_parser

PPO = """
from stable_baselines3 import PPO
from gym_extensions.baselines import sb3

ppo = sb3(PPO, n_steps=80, batch_size=50)
"""
AGENTS = {
    "hill climber": "climber.py:HillClimber",
    "`trpo`": "trpo",
    "PPO of Stable-Baselines3": "ppo.py:ppo",
}


def main() -> None:
    """Prints a table: a row per agent, and their total."""
    parser = argument_parser("tools.benchmarks.measure_box", __doc__)
    parser.add_argument("--group", default="hopper-wall")
    parser.add_argument("--budget", default="300k")
    args = parser.parse_args()
    page = (ROOT / "docs/submit.md").read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(2) as pool:
        Path(folder, "climber.py").write_text(re.findall(r"```python\n(.*?)```", page, re.DOTALL)[0])
        Path(folder, "ppo.py").write_text(PPO)

        def cpu_seconds(agent: str, core: int, box: bool) -> float:
            with tempfile.TemporaryDirectory() as temporary:
                out = Path(temporary, "measured")
                options = ["--groups", args.group, "--budget", args.budget, "--out", str(out), "--quiet"]
                train = ["taskset", "-c", str(core), sys.executable, "-m", "gym_extensions", "train", agent]
                command = [*train, *options, *["--isolated"] * box]
                subprocess.run(command, check=True, stdout=subprocess.DEVNULL, cwd=folder)
                (document,) = out.rglob("run*.json")
                return float(json.loads(document.read_text(encoding="utf-8"))["cpu_seconds"])

        print("| agent | outside, s | inside, s | more |\n|---|---:|---:|---:|")
        totals = [0.0, 0.0]
        for name, agent in AGENTS.items():
            rounds = [
                list(pool.map(cpu_seconds, (agent,) * 2, cores, (False, True))) for cores in ((0, 1), (1, 0))
            ]
            means = list(map(fmean, zip(*rounds, strict=True)))
            totals = [total + each for total, each in zip(totals, means, strict=True)]
            print(row(name, *means), flush=True)
        print(row("total", *totals))


def row(name: str, outside: float, inside: float) -> str:
    """A row of the table."""
    return f"| {name} | {outside:.1f} | {inside:.1f} | {100 * (inside / outside - 1):.0f} % |"


if __name__ == "__main__":
    main()
