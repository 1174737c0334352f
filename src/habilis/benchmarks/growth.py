"""How time and memory grow with states, actions, horizon, labels and noise: ours and its peers.

Each point is measured in a process of its own, so that no other leaves memory behind:

python -m habilis.benchmarks.growth AXIS NAME SIZE
"""

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from habilis.benchmarks import Result, time_of
from habilis.benchmarks.counting import dense_rows, enumerate_sequences
from habilis.benchmarks.noise import enumerate_noisy_sequences, maze
from habilis.empowerment import empowerment
from habilis.mdp import TabularMDP
from habilis.progress import progress_bar
from habilis.worlds.table import tabulate
from habilis.worlds.world import World, load_world

_LONG, _LONGEST = 3.0, 30.0
"""Seconds of a call above which it is made once; of a process after which no larger one starts."""
_ROOM = 6.0  # GiB that a peer may take
_RETURNED = {"MALLOC_MMAP_THRESHOLD_": "65536"}
"""With glibc: what is freed goes back to the system, so that a second call shows what it takes."""
_ASKED = 20  # states that a peer is timed on whose cost is the same for each

Call = tuple[Callable[[], Any], float]
"""A call, and how many times its seconds all states take."""


@dataclass(frozen=True)
class Axis:
    """One quantity that grows, everything else being the same.

    Attributes:
        name: of the quantity.
        task: what is computed, of what.
        sizes: of the quantity.
        calls: by name, what is measured; `None` for a size that does not fit in memory.
    """

    name: str
    task: str
    sizes: tuple[int, ...]
    calls: Mapping[str, Callable[[int], Call | None]]


@dataclass(frozen=True)
class Point:
    """What one size took.

    Attributes:
        axis, name: whose.
        size: of the quantity; of states how many there are.
        seconds: the median of the rounds.
        least, most: of the rounds.
        gib: the memory that the call took besides what was there before; `None` where the system
            does not say.
    """

    axis: str
    name: str
    size: int
    seconds: float
    least: float
    most: float
    gib: float | None


# The tables.


def square(side: int) -> World:
    """An empty square room with a picker, from 4 x 4 up."""
    rows = [["."] * side for _ in range(side)]
    for character, (row, column) in zip("APCG", ((0, 0), (2, 1), (1, 2), (-1, -1)), strict=True):
        rows[row][column] = character
    return World.parse("\n".join("".join(row) for row in rows), f"square{side}")


def scattered(states: int, actions: int, labels: int) -> tuple[TabularMDP, np.ndarray]:
    """A table whose successors are drawn at random, so that no two are near, and its sensor."""
    random = np.random.default_rng(0)
    table = random.integers(states, size=(states, actions), dtype=np.int32)
    seen = np.arange(states, dtype=np.int32) % labels
    return TabularMDP.deterministic(table), random.permutation(seen)


def noisy(states: int, actions: int, outcomes: int) -> TabularMDP:
    """A table whose actions have so many outcomes each."""
    random = np.random.default_rng(0)
    P = np.zeros((states, actions, states))
    for row in P.reshape(-1, states):
        row[random.choice(states, outcomes, replace=False)] = random.dirichlet(np.ones(outcomes))
    return TabularMDP.stochastic(P)


# What is measured.


def _counted(mdp: TabularMDP, horizon: int, sensor: Any) -> Call:
    return lambda: empowerment(mdp, horizon, sensor), 1


def _listed(mdp: TabularMDP, horizon: int, labels: np.ndarray) -> Call | None:
    """All sequences of some states: eight bytes each."""
    if 3 * 8 * mdp.action_count**horizon > _ROOM * 2**30:
        return None
    asked = np.linspace(0, mdp.states - 1, _ASKED).astype(int)
    return lambda: enumerate_sequences(mdp, labels, asked, horizon), mdp.states / _ASKED


def _dense(mdp: TabularMDP, horizon: int) -> Call | None:
    """Rows of a bit for each state, of which NumPy holds four."""
    if 4 * mdp.states**2 / 8 > _ROOM * 2**30:
        return None
    return lambda: dense_rows(mdp, horizon), 1


