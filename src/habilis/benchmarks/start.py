"""The first answer: commands on small models, with an empty compile cache and then a full one.

Each runs in a process of its own, as a user would start it.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from importlib.util import find_spec
from pathlib import Path

from habilis.benchmarks import Result

_PUZZLE = """\
A  .  .  .  .  .
.  M1 M1 .  .  .
.  M0 .  .  .  G0
.  .  .  W  .  .
"""
_COMMANDS = (
    "empowerment gym:FrozenLake-v1 --horizon 3",
    "empowerment puzzle.pwp --horizon 4",
    "compare yard --horizon 3",
    "solve corridor",
    "landscape corridor --horizon 3",
    "landscape corridor --horizon 2 --slip 0.1",
)


def results() -> list[Result]:
    wall, work = _seconds(["-c", "import habilis"], ".", os.environ)
    lines = [Result("import habilis", wall, "s", f"{work:.2f} s of work")]
    for command in _COMMANDS:
        if "gym:" in command and find_spec("gymnasium") is None:
            continue
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "puzzle.pwp").write_text(_PUZZLE)
            caches = {"NUMBA_CACHE_DIR": folder, "XDG_CACHE_HOME": folder}
            for which in ("first", "second"):
                arguments = ["-m", "habilis", *command.split()]
                wall, work = _seconds(arguments, folder, os.environ | caches)
                lines.append(Result(command, wall, "s", f"{which} use, {work:.2f} s of work"))
    return lines


def _seconds(
    arguments: list[str], folder: str, environment: os._Environ | dict
) -> tuple[float, float]:
    """Seconds that pass, and those of a processor, from the start of Python to its end."""
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    command = [sys.executable, *arguments]
    subprocess.run(command, cwd=folder, env=environment, check=True, stdout=subprocess.DEVNULL)
    wall, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
