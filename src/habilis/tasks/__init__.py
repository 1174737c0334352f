"""Many independent computations: kept, resumed, on local processes or a Ray cluster."""