def _plain(mdp: TabularMDP, horizon: int) -> Call | None:
    """All sequences of a few states, and plain Blahut-Arimoto iteration."""
    if 3 * 8 * mdp.states * mdp.action_count**horizon > _ROOM * 2**30:
        return None
    asked = [0, mdp.states - 1]
    return (
        lambda: [enumerate_noisy_sequences(mdp, state, horizon) for state in asked],
        mdp.states / len(asked),
    )


def _corridor() -> TabularMDP:
    return tabulate(load_world("corridor"))


_SIDES = (4, 5, 7, 9, 12, 16, 21, 28, 38)
_MANY = 100_000
AXES = (
    Axis(
        "states",
        "object sensor, h = 6: empty rooms with a picker, 8 actions",
        _SIDES,
        {
            "ours": lambda n: _counted(tabulate(square(n)), 6, "object"),
            "all sequences": lambda n: _listed(m := tabulate(square(n)), 6, m.factor("object")),
        },
    ),
    Axis(
        "states, all seen",
        "full state, h = 4: the same rooms",
        _SIDES,
        {
            "ours": lambda n: _counted(tabulate(square(n)), 4, "state"),
            "dense rows of bits": lambda n: _dense(tabulate(square(n)), 4),
            "all sequences": lambda n: _listed(m := tabulate(square(n)), 4, np.arange(m.states)),
        },
    ),
    Axis(
        "horizon",
        "object sensor: the corridor, 21,170 states, 8 actions",
        (1, 2, 3, 4, 5, 6, 7, 8, 16, 32, 64, 128, 256, 512, 1024),
        {
            "ours": lambda h: _counted(_corridor(), h, "object"),
            "all sequences": lambda h: _listed(m := _corridor(), h, m.factor("object")),
        },
    ),
    Axis(
        "actions",
        f"64 labels, h = 4: successors at random, {_MANY:,} states",
        (2, 4, 8, 16, 32, 64, 128),
        {
            "ours": lambda a: _counted((s := scattered(_MANY, a, 64))[0], 4, s[1]),
            "all sequences": lambda a: _listed((s := scattered(_MANY, a, 64))[0], 4, s[1]),
        },
    ),
    Axis(
        "labels",
        f"h = 4: successors at random, {_MANY:,} states, 8 actions",
        (2, 16, 64, 256, 1_024, 4_096, 16_384, _MANY),
        {
            "ours": lambda n: _counted((s := scattered(_MANY, 8, n))[0], 4, s[1]),
            "all sequences": lambda n: _listed((s := scattered(_MANY, 8, n))[0], 4, s[1]),
        },
    ),
    Axis(
        "outcomes of an action",
        "full state, h = 3: 100 states, 4 actions",
        (1, 2, 4, 8, 16, 32, 64),
        {
            "ours": lambda n: _counted(noisy(100, 4, n), 3, "state"),
            "all sequences, plain iteration": lambda n: _plain(noisy(100, 4, n), 3),
        },
    ),
    Axis(
        "states, slippery",
        "full state, h = 3: slippery mazes, 5 actions",
        (5, 10, 20, 40, 80),
        {
            "ours": lambda n: _counted(maze(side=n), 3, "state"),
            "all sequences, plain iteration": lambda n: _plain(maze(side=n), 3),
        },
    ),
    Axis(
        "horizon, slippery",
        "full state: slippery maze of 100 states, 5 actions",
        (1, 2, 3, 4, 5, 6),
        {
            "ours": lambda h: _counted(maze(), h, "state"),
            "all sequences, plain iteration": lambda h: _plain(maze(), h),
        },
    ),
)


