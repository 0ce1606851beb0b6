"""What the continual-learning methods add to ``trpo``: penalties, stored states, masks and heads."""
