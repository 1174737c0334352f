"""Estimators on pendulum and cart-pole: the figures of docs/explanation/continuous.md.

    python -m research.continuous           # ten minutes on two processors
    python -m research.continuous learned   # the learned estimators, three minutes

Writes research/results/continuous.csv, the landscapes, and the pictures beside the page; prints
its tables. Landscapes that continuous.csv has are not computed again.
"""

import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import jax.numpy as jnp
import numpy as np
import polars as pl
from matplotlib.figure import Figure

import habilis as hb
from habilis.colours import COLOURS
from habilis.estimators import (
    Contrastive,
    Counting,
    Fitted,
    Gaussian,
    Gridded,
    MonteCarlo,
    RandomSequences,
    VarianceProxy,
    Variational,
    follow,
)
from habilis.estimators.simulators import cart_pole, pendulum
from habilis.files import write_whole
from habilis.statistics import spearman
from habilis.worlds.pictures.figures import new_figure, save_figure
from habilis.worlds.pictures.heatmap import HEAT
from habilis.worlds.pictures.video import save_video

RESULTS = Path(__file__).parent / "results" / "continuous.csv"
PAGE = Path(__file__).parent.parent / "docs" / "explanation" / "continuous"
HORIZON, STARTS, STEPS, STAYS = 5, 10, 200, 50
ANGLES, VELOCITIES = np.linspace(-np.pi, np.pi, 33), np.linspace(-8, 8, 21)
FASTEST = 14.0  # rad/s, of the tables
AROUND, CELL = 32, 0.5  # cells of the angle, and the size in rad/s of those of the velocity
UPRIGHT = 0.3  # rad
LONGER = 8  # actions, of one more count
TABLES = (100, 317)  # cells of a table along either axis: 10^4 and 10^5 states

box = pendulum()
levels = replace(box, actions=np.linspace(-5, 5, 5)[:, None])
states = np.stack(np.meshgrid(ANGLES, VELOCITIES, indexing="ij"), axis=-1).reshape(-1, 2)


def cells(observations: Any) -> Any:
    """The cell of a pendulum's observation: of the angle, which is wrapped, and the velocity."""
    turn = jnp.arctan2(observations[:, 1], observations[:, 0]) / (2 * jnp.pi) + 0.5
    cell = jnp.floor(turn * AROUND) % AROUND, jnp.floor(observations[:, 2] / CELL)
    return jnp.stack(cell, axis=1)


def small(observations: Any) -> Any:
    """A pendulum's observation in hundredths, since a variance below 1 is 0 bits."""
    return 100 * observations


@dataclass(frozen=True, eq=False)
class Table:
    """The pendulum with its state rounded to the nearest of a grid's after every step."""

    mdp: hb.TabularMDP
    labels: np.ndarray
    centres: np.ndarray
    across: int

    @classmethod
    def of(cls, across: int) -> "Table":
        """A table of across * across states, with the five torques."""
        middle = (np.arange(across) + 0.5) / across
        grid = 2 * np.pi * middle - np.pi, 2 * FASTEST * middle - FASTEST
        centres = np.stack(np.meshgrid(*grid, indexing="ij"), axis=-1).reshape(-1, 2)
        steps = [
            levels.step(centres, np.tile(action, (len(centres), 1)), None)
            for action in levels.actions
        ]
        found = cls.numbers(np.asarray(steps, np.float64).reshape(-1, 2), across)
        seen = np.stack([np.cos(centres[:, 0]), np.sin(centres[:, 0]), centres[:, 1]], axis=1)
        labels = np.unique(np.asarray(cells(seen)), axis=0, return_inverse=True)[1].ravel()
        mdp = hb.TabularMDP.deterministic(found.reshape(len(steps), -1).T)
        return cls(mdp, labels.astype(np.int64), centres, across)

    @staticmethod
    def numbers(asked: np.ndarray, across: int) -> np.ndarray:
        """The nearest state of each."""
        turn = np.floor((asked[:, 0] / (2 * np.pi) + 0.5) * across).astype(int) % across
        fast = np.floor((asked[:, 1] / (2 * FASTEST) + 0.5) * across).astype(int)
        return turn * across + np.clip(fast, 0, across - 1)

    def bits(self, asked: Any) -> np.ndarray:
        """The table's exact empowerment."""
        numbers = self.numbers(np.asarray(asked), self.across)
        return hb.empowerment(self.mdp, HORIZON, self.labels, states=numbers)


