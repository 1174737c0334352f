"""Capacity of discrete memoryless channels, with a certificate."""
