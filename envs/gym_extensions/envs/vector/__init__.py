"""Many copies of tasks as arrays over lanes: physics, rules of each body family, the vector environment."""
