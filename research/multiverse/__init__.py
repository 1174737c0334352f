"""The second part of the report: what the paper's claims depend on."""
