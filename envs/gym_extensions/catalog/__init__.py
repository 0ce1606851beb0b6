"""The benchmark as data: bodies, variations, tasks, groups, budgets and the protocol. Loads no simulator."""
