"""The documentation of the environments: printed by ``envs show``, written as pages by ``envs docs``."""
