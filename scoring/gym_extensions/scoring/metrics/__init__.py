"""From returns to metrics: one formula per metric."""
