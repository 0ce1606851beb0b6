"""The scorecard: one submission's metrics, intervals and notes as a typed document."""
