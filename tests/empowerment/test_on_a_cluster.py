"""Empowerment on a real Ray cluster of two nodes on this machine, one of which is killed."""

import os
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Callable
from itertools import chain
from pathlib import Path

import numpy as np
import pytest
from ray_cluster import two_nodes
from slow_states import HOLD, HORIZON

import habilis as hb
from habilis.cli import main

SUPPORT = Path(__file__).parents[1] / "support"
STATES = 120


def is_gone(process: int) -> bool:
    try:
        status = Path(f"/proc/{process}/stat").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return True
    return status.rpartition(")")[2].split()[0] in "ZX"


def test_a_computation_outlives_a_node_and_a_driver_and_has_the_same_values(
    tmp_path: Path, capsys, monkeypatch: pytest.MonkeyPatch
):
    # Workers have the environment of their nodes, which begin here, and not the driver's.
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(SUPPORT), *sys.path]))
    rng = np.random.default_rng(0)
    mdp = hb.TabularMDP.deterministic(rng.integers(STATES, size=(STATES, 4))).slippery(0.3)
    table, work, notes, hold = (tmp_path / name for name in ("m.npz", "work", "notes", HOLD))
    mdp.save(table)
    notes.mkdir()

    def finished() -> set[str]:
        return {path.stem for path in (work / "tasks").glob("[!.]*.npz")}

    def running() -> dict[str, tuple[str, int]]:
        """Where each task runs that has begun and is not finished: the node and the process."""
        begun = {note.name: note.read_text().split()[-4:-2] for note in notes.iterdir()}
        return {
            name: (where[0], int(where[1]))
            for name, where in begun.items()
            if where and name not in finished()
        }

    def wait_until(what: Callable[[], bool], driver: subprocess.Popen) -> None:
        while not what():
            assert driver.poll() is None, "the driver has ended"
            time.sleep(0.01)

    with two_nodes() as cluster:
        driver = subprocess.Popen(
            [sys.executable, "-c", "import slow_states; slow_states.main()", cluster.address]
            + [str(path) for path in (table, work, notes)]
        )
        wait_until(lambda: len(finished()) > 10, driver)
        hold.touch()
        wait_until(lambda: len({node for node, _ in running().values()}) == 2, driver)
        cluster.kill_one()
        wait_until(lambda: any(is_gone(process) for _, process in running().values()), driver)
        lost = {name for name, (_, process) in running().items() if is_gone(process)}
        hold.unlink()
        wait_until(lambda: lost <= finished(), driver)
        assert all(len((notes / name).read_text().splitlines()) > 1 for name in lost)
        driver.kill()
        driver.wait()
        assert len(finished()) < STATES, "all was over before the driver was killed"

        command = ["empowerment", str(table), "--horizon", str(HORIZON), "--out"]
        there, here = tmp_path / "there.npz", tmp_path / "here.npz"
        where = ["--ray", cluster.address, "--work", str(work)]
        assert main([*command, str(there), *where, "--resume"]) == 0
        assert len(finished()) == STATES
    assert main([*command, str(here)]) == 0
    assert there.read_bytes() == here.read_bytes()

    tables: dict[str, set[str]] = defaultdict(set)
    nodes = set()
    for line in chain(*(note.read_text().splitlines() for note in notes.iterdir())):
        node, process, place, writeable = line.split()
        tables[process].add(place)
        nodes.add(node)
        assert writeable == "False", "the table is in the node's store"
    assert len(nodes) == 2
    assert all(len(places) == 1 for places in tables.values()), "a process has one"
