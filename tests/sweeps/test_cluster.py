"""A real Ray cluster of two nodes on this machine, one of which is killed."""

import subprocess
import sys
import time
from pathlib import Path

from ray_cluster import two_nodes

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


def test_a_sweep_outlives_a_node_and_a_driver(room, tmp_path, capsys):
    spec = tmp_path / "grid.toml"
    spec.write_text(SPEC.format(room=room))
    folder, said = tmp_path / "cluster", tmp_path / "said"

    def start(address: str, *options: str) -> subprocess.Popen:
        command = ["sweep", str(spec), "--out", str(folder), "--ray", address, *options]
        with said.open("w") as file:
            whole = [sys.executable, "-m", "habilis", *command]
            return subprocess.Popen(whole, stdout=file, stderr=file)

    def wait_for(process: subprocess.Popen, count: int) -> None:
        while len(finished()) < count:
            assert process.poll() is None, said.read_text()
            time.sleep(0.01)

    def finished() -> list[Path]:
        return list((folder / LAYOUT.results).glob("[!.]*.npz"))

    with two_nodes() as cluster:
        first = start(cluster.address)
        wait_for(first, 1)
        cluster.kill_one()
        before = len(finished())
        assert before < 8, "all was over before the node was killed"
        wait_for(first, before + 1)
        first.kill()
        first.wait()
        assert len(finished()) < 8, "all was over before the driver was killed"
        assert start(cluster.address, "--resume").wait() == 0, said.read_text()
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
