"""A suite of three tasks of your own: trained, scored and plotted. Run `python examples/own_suite.py`.

Scores of your own tasks need references, which are measured once. `own_suite.json` has them, from the same
suite in a file: `gym-extensions maintain references --groups own_suite.toml --budget 100k --runs 1000-1001
--out own_suite.json`. Its task with a big foot is open: one of only two runs did not beat the floor.
"""

from gym_extensions import results
from gym_extensions.baselines import train
from gym_extensions.envs import Gravity, LimbScale, MotorNoise, TaskGroup, customize

light = customize("Hopper", [Gravity(0.6)])
big_foot = customize("Hopper", [LimbScale("Foot", 1.4)])
noisy = customize("Hopper", [MotorNoise(0.05)], max_steps=500)
suite = TaskGroup("own-suite", (light, big_foot, noisy))

if __name__ == "__main__":
    train("trpo", suite, "sequential", "smoke", runs=0, out="trained/own")
    scores = results.metrics("trained/own", groups=[suite], references="examples/own_suite.json")
    print(scores[["metric", "mean"]])
    results.plot_matrix(results.evaluations("trained/own", groups=[suite])).figure.savefig("trained/own.png")  # type: ignore[union-attr]
