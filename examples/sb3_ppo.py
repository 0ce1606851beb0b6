"""PPO of Stable-Baselines3 with normalized observations, and a callback.

    python examples/sb3_ppo.py [BUDGET]

The statistics of the observations persist across tasks and do not change in evaluation.
"""

import sys

from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback

from gym_extensions.baselines import sb3, train


class PrintLoss(BaseCallback):
    """Prints the loss of the batch before the present one."""

    def _on_rollout_start(self) -> None:
        loss = self.model.logger.name_to_value.get("train/loss")
        if loss is not None:
            print(f"{self.num_timesteps} steps, loss {loss:.3f}")

    def _on_step(self) -> bool:
        return True


ppo = sb3(PPO, normalize_observations=True, n_steps=250, batch_size=50, callback=PrintLoss())

if __name__ == "__main__":
    budget = sys.argv[1] if len(sys.argv) > 1 else "smoke"
    train(ppo, "hopper-gravity", "sequential", budget, runs=0, out=f"trained/sb3-ppo-{budget}")
