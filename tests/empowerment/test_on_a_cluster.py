"""Empowerment on a real Ray cluster of two nodes on this machine, one of which is killed."""

import os
import subprocess
import sys
import time
from collections import defaultdict
from pathlib import Path

import numpy as np
from ray_cluster import two_nodes
from slow_states import HORIZON

import habilis as hb
from habilis.cli import main

SUPPORT = Path(__file__).parents[1] / "support"
STATES = 60


def test_a_computation_outlives_a_node_and_a_driver_and_has_the_same_values(tmp_path: Path, capsys):
    rng = np.random.default_rng(0)
    mdp = hb.TabularMDP.deterministic(rng.integers(STATES, size=(STATES, 4))).slippery(0.3)
    table, work, notes = (tmp_path / name for name in ("m.npz", "work", "notes"))
    mdp.save(table)
    notes.mkdir()

    def finished() -> int:
        return len(list((work / "tasks").glob("[!.]*.npz")))

    def wait_for(process: subprocess.Popen, count: int) -> None:
        while finished() < count:
            assert process.poll() is None, "the driver has ended"
            time.sleep(0.01)

    with two_nodes() as cluster:
        driver = subprocess.Popen(
            [sys.executable, "-c", "import slow_states; slow_states.main()", cluster.address]
            + [str(path) for path in (table, work, notes)],
            env=os.environ | {"PYTHONPATH": os.pathsep.join([str(SUPPORT), *sys.path])},
        )
        wait_for(driver, 10)
        cluster.kill_one()
        before = finished()
        wait_for(driver, before + 5)  # on the node that is left
        driver.kill()
        driver.wait()
        left = STATES - finished()
        assert left > 5, "all was over before the driver was killed"

        command = ["empowerment", str(table), "--horizon", str(HORIZON), "--out"]
        there, here = tmp_path / "there.npz", tmp_path / "here.npz"
        where = ["--ray", cluster.address, "--work", str(work)]
        assert main([*command, str(there), *where, "--resume"]) == 0
        assert finished() == STATES
    assert main([*command, str(here)]) == 0
    assert there.read_bytes() == here.read_bytes()

    tables: dict[str, set[str]] = defaultdict(set)
    nodes = set()
    for note in notes.iterdir():
        node, process, place, writeable = note.read_text().split()
        tables[process].add(place)
        nodes.add(node)
        assert writeable == "False", "the table is in the node's store"
    assert len(nodes) == 2
    assert all(len(places) == 1 for places in tables.values()), "a process has one"
