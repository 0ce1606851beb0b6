"""Replays recorded episodes in the simulator. The only room that loads one."""
