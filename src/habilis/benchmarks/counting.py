"""Deterministic empowerment: sets carried through the table, against listing all sequences."""

import numpy as np

from habilis.benchmarks import Result, times
from habilis.empowerment import empowerment
from habilis.empowerment.tabular.blocks import in_blocks
from habilis.empowerment.tabular.counting import count_backward, unite
from habilis.mdp import TabularMDP
from habilis.processors import processors
from habilis.worlds.table import tabulate
from habilis.worlds.world import World, load_world

_ASKED = 20  # states that the enumeration is timed on; its cost is the same for each


def enumerate_sequences(mdp: TabularMDP, labels: np.ndarray, states: np.ndarray, horizon: int):
    """Empowerment as it is commonly computed: all |A|^h sequences of a state, vectorised."""
    bits = []
    for state in states:
        reached = np.array([state])
        for _ in range(horizon):
            reached = mdp.next_state[reached].ravel()
        bits.append(np.log2(len(np.unique(labels[reached]))))
    return np.array(bits)


def results() -> list[Result]:
    mdp = tabulate(load_world("corridor"))
    return [
        *_beside_enumeration(mdp, "TOE", "object", horizon=6),
        *_beside_enumeration(mdp, "FOE", "state", horizon=5),
        *_beside_dense_rows("yard", horizon=40),
        *_growth(mdp),
        *_bandwidth(),
    ]


def _beside_enumeration(mdp: TabularMDP, name: str, sensor: str, horizon: int) -> list[Result]:
    labels = np.arange(mdp.states) if sensor == "state" else mdp.factor(sensor)
    asked = np.linspace(0, mdp.states - 1, _ASKED).astype(int)
    enumerated = enumerate_sequences(mdp, labels, asked, horizon)
    assert np.array_equal(empowerment(mdp, horizon, sensor, states=asked), enumerated)
    seconds = times(
        {
            "ours": lambda: empowerment(mdp, horizon, sensor),
            "theirs": lambda: enumerate_sequences(mdp, labels, asked, horizon),
        }
    )
    ours, theirs = seconds["ours"], seconds["theirs"] / _ASKED * mdp.states
    sequences = mdp.action_count**horizon
    return [
        Result.of(f"{horizon}-step {name}", 1e3 * ours, "ms", f"all {mdp.states:,} states"),
        Result.of(
            f"{horizon}-step {name}: enumeration / ours",
            theirs / ours,
            "times",
            f"{sequences:,} sequences a state, vectorised NumPy, {_ASKED} states scaled up",
        ),
    ]


