"""The rules of a submission are functions whose docstrings are the published text.

``RULES`` lists them all.
"""

from gym_extensions.rollouts.problem import RULES, problems
from gym_extensions.rollouts.rules import document, folder, log, manifest, policies

__all__ = ["RULES", "document", "folder", "log", "manifest", "policies", "problems"]
