"""Several JAX devices: lanes are spread over them, and come to the same."""

import json
import os
import subprocess
import sys

CODE = """
import hashlib, json, sys, threading
import jax
from habilis.learning import batches
from habilis.learning.config import Config
from habilis.learning.runner import train

used, advance = set(), batches.advance

def watching(dynamics, settings, lanes, program):
    after = advance(dynamics, settings, lanes, program)
    used.update(str(d) for leaf in jax.tree.leaves((dynamics, after)) for d in leaf.devices())
    return after

batches.advance = watching
config = Config(world=sys.argv[1], runs=12, episodes=300, episode_limit=50)
run = train(config.changed(hidden=(8,), intrinsic="object", horizon=2, beta=0.1))
episodes = hashlib.sha256(run.episodes.to_numpy().tobytes()).hexdigest()
leaves = [leaf.tobytes().hex() for leaf in map(jax.device_get, jax.tree.leaves(run.parameters))]
print(json.dumps([len(jax.devices()), sorted(used), episodes, leaves]))
"""


def test_two_devices_are_both_used_and_train_the_same_as_one(tmp_path):
    room = tmp_path / "room.txt"
    room.write_text("A.\nC.\n..\nG.\n")
    said = []
    for count in (1, 2):
        flags = f"--xla_force_host_platform_device_count={count}"
        command = [sys.executable, "-W", "error", "-c", CODE, str(room)]
        environment = os.environ | {"XLA_FLAGS": flags, "JAX_PLATFORMS": "cpu"}
        done = subprocess.run(
            command, env=environment, stdout=subprocess.PIPE, text=True, check=True
        )
        said.append(json.loads(done.stdout))
    (one, used_by_one, *of_one), (two, used_by_two, *of_two) = said
    assert (one, two) == (1, 2)
    assert (len(used_by_one), len(used_by_two)) == (1, 2)
    assert of_one == of_two
