"""Exact cases that estimators are held against, and what comes of it."""
