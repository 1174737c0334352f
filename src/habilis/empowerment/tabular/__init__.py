"""Algorithms for tables: counting, beliefs, open-loop channels, persistence."""
