"""What can differ between a task and its base: one module per kind of variation."""