def dense_rows(mdp: TabularMDP, horizon: int) -> np.ndarray:
    """Full-state empowerment by rows of bits, a bit a state, united over actions h times."""
    states = np.arange(mdp.states)
    sets = np.zeros((mdp.states, -(-mdp.states // 64)), np.uint64)
    sets[states, states // 64] = np.uint64(1) << (states % 64).astype(np.uint64)
    for _ in range(horizon):
        grown = sets[mdp.next_state[:, 0]]
        for action in range(1, mdp.action_count):
            grown |= sets[mdp.next_state[:, action]]
        sets = grown
    return np.log2(np.bitwise_count(sets).sum(axis=1, dtype=np.int64))


def _beside_dense_rows(world: str, horizon: int) -> list[Result]:
    """FOE of many actions, and of so many that the sets have long been full."""
    mdp = tabulate(load_world(world))
    assert np.array_equal(empowerment(mdp, horizon), dense_rows(mdp, horizon))
    horizons = (horizon, 2 * horizon, 10**9)
    calls = {str(h): lambda h=h: empowerment(mdp, h) for h in horizons}
    seconds = times({**calls, "dense": lambda: dense_rows(mdp, horizon)})
    results = []
    for h in horizons:
        name, note = f"{h:,}-step FOE of {world}", f"all {mdp.states:,} states"
        results.append(Result.of(name, 1e3 * seconds[str(h)], "ms", note))
        if h == horizon:
            ratio, note = seconds["dense"] / seconds[str(h)], "dense rows of bits in NumPy"
            results.append(Result.of(f"{name}: dense / ours", ratio, "times", note))
    return results


def _growth(mdp: TabularMDP) -> list[Result]:
    """How the cost of TOE grows: linear is a ratio of 1."""
    small, large = tabulate(room(12)), tabulate(room(20))
    seconds = times(
        {
            "short": lambda: empowerment(mdp, 8, "object"),
            "long": lambda: empowerment(mdp, 16, "object"),
            "small": lambda: empowerment(small, 6, "object"),
            "large": lambda: empowerment(large, 6, "object"),
        }
    )
    words = {"small": small.states * -(-12 * 12 // 64), "large": large.states * -(-20 * 20 // 64)}
    per_word = {name: seconds[name] / many for name, many in words.items()}
    return [
        Result.of(
            "TOE, cost of h = 16 over twice that of h = 8",
            seconds["long"] / seconds["short"] / 2,
            "times",
            "linear: 1",
        ),
        Result.of(
            "TOE, 20x20 over 12x12, a state and word",
            per_word["large"] / per_word["small"],
            "times",
            f"linear: at most 1 ({large.states:,} and {small.states:,} states)",
        ),
    ]


def _bandwidth() -> list[Result]:
    """How near the packed bits come to what memory allows, and what need not be moved at all.

    A step back over all states has to read the table, read every set and write every set: the
    least that it can move. What memory can move is measured by copying, with as many threads.
    """
    horizon, side = 6, 28
    mdp, threads = tabulate(room(side)), processors()
    labels, label_count = mdp.factor("object"), side * side
    words = -(-label_count // 64)
    sets = np.zeros((mdp.states, words), np.uint64)
    sets[np.arange(mdp.states), labels // 64] = np.uint64(1) << (labels % 64).astype(np.uint64)
    out, first = np.zeros_like(sets), np.zeros(mdp.states, np.uint8)
    by_label = np.argsort(labels, kind="stable")
    place = np.argsort(by_label).astype(np.int32)
    sorted_table = place[mdp.next_state[by_label]]

    def step(table: np.ndarray) -> None:
        in_blocks(lambda a, b: unite(table, first, 1, sets, out, a, b), mdp.states, 2**20, threads)

    def copy() -> None:
        in_blocks(lambda a, b: np.copyto(out[a:b], sets[a:b]), mdp.states, 2**20, threads)

    seconds = times(
        {"step": lambda: step(mdp.next_state), "sorted": lambda: step(sorted_table), "copy": copy}
    )
    least = seconds["copy"] * (1 + mdp.next_state.nbytes / (2 * sets.nbytes))
    note = f"{mdp.states:,} states, {words} words, {threads} threads"
    del sets, out
    whole = times(
        {
            "all": lambda: count_backward(mdp.next_state, labels, label_count, horizon, threads),
            "ours": lambda: empowerment(mdp, horizon, "object"),
        }
    )
    return [
        Result.of("packed bits, share of memory's bound", least / seconds["step"], "", note),
        Result.of(
            "packed bits by label, share of memory's bound",
            least / seconds["sorted"],
            "",
            "states with the same label side by side",
        ),
        Result.of(
            "copying as much",
            2 * words * 8 * mdp.states / 1e9 / seconds["copy"],
            "GB/s",
            f"{threads} threads",
        ),
        Result.of(
            f"TOE, h = {horizon}: sets of all states / ours",
            whole["all"] / whole["ours"],
            "times",
            f"ours leaves out states that {horizon} actions cannot change",
        ),
    ]


def room(side: int) -> World:
    """An empty square room."""
    rows = [["."] * side for _ in range(side)]
    for character, (row, column) in zip("APCG", ((0, 0), (2, 2), (4, 4), (6, 6)), strict=True):
        rows[row][column] = character
    return World.parse("\n".join("".join(row) for row in rows), f"room{side}")