def estimators() -> dict[str, Any]:
    """Each estimator, fitted, by its name in the page."""
    power = HORIZON * 25 / 3  # of uniform torques
    return {
        "Counting, all sequences": Counting(1.0, 4000).fit(levels, HORIZON, cells),
        "table of 100,489 states": Table.of(TABLES[-1]),
        "MonteCarlo": MonteCarlo(60, 1, noise=0.2, tolerance=0.1).fit(box, HORIZON),
        "Gaussian": Gaussian(power, noise=0.2).fit(box, HORIZON),
        "Counting, 8 actions": Counting(1.0, 1000).fit(levels, LONGER, cells),
        "1,000 random sequences": RandomSequences(1000).fit(levels, HORIZON, cells),
        "variance proxy": VarianceProxy(1000).fit(box, HORIZON, small),
    }


def landscapes() -> dict[str, np.ndarray]:
    """The values of each estimator on the grid, from the results if they are there."""
    kept = pl.read_csv(RESULTS) if RESULTS.exists() else pl.DataFrame()
    found = {}
    for name, fitted in estimators().items():
        if name in kept.columns:
            found[name] = kept[name].to_numpy()
            continue
        began = time.perf_counter()
        found[name] = fitted.bits(states)
        print(f"{name}: {time.perf_counter() - began:.1f} s", flush=True)
    table = pl.DataFrame({"angle": states[:, 0], "velocity": states[:, 1]} | found)
    write_whole(RESULTS, table.write_csv)
    return found


def draw_landscapes(found: dict[str, np.ndarray]) -> Figure:
    """Every landscape, each on its own scale."""
    across, wide, high, gap = 4, 240, 170, 50
    rows = -(-len(found) // across)
    width, height = (wide + gap) * across + gap, (high + gap) * rows + 36
    figure = new_figure(width, height)
    for place, (name, values) in enumerate(found.items()):
        left = gap + (wide + gap) * (place % across)
        top = 40 + (high + gap) * (place // across)
        ax = figure.add_axes(
            (left / width, 1 - (top + high) / height, wide * 0.86 / width, high / height)
        )
        grid = values.reshape(len(ANGLES), len(VELOCITIES)).T
        image = ax.pcolormesh(ANGLES, VELOCITIES, grid, cmap=HEAT, shading="nearest")
        angle, velocity = states[values.argmax()]
        ax.plot(angle, velocity, "x", color="#d55e00", markersize=8, markeredgewidth=2)
        ax.set_title(name, fontsize=10)
        ax.set_xticks([-np.pi, 0, np.pi], [r"$-\pi$", "0", r"$\pi$"], fontsize=8)
        ax.tick_params(axis="y", labelsize=8)
        if place % across == 0:
            ax.set_ylabel("velocity in rad/s", fontsize=9, labelpad=0)
        if place + across >= len(found):
            ax.set_xlabel("angle, 0 upright", fontsize=9, labelpad=1)
        bar = figure.colorbar(image, ax=ax, fraction=0.05, pad=0.03)
        bar.ax.tick_params(labelsize=8)
        bar.outline.set_visible(False)
    return figure


def draw_curves() -> Figure:
    """Bits upright and hanging, over the number of sequences and over the horizon."""
    figure = new_figure(960, 380)
    ends = np.array([[0.0, 0.0], [np.pi, 0.0]])
    left, right = figure.subplots(1, 2)
    counts = (10, 20, 40, 80, 160)
    for at, (name, make) in enumerate(
        {
            "MonteCarlo": lambda n: MonteCarlo(n, 1, noise=0.2, tolerance=0.05).fit(box, HORIZON),
            "Counting": lambda n: Counting(1.0, n).fit(box, HORIZON, cells),
            "random sequences": lambda n: RandomSequences(n).fit(box, HORIZON, cells),
        }.items()
    ):
        values = np.stack([make(count).bits(ends) for count in counts])
        _draw_pair(left, counts, values, name, COLOURS[at])
    left.set_xscale("log")
    left.set(xlabel="sequences", ylabel="bits", title=f"h = {HORIZON}")
    horizons = (1, 2, 3, 4, 5, 6, 8, 10)
    for at, (name, make) in enumerate(
        {
            "MonteCarlo": lambda h: MonteCarlo(60, 1, noise=0.2, tolerance=0.05).fit(box, h),
            "Counting": lambda h: Counting(1.0, 500).fit(levels, h, cells),
            "Gaussian": lambda h: Gaussian(h * 25 / 3, noise=0.2).fit(box, h),
        }.items()
    ):
        values = np.stack([make(h).bits(ends) for h in horizons])
        _draw_pair(right, horizons, values, name, COLOURS[(0, 1, 3)[at]])
    right.set(xlabel="horizon", title="60 and 500 sequences")
    for ax in (left, right):
        ax.grid(alpha=0.3)
        place = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.2), "ncol": 3}
        ax.legend(fontsize=7, frameon=False, columnspacing=1, **place)
    figure.tight_layout()
    return figure


