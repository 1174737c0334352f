"""Cases of vectors: Gaussian systems in closed form, lines discretised finely, rounded sensors."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
from jaxtyping import Float64

from habilis.cache import fingerprint, kept
from habilis.channels.capacity import certified
from habilis.estimators.actions import ActionBox
from habilis.estimators.evaluation.case import Case
from habilis.estimators.protocol import SensorOfSimulator, Simulator
from habilis.estimators.rollouts import outcomes_of
from habilis.estimators.sensors import reading
from habilis.estimators.simulators.classics import ball_in_box, linear_system, pendulum
from habilis.estimators.simulators.jax_function import JaxSimulator

Bits = Float64[np.ndarray, "n"]

_ASKED = 32  # states
_ON_LINE = 12  # of a line
_TOLERANCE = 1e-6  # bits
_TAIL = 6  # standard deviations that count
_RESOLUTION = (17, 300)  # actions and cells of a line


def linear_bits(A: Any, B: Any, N: Any, rows: Any, horizon: int, power: float) -> float:
    """The capacity of s' = A s + B a + N z after h actions with E ||(a_1 ... a_h)||^2 <= power.

    With G = [A^(h-1) B ... B] and V the covariance of the noise, seen through the sensor, the
    powers p_i = max(0, level - 1 / g_i) fill the eigenvalues g_i of G^T V^(-1) G up to a level.

    Args:
        A, B, N: float[d, d], float[d, k] and float[d, q].
        rows: of the state that the sensor sees.
        horizon: h.
        power: in all.

    Returns:
        1/2 sum log2(1 + g_i p_i), in bits.
    """
    A, B, N = (np.asarray(one, np.float64) for one in (A, B, N))
    ways = [np.linalg.matrix_power(A, step) for step in range(horizon)]
    G = np.concatenate([way @ B for way in ways], axis=1)[rows]
    V = np.sum([way @ N @ N.T @ way.T for way in ways], axis=0)[rows][:, rows]
    gains = np.linalg.eigvalsh(G.T @ np.linalg.solve(V, G))
    gains = gains[gains > 1e-12 * gains.max()]
    low, high = 0.0, power + (1 / gains).max()
    for _ in range(200):  # by bisection
        level = (low + high) / 2
        spent = np.maximum(level - 1 / gains, 0).sum()
        low, high = (level, high) if spent < power else (low, level)
    return float(np.log2(np.maximum(gains * high, 1)).sum() / 2)


def line_bits(
    mean: Callable[[Any, Any], Any],
    noise: float,
    bound: float,
    horizon: int,
    states: Float64[np.ndarray, "n"],
    reach: tuple[float, float],
    resolution: tuple[int, int] = _RESOLUTION,
) -> tuple[Bits, Bits]:
    """The capacity of s' = mean(s, a) + noise * z on a line, with actions from -bound to bound.

    Places and actions are discretised. The capacity of the actions on the grid is a lower bound;
    the largest divergence of an outcome of actions on a grid four times as fine from the best
    output is an upper one.

    Args:
        mean: of arrays of states and actions.
        noise: a standard deviation.
        bound: of the actions.
        horizon: h.
        states: of which.
        reach: between which two numbers a mean lies, but where 6 standard deviations of noise lead.
        resolution: the numbers of actions and of cells.

    Returns:
        The lower bounds in bits, and by how much the upper ones are larger.
    """
    count, cells = resolution
    low, high = reach[0] - _TAIL * noise, reach[1] + _TAIL * noise
    places = low + (np.arange(cells) + 0.5) * (high - low) / cells

    def moves(starts: Any, action: Any) -> np.ndarray:
        middle = mean(np.atleast_1d(starts), action).clip(*reach)
        rows = np.exp(-(((places - middle[:, None]) / noise) ** 2) / 2)
        return rows / rows.sum(axis=1, keepdims=True)

    def channels(actions: Float64[np.ndarray, "m"]) -> Iterator[np.ndarray]:
        each = [moves(places, action) for action in actions] if horizon > 1 else []
        for state in states:
            rows = np.concatenate([moves(state, action) for action in actions])
            for _ in range(horizon - 1):
                rows = np.concatenate([rows @ step for step in each])
            yield rows

    coarse = np.linspace(-bound, bound, count)
    fine = np.linspace(-bound, bound, 4 * (count - 1) + 1)
    bits, gaps = [], []
    for rows, more in zip(channels(coarse), channels(fine), strict=True):
        found = certified(_sparse(rows), _TOLERANCE)
        seen = np.log2(np.maximum(found.input_distribution @ rows, 1e-300))
        most = (more * (np.log2(np.maximum(more, 1e-300)) - seen)).sum(axis=1).max()
        bits.append(found.bits)
        gaps.append(max(most - found.bits, found.gap))
    return np.array(bits), np.array(gaps)


def _sparse(rows: Float64[np.ndarray, "n m"]) -> Any:
    from scipy.sparse import csr_array

    kept_rows = np.where(rows > 1e-14, rows, 0)
    return csr_array(kept_rows / kept_rows.sum(axis=1, keepdims=True))


def _gaussian(A: Any, B: Any, N: Any, sensor: Any, horizon: int, power: float, about: str) -> Any:
    def make(name: str) -> Case:
        size = len(A)
        simulator = linear_system(A, B, noise=N)
        rows = np.arange(size) if isinstance(sensor, str) else np.asarray(sensor)
        states = simulator.random_states(4, np.random.default_rng(0))
        bits = np.full(len(states), linear_bits(A, B, N, rows, horizon, power))
        none = np.zeros(len(states))
        return Case(name, simulator, horizon, sensor, states, bits, none, "capacity", power, about)

    return make


def _line(
    mean: Callable[[Any, Any], Any],
    noise: float,
    bound: float,
    horizon: int,
    ends: tuple[float, float],
    reach: tuple[float, float],
    about: str,
) -> Callable[[str], Case]:
    def make(name: str) -> Case:
        states = np.linspace(*ends, _ON_LINE)
        some = mean, noise, bound, horizon, states, reach

        def compute() -> dict[str, np.ndarray]:
            bits, error = line_bits(*some)
            return {"bits": bits, "error": error}

        probe = np.asarray(mean(states, np.float64(bound / 2)))
        key = fingerprint("line", probe, *some[1:], _RESOLUTION)
        found = kept(f"suite-{key[:32]}", compute)
        simulator = JaxSimulator(
            lambda state, action, drawn: mean(state, action) + noise * drawn,
            ActionBox([-bound], [bound]),
            noise=1,
            low=[ends[0]],
            high=[ends[1]],
            name=name,
        )
        truths = found["bits"], found["error"]
        return Case(
            name, simulator, horizon, "state", states[:, None], *truths, "capacity", None, about
        )

    return make


def counted_bits(
    simulator: Simulator,
    horizon: int,
    sensor: SensorOfSimulator,
    states: Float64[np.ndarray, "n d"],
) -> Bits:
    """The capacity of a deterministic simulator of finitely many actions, by all its sequences.

    Args:
        simulator: of few actions.
        horizon: h.
        sensor: one that is rounded.
        states: of which.

    Returns:
        The logarithms of the numbers of different readings.
    """
    sequences = np.array(list(product(np.asarray(simulator.actions), repeat=horizon)))
    outcomes = outcomes_of(simulator, reading(simulator, sensor))(states, sequences, 0, 1)
    return np.log2([len(np.unique(each[:, 0] + 0.0, axis=0)) for each in outcomes])


def _rounded(
    simulator: Callable[[], JaxSimulator],
    actions: Any,
    horizon: int,
    sensor: Callable[[Any], Any],
    about: str,
) -> Callable[[str], Case]:
    def make(name: str) -> Case:
        some = replace(simulator(), actions=np.asarray(actions, np.float64))
        states = some.random_states(_ASKED, np.random.default_rng(1))
        probe = np.asarray(some.step(states, np.repeat(some.actions[-1:], len(states), axis=0)))
        key = fingerprint("rounded", name, states, probe.round(4), some.actions, horizon)
        found = kept(
            f"suite-{key[:32]}", lambda: {"bits": counted_bits(some, horizon, sensor, states)}
        )
        bits = found["bits"]
        none = np.zeros(len(states))
        return Case(name, some, horizon, sensor, states, bits, none, "capacity", None, about)

    return make


def _trough(state: Any, action: Any) -> Any:
    """A step in a potential with two wells, at -1 and 1."""
    return state + 0.5 * (state - state**3) + action


def _walled(state: Any, action: Any) -> Any:
    return (state + action).clip(-1.0, 1.0)


MAKERS: dict[str, Callable[[str], Case]] = {
    "gauss-1": _gaussian([[0.9]], [[1.0]], [[0.5]], "state", 3, 3.0, "s' = 0.9 s + a + 0.5 z"),
    "gauss-2": _gaussian(
        [[1.0, 0.1], [0.0, 1.0]],
        [[0.005], [0.1]],
        [[0.01, 0.0], [0.0, 0.05]],
        "state",
        5,
        5.0,
        "a mass on a line, noise on position and velocity",
    ),
    "gauss-4": _gaussian(
        [[0.9, 0.2, 0.0, 0.1], [-0.2, 0.9, 0.1, 0.0], [0.0, 0.3, 0.7, 0.0], [0.1, 0.0, 0.2, 0.8]],
        [[1.0, 0.0], [0.0, 0.5], [0.2, 0.1], [0.0, 0.3]],
        [[0.3, 0.0, 0.0, 0.0], [0.1, 0.3, 0.0, 0.0], [0.0, 0.0, 0.2, 0.0], [0.0, 0.1, 0.0, 0.2]],
        [0, 2, 3],
        3,
        6.0,
        "4 numbers, of which the sensor sees 3",
    ),
    "wall": _line(
        _walled, 0.1, 0.5, 1, (-1.0, 1.0), (-1.0, 1.0), "a line between walls, discretised"
    ),
    "trough": _line(_trough, 0.15, 0.4, 2, (-1.5, 1.5), (-1.5, 1.5), "two wells, discretised"),
    "ball": _rounded(
        ball_in_box,
        [[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]],
        4,
        lambda seen: (seen[:, :2] / 0.1).round(),
        "a ball in a box, its cell of 0.1 m",
    ),
    "pendulum": _rounded(
        pendulum,
        [[-5], [0], [5]],
        6,
        lambda seen: (seen / 0.2).round(),
        "a pendulum, its cell of 0.2",
    ),
}
"""Each by its name."""
