"""Gymnasium environments made of tables."""
