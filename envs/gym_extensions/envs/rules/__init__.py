"""Start, observation, reward and end of every MuJoCo body on arrays over environments.

One module per family. A test compares them bit for bit with Gymnasium's classes.
"""
