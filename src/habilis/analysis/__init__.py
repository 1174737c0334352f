"""Measures made of empowerment: averages, landscapes, pairs, influence, futures; their pictures."""
