"""A real Ray cluster of two nodes on this machine, one of which is killed."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from habilis.cli import main
from habilis.sweeps.store import LAYOUT, results

SPEC = """
[config]
world = "{room}"
runs = 5
episodes = 100000
steps = 300000
entropy = 9.0
episode_limit = 50
hidden = [8]
[grid]
learning_rate = [1e-3, 2e-3, 4e-3, 8e-3]
discount = [0.9, 0.99]
"""

CLUSTER = """
import sys
from ray.cluster_utils import Cluster

def patiently(start):
    for attempts_left in reversed(range(5)):
        try:
            return start()
        except Exception:  # Ray gives a node half a minute to start, busy machine or not
            if not attempts_left:
                raise

head = {"num_cpus": 1, "include_dashboard": False}
cluster = patiently(lambda: Cluster(initialize_head=True, head_node_args=head))
other = patiently(lambda: cluster.add_node(num_cpus=1))
print(cluster.address, flush=True)
for line in sys.stdin:
    cluster.remove_node(other, allow_graceful=False)
    print("killed", flush=True)
cluster.shutdown()
"""
"""Two nodes of one processor each; a line of input kills the one that is not the head."""


@pytest.fixture
def cluster():
    quiet = {"RAY_USAGE_STATS_ENABLED": "0"}
    process = subprocess.Popen(
        [sys.executable, "-c", CLUSTER],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | quiet,
    )
    with process:
        yield process
        assert process.stdin is not None
        process.stdin.close()


def reported(process: subprocess.Popen) -> str:
    assert process.stdout is not None
    line = process.stdout.readline().strip()
    assert line, "the cluster has gone"
    return line


def test_a_sweep_outlives_a_node_and_a_driver(room, tmp_path, cluster, capsys):
    spec = tmp_path / "grid.toml"
    spec.write_text(SPEC.format(room=room))
    folder, said = tmp_path / "cluster", tmp_path / "said"
    address = reported(cluster)
    command = ["sweep", str(spec), "--out", str(folder), "--ray", address]

    def start(*options: str) -> subprocess.Popen:
        with said.open("w") as file:
            whole = [sys.executable, "-m", "habilis", *command, *options]
            return subprocess.Popen(whole, stdout=file, stderr=file)

    def wait_for(process: subprocess.Popen, count: int) -> None:
        while len(finished()) < count:
            assert process.poll() is None, said.read_text()
            time.sleep(0.01)

    def finished() -> list[Path]:
        return list((folder / LAYOUT.results).glob("[!.]*.npz"))

    first = start()
    wait_for(first, 1)
    assert cluster.stdin is not None
    cluster.stdin.write("kill\n")
    cluster.stdin.flush()
    assert reported(cluster) == "killed"
    before = len(finished())
    assert before < 8, "all was over before the node was killed"
    wait_for(first, before + 1)
    first.kill()
    first.wait()
    assert len(finished()) < 8, "all was over before the driver was killed"
    assert start("--resume").wait() == 0, said.read_text()
    assert "Traceback" not in said.read_text()

    assert main(["sweep", str(spec), "--out", str(tmp_path / "local")]) == 0
    here, there = (results(tmp_path / name).drop("seconds") for name in ("local", "cluster"))
    assert there.height == there.select("point", "run").n_unique() == 8 * 5
    assert there.equals(here)


def test_where_there_is_no_cluster_it_is_one_line(room, tmp_path, capsys):
    spec = tmp_path / "grid.toml"
    spec.write_text(SPEC.format(room=room))
    arguments = ["sweep", str(spec), "--out", str(tmp_path / "out"), "--ray", "nonsense"]
    assert main(arguments) == 2
    said = capsys.readouterr().err
    assert said.startswith("habilis: nonsense: no Ray cluster can be reached there")
    assert said.count("\n") == 1
    assert not (tmp_path / "out").exists()
