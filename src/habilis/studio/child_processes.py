"""Processes of a studio: modules of ours, whatever files lie in the working directory."""

import os
import sys
from pathlib import Path


def command(module: str, *arguments: str) -> list[str]:
    """The command that runs a module.

    Python would look in the working directory first, where a file json.py of the user's is not
    the json of our libraries. It does so only where it has found us there, too.
    """
    here = Path(__file__).resolve().parents[2] == Path.cwd()
    return [sys.executable, *([] if here else ["-P"]), "-m", module, *arguments]


def find_last_in_working_directory() -> None:
    """Lets modules of tools be found in the working directory, after all that is installed."""
    sys.path.append(os.getcwd())
