"""What the committed submissions show: the pages findings and reproduction of docs/."""
