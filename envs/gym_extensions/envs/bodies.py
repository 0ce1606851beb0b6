"""Maps each MuJoCo body of the catalog to the classes that implement it."""

from __future__ import annotations

from dataclasses import dataclass

from gym_extensions.envs.mujoco import humanoid, planar, pusher, striker
from gym_extensions.envs.mujoco.task_env import TaskEnv
from gym_extensions.envs.rules import arm as arm_rules
from gym_extensions.envs.rules import humanoid as humanoid_rules
from gym_extensions.envs.rules import planar as planar_rules
from gym_extensions.envs.rules.base import RulesFactory


@dataclass(frozen=True)
class Implementation:
    """The classes of a body, for the single environment and for the rules on arrays.

    Without rules, single environments are stepped in a loop.
    """

    env: type[TaskEnv]
    rules: RulesFactory | None = None


IMPLEMENTATIONS: dict[str, Implementation] = {
    "Hopper": Implementation(planar.Hopper, planar_rules.HopperRules),
    "Walker2d": Implementation(planar.Walker2d, planar_rules.Walker2dRules),
    "HalfCheetah": Implementation(planar.HalfCheetah, planar_rules.HalfCheetahRules),
    "Humanoid": Implementation(humanoid.Humanoid, humanoid_rules.HumanoidRules),
    "HumanoidStandup": Implementation(humanoid.HumanoidStandup, humanoid_rules.HumanoidStandupRules),
    "HumanoidStandupAndRun": Implementation(
        humanoid.HumanoidStandupAndRun, humanoid_rules.HumanoidStandupAndRunRules
    ),
    "Pusher": Implementation(pusher.Pusher, arm_rules.PusherRules),
    "Striker": Implementation(striker.Striker, arm_rules.StrikerRules),
}
"""One entry per body of the catalog that has a MuJoCo model."""


def implementation(base: str) -> Implementation:
    """Returns the classes of a body. Raises ``ValueError`` for a body without an entry."""
    if base not in IMPLEMENTATIONS:
        raise ValueError(f"The body {base!r} has no entry in gym_extensions.envs.bodies.IMPLEMENTATIONS.")
    return IMPLEMENTATIONS[base]
