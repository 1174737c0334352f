"""Everything computes where nothing can be kept."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from disks import mounted

import habilis as hb
from habilis.cache import cache_folder, kept

PACKAGE = Path(hb.__file__).parent

MAIN = ["-m", "habilis"]
COMPUTE = """
import habilis as hb
import habilis.compiled
habilis.compiled.INTERPRETED = 0  # compile everything
from habilis.rewards.cached_tables import kept_empowerment
from habilis.empowerment.tabular.persistence import persistence
assert hb.__file__.startswith({place!r}), hb.__file__
mdp = hb.tabulate(hb.World.parse("AP.CG\\n.....\\n"))
print(*hb.empowerment(mdp, 2, "object")[:40].round(9))
print(*kept_empowerment(mdp, 2)[:40].round(9))
print(*hb.empowerment(mdp, 2, list(range(mdp.states)), states=[0]).round(9))
print(*hb.empowerment(mdp.slippery(0.2), 1, "object", states=[0, 9]).round(5))
print(*persistence(mdp, "object")[:9].round(9))
"""


def computed(environment: dict[str, str], package: Path) -> subprocess.CompletedProcess:
    """The output of a process with this package and this environment."""
    code = COMPUTE.format(place=str(package))
    return run(["-W", "error", "-c", code], environment | {"PYTHONPATH": str(package)})


def run(arguments: list[str], environment: dict[str, str]) -> subprocess.CompletedProcess:
    """A process of Python that knows of no caches but what its environment says."""
    unset = ("XDG_CACHE_HOME", "NUMBA_CACHE_DIR", "JAX_COMPILATION_CACHE_DIR", "HOME", "PYTHONPATH")
    clean = {name: value for name, value in os.environ.items() if name not in unset}
    command = [sys.executable, *arguments]
    return subprocess.run(command, env=clean | environment, capture_output=True, text=True)


@pytest.fixture(scope="module")
def usual():
    """The output with a home and a cache."""
    done = computed({"HOME": os.environ["XDG_CACHE_HOME"]}, PACKAGE.parent)
    assert done.returncode == 0, done.stderr
    return done.stdout


def copy_of_package(place: Path) -> None:
    ignored = shutil.ignore_patterns("__pycache__", "page")
    shutil.copytree(PACKAGE, place / "habilis", ignore=ignored)


def test_a_read_only_installation_without_a_home_computes_everything(tmp_path, usual):
    disk = tmp_path / "disk"
    with mounted(disk, "size=64m"):
        copy_of_package(disk)
        subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
        done = computed({"HOME": str(disk / "home")}, disk)
        assert (done.returncode, done.stderr) == (0, "")
        assert done.stdout == usual
        command = ["train", "yard", "--runs", "1", "--steps", "1", "--out", str(tmp_path / "run")]
        trained = run([*MAIN, *command], {"HOME": str(disk / "home"), "PYTHONPATH": str(disk)})
        assert (trained.returncode, trained.stderr) == (0, "")
        assert (tmp_path / "run" / "summary.json").is_file()


def test_a_full_disk_for_what_is_compiled_is_no_error(tmp_path, usual):
    disk = tmp_path / "disk"
    with mounted(disk, "size=8k"):
        (disk / "filled").write_bytes(b"x" * 4096)
        places = {"NUMBA_CACHE_DIR": str(disk), "XDG_CACHE_HOME": str(disk)}
        done = computed(places, PACKAGE.parent)
        assert (done.returncode, done.stderr) == (0, "")
        assert done.stdout == usual


def test_a_user_without_a_home_keeps_nothing(monkeypatch):
    def homeless():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setattr(Path, "home", homeless)
    assert cache_folder() is None
    for value in (1, 2):
        assert kept("name", lambda value=value: {"x": np.array(value)})["x"] == value


def test_everything_is_compiled_through_one_place():
    sources = [path for path in PACKAGE.rglob("*.py") if path.name != "compiled.py"]
    assert not [path for path in sources if re.search(r"\bn?jit\(cache", path.read_text("utf-8"))]
