"""The second part of the report: the paper's claims under other choices."""
