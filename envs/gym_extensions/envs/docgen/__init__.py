"""Documentation of the environments, printed by ``envs show`` and written as pages by ``envs docs``."""
