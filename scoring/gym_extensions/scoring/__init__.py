"""Computes scores, intervals and boards from submitted rollout logs. Loads no simulator and no torch."""
