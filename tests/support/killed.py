"""Runs one `habilis` command in process after process, each killed at a chosen moment.

usage: killed.py FOLDER MOMENTS ARGUMENT...

A moment is NAME:N, the N-th time that something is opened, flushed to the disk, renamed or removed
in the folder, counted from the first time that NAME is part of its path; the file that is being
flushed is left half written. The last moment may be "never". Prints how each process ended.
"""

import os
import signal
import sys

from habilis.cli import main

_EVENTS = ("open", "os.rename", "os.remove", "os.mkdir")


def kill_at(folder: str, name: str, number: int) -> None:
    """Has this process killed at its n-th touch of the folder."""
    left = number
    counting = False

    def touched(path: str, descriptor: int | None = None) -> None:
        nonlocal left, counting
        if not path.startswith(folder):
            return
        counting = counting or name in path
        left -= counting
        if left == 0:
            if descriptor is not None and os.path.isfile(path):
                os.ftruncate(descriptor, os.fstat(descriptor).st_size // 2)
            os.kill(os.getpid(), signal.SIGKILL)

    def hook(event: str, arguments: tuple) -> None:
        if event in _EVENTS and isinstance(arguments[0], str | os.PathLike):
            touched(os.fspath(arguments[0]))

    def fsync(descriptor: int) -> None:
        touched(os.readlink(f"/proc/self/fd/{descriptor}"), descriptor)
        flush(descriptor)

    flush, os.fsync = os.fsync, fsync
    sys.addaudithook(hook)


if __name__ == "__main__":
    folder, moments, *arguments = sys.argv[1:]
    for moment in moments.split(","):
        child = os.fork()  # what is imported already need not be imported again
        if child == 0:
            if moment != "never":
                name, number = moment.split(":")
                kill_at(folder, name, int(number))
            os._exit(main(arguments))
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        print(moment, status, sorted(os.listdir(folder)) if os.path.isdir(folder) else None)
        if status != -signal.SIGKILL:
            break
