"""Agents of other libraries as agents of this one."""
