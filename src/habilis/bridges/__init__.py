"""Models that others wrote, as tables."""
