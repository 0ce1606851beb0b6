"""One submission: from its returns and curves to the numbers of its scorecard."""
