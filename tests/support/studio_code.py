"""Code of what is on the screen, run."""

import contextlib
import io
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest


def python_of(script: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[dict, str]:
    """What a script defines and prints."""
    monkeypatch.chdir(folder)
    names: dict = {}
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(script, names)
    return names, printed.getvalue()


def shell(command: str, folder: Path) -> str:
    """What a command prints."""
    (folder / "habilis").write_text(f'#!/bin/sh\nexec {sys.executable} -m habilis "$@"\n')
    (folder / "habilis").chmod(0o755)
    environment = os.environ | {"PATH": f"{folder}:{os.environ['PATH']}"}
    done = subprocess.run(
        ["bash", "-ec", command], cwd=folder, env=environment, capture_output=True, text=True
    )
    assert not done.returncode, done.stderr
    return done.stdout


def shown_grid(answer: dict) -> np.ndarray:
    return np.array(answer["landscape"], float)
