"""The paper: its numbers and statements, as published and as recomputed, and their verdicts."""
