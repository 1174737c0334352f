"""Steps for worker processes of tests."""

import sys
import time


def prepare(background):
    pass


def echo(value):
    return value


def forever():
    while True:
        time.sleep(0.1)


def die():
    sys.exit(3)


def fail():
    raise ValueError("two\nlines")


STEPS = {one.__name__: one for one in (echo, forever, die, fail)}
