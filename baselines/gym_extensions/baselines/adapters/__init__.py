"""Adapters that make agents of other libraries agents of this one."""
