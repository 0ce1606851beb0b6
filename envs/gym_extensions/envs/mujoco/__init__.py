"""The base bodies: Gymnasium's MuJoCo classes with the models of our tasks."""
