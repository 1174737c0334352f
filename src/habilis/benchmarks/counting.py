"""Deterministic empowerment: sets carried through the table, against listing all sequences."""

import numpy as np

from habilis.benchmarks import Result, best_seconds
from habilis.empowerment import empowerment
from habilis.empowerment.tabular.blocks import in_blocks
from habilis.empowerment.tabular.counting import unite
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
    seconds = best_seconds(lambda: empowerment(mdp, horizon, sensor))
    labels = np.arange(mdp.states) if sensor == "state" else mdp.factor(sensor)
    asked = np.linspace(0, mdp.states - 1, _ASKED).astype(int)
    enumerated = enumerate_sequences(mdp, labels, asked, horizon)
    assert np.array_equal(empowerment(mdp, horizon, sensor, states=asked), enumerated)
    theirs = best_seconds(lambda: enumerate_sequences(mdp, labels, asked, horizon), 1)
    sequences = mdp.action_count**horizon
    return [
        Result(f"{horizon}-step {name}", 1e3 * seconds, "ms", f"all {mdp.states:,} states"),
        Result(
            f"{horizon}-step {name}: enumeration / ours",
            theirs / _ASKED * mdp.states / seconds,
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
    theirs = best_seconds(lambda: dense_rows(mdp, horizon), 1)
    results = []
    for h in (horizon, 2 * horizon, 10**9):
        seconds = best_seconds(lambda h=h: empowerment(mdp, h))
        name, note = f"{h:,}-step FOE of {world}", f"all {mdp.states:,} states"
        results.append(Result(name, 1e3 * seconds, "ms", note))
        if h == horizon:
            note = f"dense rows of bits in NumPy, {theirs:.3g} s"
            results.append(Result(f"{name}: dense / ours", theirs / seconds, "times", note))
    return results


def _growth(mdp: TabularMDP) -> list[Result]:
    """How the cost of TOE grows: linear is a ratio of 1."""
    short, long = (best_seconds(lambda h=h: empowerment(mdp, h, "object")) for h in (8, 16))
    small, large = tabulate(room(12)), tabulate(room(20))
    per_state = [best_seconds(lambda m=m: empowerment(m, 6, "object")) for m in (small, large)]
    words = [-(-12 * 12 // 64), -(-20 * 20 // 64)]
    per_word = [
        s / (m.states * w) for s, m, w in zip(per_state, (small, large), words, strict=True)
    ]
    return [
        Result(
            "TOE, cost of h = 16 over twice that of h = 8", long / short / 2, "times", "linear: 1"
        ),
        Result(
            "TOE, 20x20 over 12x12, a state and word",
            per_word[1] / per_word[0],
            "times",
            f"linear: at most 1 ({large.states:,} and {small.states:,} states)",
        ),
    ]


def _bandwidth() -> list[Result]:
    """How near the packed bits come to what memory allows.

    A step back has to read the table, read every set and write every set: the least that it can
    move. What memory can move is measured by copying, with as many threads.
    """
    mdp, threads = tabulate(room(28)), processors()
    cells = mdp.factor("object")
    words = -(-28 * 28 // 64)
    sets = np.zeros((mdp.states, words), np.uint64)
    sets[np.arange(mdp.states), cells // 64] = np.uint64(1) << (cells % 64).astype(np.uint64)
    out = np.empty_like(sets)

    def step() -> None:
        in_blocks(lambda a, b: unite(mdp.next_state, sets, out, a, b), mdp.states, 2**20, threads)

    def copy() -> None:
        in_blocks(lambda a, b: np.copyto(out[a:b], sets[a:b]), mdp.states, 2**20, threads)

    rate = 2 * sets.nbytes / best_seconds(copy)
    least = (mdp.next_state.nbytes + 2 * sets.nbytes) / rate
    note = (
        f"{mdp.states:,} states, {words} words, {threads} threads; copying: {rate / 1e9:.3g} GB/s"
    )
    return [Result("packed bits, share of memory's bound", least / best_seconds(step), "", note)]


def room(side: int) -> World:
    """An empty square room."""
    rows = [["."] * side for _ in range(side)]
    for character, (row, column) in zip("APCG", ((0, 0), (2, 2), (4, 4), (6, 6)), strict=True):
        rows[row][column] = character
    return World.parse("\n".join("".join(row) for row in rows), f"room{side}")
