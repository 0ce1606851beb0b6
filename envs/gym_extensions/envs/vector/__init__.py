"""Steps many MuJoCo environments as arrays, in shards of one model layout."""
