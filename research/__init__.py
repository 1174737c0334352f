"""Computations that take hours, with their results: run from a clone, not installed."""
