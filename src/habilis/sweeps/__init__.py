"""Many configurations at once: grids and searches, on one machine or many."""
