"""From logs to numbers: reads submissions, checks them, scores them. Loads no simulator and no torch."""
