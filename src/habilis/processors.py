"""How many threads are worth starting."""

import os


def processors() -> int:
    """How many processors this process may use; all processors where the system does not say."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
