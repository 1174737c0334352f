"""Estimators that learn one network for all states; they need the extra `habilis[robots]`."""
