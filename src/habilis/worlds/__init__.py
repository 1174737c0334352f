"""Worlds: map text -> `World` -> `TabularMDP`; the tools and their rule; pictures."""
