"""Labels and numbers as readers see them."""
