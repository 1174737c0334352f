"""Searching for maps that meet a list of stated numbers."""
