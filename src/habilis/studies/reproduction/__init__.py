"""The whole paper recomputed by one call, and the report of it."""
