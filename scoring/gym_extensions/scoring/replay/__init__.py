"""Replays recorded episodes in the simulator. The only subpackage that loads one."""
