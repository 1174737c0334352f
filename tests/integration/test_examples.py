"""The examples, run as their readers run them."""

import re
import runpy
import subprocess
import sys
from pathlib import Path

import habilis as hb

EXAMPLES = Path(__file__).parents[2] / "examples"
ROOM = "########\n#AP....#\n#..##C.#\n#.....G#\n########\n"


def run(name, *arguments):
    """The numbers of each line that it prints, by their names."""
    done = subprocess.run(
        [sys.executable, "-W", "error", EXAMPLES / name, *map(str, arguments)],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert not done.stderr
    found = [re.findall(r"(\w+)=(-?[\d.]+|nan)", line) for line in done.stdout.splitlines()]
    return [{name: float(number) for name, number in line} for line in found]


def best(world):
    plan = hb.solve(hb.tabulate(hb.World.parse(world)))
    assert plan is not None
    return plan


def test_the_single_file_of_cleanrls_kind_learns_short_episodes():
    lines = run(
        *("cleanrl_ppo.py", "--env-id", "habilis/World-v0", "--world", ROOM, "--max-steps", 200),
        *("--horizon", 3, "--total-timesteps", 40_000),
    )
    assert len(lines) >= 20
    lengths = [line["length"] for line in lines]
    assert lengths[-1] < max(lengths) / 5
    assert lengths[-1] < 2 * len(best(ROOM).actions)
    assert lines[-1]["return"] > 1 - lengths[-1]  # what it would be without empowerment


def test_the_one_of_purejaxrls_kind_does_too():
    lines = run(
        *("purejaxrl_ppo.py", "--world", ROOM, "--max-steps", 200),
        *("--horizon", 3, "--total-timesteps", 100_000),
    )
    assert len(lines) == 10
    lengths = [line["length"] for line in lines]
    assert lengths[-1] < lengths[0] / 3
    assert lengths[-1] < 2 * len(best(ROOM).actions)


def test_tabular_q_learning_finds_the_best_return():
    lines = run("q_learning.py")
    world = runpy.run_path(str(EXAMPLES / "q_learning.py"))["WORLD"]
    assert lines[-1]["return"] == best(world).best_return
    assert lines[0]["return"] < 3 * lines[-2]["return"]
