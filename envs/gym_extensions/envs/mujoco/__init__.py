"""The base bodies, as Gymnasium's MuJoCo classes with the models of our tasks."""
