"""Trust region policy optimization (Schulman et al. 2015) as small pure functions of flat vectors."""
