"""Capacity of discrete memoryless channels, with a certificate."""

from habilis.channels.capacity import Capacity, ConvergenceWarning, capacity

__all__ = ["Capacity", "ConvergenceWarning", "capacity"]
