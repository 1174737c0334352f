"""A worker process: it runs steps one after the other until its standard input ends.

python -m habilis.studio.worker MODULE BACKGROUND

It prints a line when it is ready. A request is its length in four bytes and a pickled (name,
arguments); an answer is a line of JSON, `{"answer": ...}` or `{"error": one line}`. Its parent may
end it at any moment.
"""

import contextlib
import json
import os
import pickle
import signal
import sys
import warnings
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import IO, Any

LENGTH = 4  # bytes
NOT_ENOUGH = "not enough memory; make the world or the horizon smaller"


def work(steps: Mapping[str, Callable[..., Any]], requests: IO[bytes], answers: IO[str]) -> None:
    """Answers requests until there are no more."""
    while length := requests.read(LENGTH):
        print(_answer(steps, requests.read(int.from_bytes(length))), file=answers, flush=True)


def _answer(steps: Mapping[str, Callable[..., Any]], request: bytes) -> str:
    try:
        name, arguments = pickle.loads(request)
        return json.dumps({"answer": steps[name](**arguments)}, allow_nan=False)
    except MemoryError:
        return json.dumps({"error": NOT_ENOUGH})
    except Exception as error:  # of any kind: it is reported to the caller, and the worker goes on
        return json.dumps({"error": str(error) or type(error).__name__})


def main(module: str, background: str) -> None:
    # Ctrl-C reaches all processes of a terminal, but only the parent decides when to end.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    warnings.simplefilter("ignore")  # the answers contain the uncertainty
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "w")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # a custom tool may print
    steps = import_module(module)
    steps.prepare(bool(int(background)))
    print(json.dumps("ready"), file=answers, flush=True)
    with contextlib.suppress(BrokenPipeError):
        work(steps.STEPS, sys.stdin.buffer, answers)


if __name__ == "__main__":
    main(*sys.argv[1:])
