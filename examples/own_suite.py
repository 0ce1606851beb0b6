"""A suite of three tasks of your own: trained, scored and plotted. `python examples/own_suite.py`"""

from gym_extensions import results
from gym_extensions.baselines import train
from gym_extensions.envs import Gravity, LimbScale, MotorNoise, TaskGroup, customize

light = customize("Hopper", [Gravity(0.3)])
big_foot = customize("Hopper", [LimbScale("Foot", 1.4)])
noisy = customize("Hopper", [MotorNoise(0.05)], max_steps=500)
suite = TaskGroup("my-hoppers", (light, big_foot, noisy))

if __name__ == "__main__":
    train("trpo", suite, ["sequential", "single"], "smoke", runs=[0, 1], out="trained/my-hoppers")
    print(results.metrics("trained/my-hoppers", groups=[suite]))
    results.plot_matrix("trained/my-hoppers").figure.savefig("trained/my-hoppers.png")
