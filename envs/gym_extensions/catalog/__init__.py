"""What is varied, as data: variations, tasks, groups and the protocol's numbers. Loads no simulator."""
