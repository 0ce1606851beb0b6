"""Trust region policy optimisation (Schulman et al. 2015) as small pure functions over flat parameter vectors."""
