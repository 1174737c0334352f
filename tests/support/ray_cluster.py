"""A real Ray cluster of two nodes on this machine, one of which can be killed."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

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


@dataclass(frozen=True)
class TwoNodes:
    """The cluster.

    Attributes:
        process: it runs in.
        address: of its head.
    """

    process: subprocess.Popen
    address: str

    def kill_one(self) -> None:
        """Kills the node that is not the head."""
        assert self.process.stdin is not None
        self.process.stdin.write("kill\n")
        self.process.stdin.flush()
        assert _reported(self.process) == "killed"


@contextmanager
def two_nodes() -> Iterator[TwoNodes]:
    """Starts the cluster, and ends it."""
    process = subprocess.Popen(
        [sys.executable, "-c", CLUSTER],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | {"RAY_USAGE_STATS_ENABLED": "0"},
    )
    with process:
        yield TwoNodes(process, _reported(process))
        assert process.stdin is not None
        process.stdin.close()


def _reported(process: subprocess.Popen) -> str:
    assert process.stdout is not None
    line = process.stdout.readline().strip()
    assert line, "the cluster has gone"
    return line