def measured(axis: str, name: str, size: int) -> Point | None:
    """One point, here and now; `None` if it does not fit in memory."""
    asked = next(one for one in AXES if one.name == axis)
    call = asked.calls[name](size)
    if call is None:
        return None
    run, scale = call
    if axis.startswith("states"):
        size = size**2 if "slippery" in axis else tabulate(square(size)).states
    before = _reset_peak()
    began = time.perf_counter()
    run()
    seconds = np.array([time.perf_counter() - began])
    if seconds < _LONG:
        seconds = time_of(run)
        before = _reset_peak()  # compiling takes memory too, and is done by now
        run()
    peak = _peak()
    gib = None if peak is None or before is None else max(peak - before, 0) / 2**20
    low, median, high = (float(scale * at(seconds)) for at in (np.min, np.median, np.max))
    return Point(axis, name, size, median, low, high, gib)


def _peak() -> int | None:
    """The most memory in KiB since the last reset."""
    status = Path("/proc/self/status")
    if not status.exists():
        return None
    lines = dict(line.split(":", 1) for line in status.read_text().splitlines())
    return int(lines["VmHWM"].split()[0])


def _reset_peak() -> int | None:
    """Sets the most memory to what is there now, which Linux does for who writes to a file."""
    try:
        Path("/proc/self/clear_refs").write_text("5")
    except OSError:
        return None
    return _peak()


def points(show_progress: bool = False) -> list[Point]:
    """Every axis, each of its curves up to what takes too long or does not fit."""
    found = []
    pairs = [(axis, name, size) for axis in AXES for name in axis.calls for size in axis.sizes]
    ended = set()
    with progress_bar("points", show_progress) as report:
        for done, (axis, name, size) in enumerate(pairs):
            report(done, len(pairs))
            if (axis.name, name) in ended:
                continue
            began = time.perf_counter()
            point = _measured_apart(axis.name, name, size)
            if point is not None:
                found.append(point)
            if point is None or time.perf_counter() - began > _LONGEST:
                ended.add((axis.name, name))
    return found


def _measured_apart(axis: str, name: str, size: int) -> Point | None:
    command = [sys.executable, "-m", __name__, axis, name, str(size)]
    ran = subprocess.run(command, check=True, stdout=subprocess.PIPE, env=os.environ | _RETURNED)
    point = json.loads(ran.stdout)
    return None if point is None else Point(**point)


def is_exponential(axis: str) -> bool:
    """Whether growth is stated as a factor for each further action, not as an exponent."""
    return axis.startswith("horizon")


def slope(points: list[Point], of: str) -> float | None:
    """How a curve grows over the larger half of its sizes, by least squares of logarithms.

    Args:
        points: of one curve.
        of: "seconds" or "gib", of which values below 1 MiB say nothing.

    Returns:
        The exponent of the size, or over horizons the factor for each action; `None` where fewer
        than two sizes have a value.
    """
    least = 2**-10 if of == "gib" else 0
    values = [(one.size, getattr(one, of)) for one in points[len(points) // 2 - 1 :]]
    values = [(size, value) for size, value in values if value is not None and value > least]
    if len(values) < 2:
        return None
    sizes, seen = np.array(values).T
    if is_exponential(points[0].axis):
        return float(np.exp(np.polyfit(sizes, np.log(seen), 1)[0]))
    return float(np.polyfit(np.log(sizes), np.log(seen), 1)[0])


def results() -> list[Result]:
    """The largest size that each reached, and the slopes of its curves."""
    found, lines = points(), []
    for axis in AXES:
        for name in axis.calls:
            curve = [one for one in found if (one.axis, one.name) == (axis.name, name)]
            if not curve:
                continue
            last = curve[-1]
            note = f"{axis.task}; {axis.name} {last.size:,}"
            grows = slope(curve, "seconds")
            lines.append(
                Result(f"{name}, {axis.name}", last.seconds, "s", note, last.least, last.most)
            )
            if grows is not None:
                unit = "times" if is_exponential(axis.name) else ""
                note = "for each action" if unit else "exponent of the size"
                lines.append(Result("  growth of time", grows, unit, note))
    return lines


if __name__ == "__main__":
    point = measured(sys.argv[1], sys.argv[2], int(sys.argv[3]))
    print(json.dumps(None if point is None else vars(point)))
