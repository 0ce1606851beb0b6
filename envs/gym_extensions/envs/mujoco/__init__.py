"""The base bodies: Gymnasium's MuJoCo classes, and what a body adds to them."""
