"""How much memory there is, and how much a process took."""

import os
import resource
import sys
from pathlib import Path

_GROUP = Path("/sys/fs/cgroup")  # where Linux says what a container may use


def available_memory() -> int:
    """Bytes that new processes can take without others having to make room."""
    free = os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    meminfo = Path("/proc/meminfo")
    if meminfo.exists():  # counts what the system keeps only until someone needs the room
        sizes = dict(line.split(":") for line in meminfo.read_text().splitlines())
        free = int(sizes["MemAvailable"].split()[0]) * 1024
    limit, used = _GROUP / "memory.max", _GROUP / "memory.current"
    if limit.exists() and used.exists() and limit.read_text().strip() != "max":
        free = min(free, int(limit.read_text()) - int(used.read_text()))
    return max(0, free)


def peak_memory() -> int:
    """Bytes that this process has taken at most."""
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit
