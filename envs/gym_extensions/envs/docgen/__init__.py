"""What each task is, in words and numbers: printed by ``envs show``, written as pages by ``envs docs``."""
