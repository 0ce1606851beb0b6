"""Trains agents that nobody has read, in a box: ``gym-extensions train --isolated``.

The *world* is the training loop as it is, with a :mod:`proxy` in place of the agent. The *guest* is the
stranger's file in a process of its own (:mod:`guest`), which :mod:`box` starts with what :mod:`contents`
lists and :mod:`confine` limits. Between them are two pipes (:mod:`frames`). docs/isolated.md has a picture.
"""
