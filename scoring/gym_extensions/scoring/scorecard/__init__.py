"""The scorecard holds one submission's metrics, intervals and notes as a typed document."""
