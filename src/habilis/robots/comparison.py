"""Which tool gives a hand the most influence on the puck: averages, ranks, and verdicts."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import comb
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Bool, Float64

from habilis.empowerment.arguments import at_least_one, whole_number
from habilis.estimators.counting import Counting
from habilis.estimators.protocol import Estimator, Fitted
from habilis.progress import progress_bar
from habilis.reprs import counted, short, unfailing
from habilis.robots.placements import Placements, puck_placements
from habilis.robots.pushing import PushingSimulator
from habilis.robots.tools import tools_of
from habilis.statistics import bootstrap_interval
from habilis.worlds.world import NO_TOOL

if TYPE_CHECKING:
    import polars as pl

SEQUENCES = 200
"""How many states a search goes on from, unless a method is given."""
INFLUENCE = 0.5
"""Bits from which there is influence: a count of two outcomes is one bit, and of one 0."""
_AT_ONCE = 8  # placements between two reports


@dataclass(frozen=True, eq=False)
class Verdicts:
    """Which of two tools has more object empowerment, placement by placement.

    A tool is better where each search finds more with it than any finds with the other. Of k
    seeds each, chance alone would order all of them so in one of `comb(2 k, k)` cases. The values
    are lower bounds: a verdict says what searches of this size find.

    Attributes:
        better: bool[n], for certain in this sense.
        worse: bool[n].
        equal: bool[n]: all searches find the same. Where none of the three holds, it is undecided.
        level: the probability of a verdict where both are equal but for the search.
    """

    better: Bool[np.ndarray, "n"]
    worse: Bool[np.ndarray, "n"]
    equal: Bool[np.ndarray, "n"]
    level: float

    @property
    def undecided(self) -> Bool[np.ndarray, "n"]:
        """Where searches differ among themselves more than between the tools."""
        return ~(self.better | self.worse | self.equal)


@dataclass(frozen=True, eq=False)
class ToolComparison:
    """Object empowerment of the puck with each tool in the hand.

    Attributes:
        tools: names; "none" is the bare hand.
        placements: where the puck is.
        bits: float64[tools, n, seeds], of each search.
        latency: float64[tools, n], the least number of actions with influence, infinite where
            `horizon` of them have none.
        distance: float64[n], from the hand to the puck, between the origins of their bodies.
        horizon: h, in actions.
        kind: what `bits` are: "lower bound" of `Counting`.
    """

    tools: tuple[str, ...]
    placements: Placements
    bits: Float64[np.ndarray, "tools n seeds"]
    latency: Float64[np.ndarray, "tools n"]
    distance: Float64[np.ndarray, "n"]
    horizon: int
    kind: str

    @unfailing
    def __repr__(self) -> str:
        best = self.tools[int(self.averages.argmax())]
        return short(
            "ToolComparison",
            f"{best} first of {counted(len(self.tools), 'tool')}",
            f"{self.averages.max():.2f} bits on average",
            counted(self.bits.shape[1], "placement"),
        )

    @property
    def averages(self) -> Float64[np.ndarray, "tools"]:
        """The mean over placements and seeds, in bits."""
        return self.bits.mean(axis=(1, 2))

    @property
    def range(self) -> Float64[np.ndarray, "tools"]:
        """The largest distance of a puck that there is influence on; 0 without any."""
        influenced = self.bits.mean(axis=2) >= INFLUENCE
        return np.where(influenced, self.distance, 0.0).max(axis=1)

    @property
    def influenced(self) -> Float64[np.ndarray, "tools"]:
        """The share of placements in which there is influence."""
        return (self.bits.mean(axis=2) >= INFLUENCE).mean(axis=1)

    @property
    def median_latency(self) -> Float64[np.ndarray, "tools"]:
        """The median of the latency over placements with influence; infinite without any."""
        found = [row[np.isfinite(row)] for row in self.latency]
        return np.array([np.median(row) if len(row) else np.inf for row in found])

    def interval(
        self, confidence: float = 0.95
    ) -> tuple[Float64[np.ndarray, "tools"], Float64[np.ndarray, "tools"]]:
        """Bootstrap intervals of the averages, over placements and seeds.

        Args:
            confidence: how much of the bootstrap distribution lies between the ends.

        Returns:
            Lower and upper ends, in bits.
        """
        return self._resampled(lambda means: means, confidence)

    def gain(
        self, than: str = NO_TOOL, confidence: float = 0.95
    ) -> tuple[Float64[np.ndarray, "tools"], Float64[np.ndarray, "tools"]]:
        """Bootstrap intervals of how much more each tool has than another, in the same placements.

        Args:
            than: the other tool.
            confidence: as in `interval`.

        Returns:
            Lower and upper ends, in bits.
        """
        place = self._place(than)
        return self._resampled(lambda means: means - means[..., place, None], confidence)

    def ranks(
        self, confidence: float = 0.95
    ) -> tuple[Float64[np.ndarray, "tools"], Float64[np.ndarray, "tools"]]:
        """Bootstrap intervals of each tool's rank by its average; 1 is the largest.

        Args:
            confidence: as in `interval`.

        Returns:
            Best and worst ranks.
        """

        def ranked(means: np.ndarray) -> np.ndarray:
            return 1.0 + (means[..., None, :] > means[..., :, None]).sum(axis=-1)

        low, high = self._resampled(ranked, confidence)
        return np.floor(low), np.ceil(high)

    def verdicts(self, tool: str, than: str = NO_TOOL) -> Verdicts:
        """The paper's condition E_AO < E_TO in each placement.

        Args:
            tool: whose object empowerment is E_TO.
            than: whose is E_AO.

        Returns:
            Where it holds, where its reverse does, and where neither is decided.
        """
        ours, theirs = self.bits[self._place(tool)], self.bits[self._place(than)]
        seeds = ours.shape[1]
        better = ours.min(axis=1) > theirs.max(axis=1)
        worse = ours.max(axis=1) < theirs.min(axis=1)
        low, high = (np.stack([end(ours, 1), end(theirs, 1)]) for end in (np.min, np.max))
        equal = low.min(axis=0) == high.max(axis=0)
        return Verdicts(better, worse, equal, 2 / comb(2 * seeds, seeds))

    def frame(self) -> "pl.DataFrame":
        """A row for each tool, the largest average first.

        Returns:
            A Polars data frame: average and the ends of its interval, gain over "none" likewise,
            ranks, range, latency, and the shares of placements in which the tool is better than
            none, encumbers, or neither is decided; null where "none" was not compared.
        """
        import polars as pl

        low, high = self.interval()
        best, worst = self.ranks()
        bare = NO_TOOL in self.tools
        gained = self.gain() if bare else None
        rows = []
        for place in np.argsort(-self.averages, kind="stable"):
            tool = self.tools[place]
            row: dict[str, Any] = {
                "tool": tool,
                "bits": self.averages[place],
                "bits_low": low[place],
                "bits_high": high[place],
                "rank_best": int(best[place]),
                "rank_worst": int(worst[place]),
                "influenced": self.influenced[place],
                "range": self.range[place],
                "latency": self.latency[place].min(),
                "median_latency": self.median_latency[place],
            }
            judged = self.verdicts(tool) if bare and tool != NO_TOOL else None
            row["gain_low"] = None if gained is None else gained[0][place]
            row["gain_high"] = None if gained is None else gained[1][place]
            for name in ("better", "worse", "equal", "undecided"):
                row[name] = None if judged is None else float(getattr(judged, name).mean())
            rows.append(row)
        return pl.DataFrame(rows, infer_schema_length=None)

    def _place(self, tool: str) -> int:
        if tool not in self.tools:
            raise ValueError(f"{tool!r} was not compared; use one of {', '.join(self.tools)}")
        return self.tools.index(tool)

    def _resampled(self, function: Any, confidence: float) -> Any:
        """The interval of a function of the averages."""
        generator = np.random.default_rng(0)
        seeds = self.bits.shape[2]

        def statistic(drawn: np.ndarray) -> np.ndarray:
            means = drawn.mean(axis=0)  # draws, tools, seeds
            picked = generator.integers(seeds, size=(len(means), 1, seeds))
            return function(np.take_along_axis(means, picked, axis=2).mean(axis=2))

        return bootstrap_interval(np.moveaxis(self.bits, 1, 0), statistic, confidence)


def compare_tools(
    model: str | Path,
    tools: Sequence[str] | None = None,
    horizon: int = 8,
    *,
    method: Estimator | None = None,
    side: int = 8,
    seeds: int = 4,
    seed: int = 0,
    noise: float = 0.0,
    show_progress: bool = False,
) -> ToolComparison:
    """Object empowerment of the puck with each of some tools, wherever it may be.

    Args:
        model: the path of a MuJoCo file, its text, or "reach.xml"; see `habilis.robots.tools_of`.
        tools: some of its tools, and "none"; by default "none" and all of them.
        horizon: h, in actions.
        method: an estimator; by default `Counting` of cells of the model's resolution, with 200
            sequences.
        side: of the grid of placements, see `Placements`.
        seeds: how many searches are made of each placement.
        seed: of the placements, and of the first search.
        noise: of the controls, see `PushingSimulator`; above 0 it needs a method for stochastic
            simulators.
        show_progress: whether to draw a progress bar on standard error.

    Returns:
        The values of every placement and seed, with their statistics.

    Raises:
        ValueError: the model is none of a hand and a puck, has no such tool, or an argument is out
            of its range.
        MissingExtraError: MuJoCo is not installed.

    Example:
        >>> found = compare_tools("reach.xml", ["none", "stick"], horizon=4, side=2, seeds=1)
        >>> dict(zip(found.tools, found.influenced.round(2).tolist()))
        {'none': 0.5, 'stick': 0.5}
    """
    names = [NO_TOOL, *tools_of(model)] if tools is None else list(tools)
    if len(set(names)) != len(names) or not names:
        raise ValueError(f"tools is {names}; give different ones, at least one")
    horizon, seeds = at_least_one("horizon", horizon), at_least_one("seeds", seeds)
    seed = whole_number("seed", seed)
    simulators = [PushingSimulator(model, name, noise=noise) for name in names]
    where = puck_placements(simulators, side, seed)
    estimator = method or Counting(simulators[0].resolution, SEQUENCES)
    count = len(where.positions)
    bits, latency = np.zeros((len(names), count, seeds)), np.full((len(names), count), np.inf)
    kind, done = "", 0
    with progress_bar("placements", show_progress) as report:
        for row, simulator in enumerate(simulators):
            fitted = [
                estimator.fit(simulator, horizon, "puck", seed=seed + k) for k in range(seeds)
            ]
            shorter = [estimator.fit(simulator, h, "puck", seed=seed) for h in range(1, horizon)]
            kind = fitted[0].kind
            for first in range(0, count, _AT_ONCE):
                some = slice(first, first + _AT_ONCE)
                states = simulator.placed(where.positions[some])
                values = np.stack([one.bits(states) for one in fitted], axis=1)
                bits[row, some] = values
                latency[row, some] = _latency(shorter, states, values[:, 0])
                done += len(states)
                report(done, count * len(names))
    distance = _distance(simulators[0], where)
    return ToolComparison(tuple(names), where, bits, latency, distance, horizon, kind)


def _latency(
    shorter: Sequence[Fitted],
    states: Float64[np.ndarray, "n d"],
    bits: Float64[np.ndarray, "n"],
) -> Float64[np.ndarray, "n"]:
    """The least number of actions with influence, given the values at the horizon."""
    found = np.where(bits >= INFLUENCE, len(shorter) + 1.0, np.inf)
    for h, fitted in enumerate(shorter, start=1):
        open_ = np.flatnonzero(found == len(shorter) + 1)
        if not len(open_):
            break
        early = fitted.bits(states[open_]) >= INFLUENCE
        found[open_[early]] = h
    return found


def _distance(simulator: PushingSimulator, where: Placements) -> Float64[np.ndarray, "n"]:
    """From the hand to the puck in each placement."""
    from habilis.robots.scene import bodies_at

    found = []
    for state in simulator.placed(where.positions):
        hand, puck = bodies_at(simulator, state)
        found.append(float(np.hypot(*(hand - puck)[:2])))
    return np.array(found)