def _draw_pair(ax: Any, over: Any, values: np.ndarray, name: str, colour: str) -> None:
    ax.plot(over, values[:, 0], "o-", color=colour, label=f"{name}, upright", markersize=4)
    ax.plot(over, values[:, 1], "o--", color=colour, label="hanging", markersize=4)


def swing_up(fitted: Fitted | Gridded) -> tuple[int, float, np.ndarray]:
    """How many starts end upright and stay so, when they first are, and the first trajectory."""
    generator = np.random.default_rng(0)
    starts = np.array([np.pi, 0]) + generator.uniform(-0.3, 0.3, (STARTS, 2))
    went = follow(fitted, box, starts, STEPS).states
    upright = np.cos(went[:, :, 0]) > np.cos(UPRIGHT)
    first = np.where(upright.any(axis=0), upright.argmax(axis=0), np.inf)
    return int(upright[-STAYS:].all(axis=0).sum()), float(np.median(first)), went[:, 0]


def balance() -> None:
    """The cart-pole from nearly upright."""
    world = cart_pole()
    starts = np.random.default_rng(0).uniform(-0.1, 0.1, (STARTS, 4))
    for horizon in (3, 5, 8):
        fitted = Gaussian(horizon * 100 / 3, noise=0.2).fit(world, horizon)
        went = follow(fitted, world, starts, STEPS).states
        up = (np.abs(went[:, :, 2]) < UPRIGHT).all(axis=0)
        inside = (np.abs(went[:, :, 0]) < 2.4).all(axis=0)
        print(
            f"cart-pole, h = {horizon}: {up.sum()} of {STARTS} upright, {(up & inside).sum()} of "
            f"them within 2.4 m; at most {np.abs(went[:, :, 0]).max():.1f} m",
            flush=True,
        )


def learned() -> None:
    """Learned estimators of the pendulum with a noisy state; without, sequences are all told apart.

    They are trained with more rounds than their defaults, and held against `Gaussian`.
    """

    def step(state: Any, action: Any, drawn: Any) -> Any:
        return box.function(state, action) + 0.1 * drawn

    noisy = replace(box, function=step, noise=2)
    smooth = Gaussian(HORIZON * 25 / 3, noise=0.01).fit(noisy, HORIZON).bits(states)
    print(f"Gaussian: {smooth.min():.2f} to {smooth.max():.2f} bits")
    for method in (Variational(rounds=120, samples=128), Contrastive(rounds=150)):
        began = time.perf_counter()
        fitted = method.fit(noisy, HORIZON, seed=0)
        seconds = time.perf_counter() - began
        values = fitted.bits(states)
        grid = values.reshape(len(ANGLES), len(VELOCITIES))
        stayed, *_ = swing_up(Gridded((ANGLES, VELOCITIES), grid, (2 * np.pi, 0.0)))
        print(
            f"{type(method).__name__}: {values.min():.2f} to {values.max():.2f} bits, rank "
            f"correlation {spearman(values[None], smooth[None])[0]:.2f}, {stayed} of {STARTS} stay "
            f"upright; {seconds:.0f} s to fit",
            flush=True,
        )


def main() -> None:
    PAGE.mkdir(exist_ok=True)
    found = landscapes()
    save_figure(draw_landscapes(found), PAGE / "landscapes.png")
    truth = found["Counting, all sequences"]
    for across in TABLES:
        error = Table.of(across).bits(states) - truth
        print(
            f"table of {across**2:,} states: bias {error.mean():.3f}, RMSE "
            f"{np.sqrt((error**2).mean()):.3f}, at most {np.abs(error).max():.3f} bits"
        )
    direct = estimators()["Gaussian"]
    for name, values in found.items():
        angle, velocity = states[values.argmax()]
        grid = values.reshape(len(ANGLES), len(VELOCITIES))
        periods = (2 * np.pi, 0.0)
        stayed, first, _ = swing_up(Gridded((ANGLES, VELOCITIES), grid, periods))
        print(
            f"{name}: largest at ({angle:.2f}, {velocity:.2f}), rank correlation "
            f"{spearman(values[None], truth[None])[0]:.3f}, {stayed} of {STARTS} stay upright, "
            f"first after {first}",
            flush=True,
        )
    stayed, first, went = swing_up(direct)
    print(f"Gaussian, not tabulated: {stayed} of {STARTS}, first after {first}")
    save_video([box.at(state) for state in went[:60]], PAGE / "swing-up.gif", 64, 100)
    balance()
    save_figure(draw_curves(), PAGE / "curves.png")


if __name__ == "__main__":
    learned() if "learned" in sys.argv[1:] else main()
