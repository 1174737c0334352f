"""Channel capacity: ours beside Blahut and Arimoto's iteration as it stands, and beside dit."""

import warnings
from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np
from jaxtyping import Float64

from habilis.benchmarks import Result, times
from habilis.channels.capacity import capacity

_GAP = 1e-6  # bits
_SIZES = ((64, 64), (1024, 256))
_ALPHAS = (1.0, 0.05)


def blahut_arimoto(P: Float64[np.ndarray, "n m"], gap: float = _GAP) -> tuple[float, int]:
    """The iteration of 1972, vectorised, until its gap is reached: bits, and how many steps."""
    logs = np.log2(np.maximum(P, np.finfo(float).tiny))
    neg_entropy = (P * logs).sum(axis=1)
    p = np.full(len(P), 1 / len(P))
    steps = 0
    while True:
        divergence = neg_entropy - P @ np.log2(p @ P)
        bits = float(p @ divergence)
        if divergence.max() - bits <= gap:
            return bits, steps
        p *= np.exp2(divergence - divergence.max())
        p /= p.sum()
        steps += 1


def results() -> list[Result]:
    lines = []
    for (inputs, outputs), alpha in product(_SIZES, _ALPHAS):
        P = np.random.default_rng(0).dirichlet(np.full(outputs, alpha), inputs)
        name = f"capacity, Dirichlet({alpha:g}) {inputs}x{outputs}"
        found = capacity(P, _GAP)
        bits, steps = blahut_arimoto(P)
        assert found.gap <= _GAP
        assert abs(found.bits - bits) <= 2 * _GAP
        calls: dict[str, Callable[[], Any]] = {
            "ours": lambda P=P: capacity(P, _GAP),
            "plain": lambda P=P: blahut_arimoto(P),
        }
        dit = _dit()
        if dit is not None:
            calls["dit"] = lambda P=P, dit=dit: dit(P)
        seconds = times(calls)
        ours, plain = seconds["ours"], seconds["plain"]
        lines += [
            Result.of(name, 1e3 * ours, "ms", f"gap {found.gap:.1g} bits"),
            Result.of(f"{name}: plain / ours", plain / ours, "times", f"{steps:,} steps"),
        ]
        if dit is not None:
            error = abs(float(dit(P)) - found.bits)
            note = f"dit, default settings; it errs by {error:.1g} bits"
            lines.append(Result.of(f"{name}: dit / ours", seconds["dit"] / ours, "times", note))
    return lines


def _dit() -> Callable[[np.ndarray], Any] | None:
    """Dit's capacity, where it is installed (it is a development dependency)."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            from dit.algorithms.channelcapacity import channel_capacity
        except ImportError:
            return None

    def of(P: np.ndarray) -> float:
        with np.errstate(all="ignore"):
            return channel_capacity(P)[0]

    return of
