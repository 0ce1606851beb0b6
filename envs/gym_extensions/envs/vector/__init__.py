"""Many MuJoCo environments as arrays: physics, shards of one model layout, the vector environment."""
