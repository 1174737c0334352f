"""Measuring in a process of its own, bound to one processor.

python -m habilis.benchmarks.apart MODULE FUNCTION
"""

import json
import os
import subprocess
import sys
from importlib import import_module

from habilis.benchmarks import Result


def measured_apart(module: str, function: str, **environment: str) -> list[Result]:
    """The result of a function in a new process on one processor.

    Args:
        module, function: without arguments, it returns results.
        environment: variables that the process has besides ours.
    """
    command = [sys.executable, "-m", __name__, module, function]
    variables = os.environ | environment
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, env=variables)
    return [Result(**line) for line in json.loads(done.stdout)]


def main(module: str, function: str) -> None:
    if hasattr(os, "sched_setaffinity"):  # elsewhere there is no way to ask for it
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    results = getattr(import_module(module), function)()
    print(json.dumps([result.as_dict() for result in results]))


if __name__ == "__main__":
    main(*sys.argv[1:])
