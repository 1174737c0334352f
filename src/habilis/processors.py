"""How many threads are worth starting."""

import os


def processors() -> int:
    """How many processors this process may use; not every system tells, then all there are."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
