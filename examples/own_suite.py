"""A suite of three tasks of your own: trained, scored and plotted. Run `python examples/own_suite.py`.

Scores of own tasks need own references, measured once. `own_suite.json` was made from the same suite in a file:
`gym-extensions reference --groups own_suite.toml --budget 100k --runs 1000-1001 --out own_suite.json`.
"""

from gym_extensions import results
from gym_extensions.baselines import train
from gym_extensions.envs import Gravity, LimbScale, MotorNoise, TaskGroup, customize

light = customize("Hopper", [Gravity(0.6)])
big_foot = customize("Hopper", [LimbScale("Foot", 1.4)])
noisy = customize("Hopper", [MotorNoise(0.05)], max_steps=500)
suite = TaskGroup("own-suite", (light, big_foot, noisy))

if __name__ == "__main__":
    train("trpo", suite, "sequential", "smoke", runs=[0, 1], out="trained/own-suite")
    references = __file__.replace(".py", ".json")
    print(results.metrics("trained/own-suite", groups=[suite], references=references).to_string())
    evaluations = results.evaluations("trained/own-suite", groups=[suite])
    results.plot_matrix(evaluations).figure.savefig("trained/own-suite.png")
