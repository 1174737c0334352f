"""Empowerment in the reward: shaping, and tables of it that are computed once."""
