"""Gains of a law: searched in floats, proven by multipliers, refused by a door."""
