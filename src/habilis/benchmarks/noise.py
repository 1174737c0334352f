"""Stochastic empowerment: merged beliefs and certified capacities beside listing all sequences."""

import numpy as np
from jaxtyping import Float64

from habilis.benchmarks import Result, Seconds, time_of, times
from habilis.benchmarks.channels import blahut_arimoto
from habilis.empowerment import empowerment
from habilis.empowerment.methods import Exact
from habilis.mdp import TabularMDP
from habilis.processors import processors

_SIDE = 10
_WALLS = 0.15  # a cell
_SLIP = 0.125  # 0.9 for the intended action, 0.025 for each of the four others
_ASKED = 4  # states that the enumeration is timed on


def maze(seed: int = 0, side: int = _SIDE) -> TabularMDP:
    """A slippery square maze: walls between cells; four moves and to stay."""
    rng = np.random.default_rng(seed)
    row, column = np.divmod(np.arange(side**2), side)
    steps = np.array([(-1, 0), (0, 1), (1, 0), (0, -1), (0, 0)])
    r, c = row[:, None] + steps[:, 0], column[:, None] + steps[:, 1]
    inside = (r >= 0) & (r < side) & (c >= 0) & (c < side)
    table = np.where(inside, r * side + c, np.arange(side**2)[:, None])
    for cell, way in rng.integers((side**2, 4), size=(round(_WALLS * side**2), 2)):
        beyond = table[cell, way]
        table[beyond, (way + 2) % 4], table[cell, way] = beyond, cell
    return TabularMDP.deterministic(table).slippery(_SLIP)


def enumerate_noisy_sequences(mdp: TabularMDP, state: int, horizon: int) -> float:
    """A state's empowerment as it is commonly computed: all sequences, then plain iteration."""
    beliefs = np.eye(mdp.states)[[state]]
    ways = [mdp.transition(action).toarray() for action in range(mdp.action_count)]
    for _ in range(horizon):
        beliefs = np.concatenate([beliefs @ way for way in ways])
    return blahut_arimoto(beliefs[:, beliefs.any(axis=0)])[0]


def results(large: bool = False) -> list[Result]:
    """Lines of time, of gaps, and of what a second thread is good for.

    Args:
        large: whether to measure longer horizons too, which takes minutes.
    """
    mdp = maze()
    found = {horizon: empowerment(mdp, horizon, return_gap=True) for horizon in (4, 6)}
    asked = np.linspace(0, mdp.states - 1, _ASKED).astype(int)
    listed = [enumerate_noisy_sequences(mdp, state, 4) for state in asked]
    assert np.allclose(listed, found[4][0][asked], atol=3e-6)
    one, two = Exact(threads=1), Exact(threads=2)
    seconds = times(
        {
            "4": lambda: empowerment(mdp, 4),
            "6": lambda: empowerment(mdp, 6),
            "6, one": lambda: empowerment(mdp, 6, method=one),
            "6, two": lambda: empowerment(mdp, 6, method=two),
            "plain": lambda: [enumerate_noisy_sequences(mdp, state, 4) for state in asked],
        }
    )
    lines = [_line(horizon, seconds[str(horizon)], gap) for horizon, (_, gap) in found.items()]
    lines.append(
        Result.of(
            "noisy FOE, h = 4: all sequences and plain iteration / ours",
            seconds["plain"] / _ASKED * mdp.states / seconds["4"],
            "times",
            f"625 sequences a state, {_ASKED} states scaled up",
        )
    )
    lines.append(
        Result.of(
            "noisy FOE, h = 6: two threads / one",
            seconds["6, two"] / seconds["6, one"],
            "of the time",
            f"on {processors()} processors; the values are the same to the bit",
        )
    )
    return [*lines, *(_long(mdp) if large else [])]


def _long(mdp: TabularMDP) -> list[Result]:
    lines = []
    for horizon in (7, 8):
        _, gap = empowerment(mdp, horizon, return_gap=True)
        seconds = time_of(lambda horizon=horizon: empowerment(mdp, horizon))
        lines.append(_line(horizon, seconds, gap))
    return lines


def _line(horizon: int, seconds: Seconds, gap: Float64[np.ndarray, "n"]) -> Result:
    assert (gap <= 1e-6).all()
    note = f"10x10 slippery maze, 5 actions, all 100 states, gap {gap.max():.1g} bits"
    return Result.of(f"noisy FOE, h = {horizon}", seconds, "s", note)
