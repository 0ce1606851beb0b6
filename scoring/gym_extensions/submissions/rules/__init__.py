"""The rules of a submission are functions whose docstrings are the published text.

``RULES`` lists them all.
"""

from gym_extensions.submissions.problem import RULES, problems
from gym_extensions.submissions.rules import agent, folder, log, manifest, policies, run_document

__all__ = ["RULES", "agent", "folder", "log", "manifest", "policies", "problems", "run_document"]
