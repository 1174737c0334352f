"""Does a bonus help a robot to learn to push? The last figures of docs/explanation/robots.md.

    .venv-integration/bin/python -m research.pushing  # the runs, a quarter of an hour
    python -m research.pushing figures                # picture and table, in a moment

The agent is Stable-Baselines3's PPO, in the environment of `make test-integration`. A finished run
is kept in research/results/pushing.csv, a row for each stretch of steps; another call goes on with
those that are missing. `--seeds 3` makes only the first.
"""

import argparse
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from tempfile import gettempdir
from time import process_time
from typing import Any

import gymnasium
import numpy as np
import polars as pl
from matplotlib.figure import Figure

import habilis as hb
from habilis.cache import cache_folder
from habilis.colours import COLOURS
from habilis.estimators import Counting, Gridded, OnGrid
from habilis.files import write_whole
from habilis.robots import PushingEnv, PushingSimulator, puck_placements
from habilis.statistics import bootstrap_interval
from habilis.worlds.pictures.figures import new_figure, save_figure

RESULTS = Path(__file__).parent / "results" / "pushing.csv"
PICTURE = Path(__file__).parents[1] / "docs" / "explanation" / "robots" / "learning.png"
CONDITIONS = ("plain", "empowerment", "distillation")
SEEDS, STEPS, STRETCH, COPIES = 5, 100_000, 5_000, 8
LAST = 4
"""Stretches at the end that the table shows."""
TOOL, GOAL, RADIUS = "scoop", (0.2, 0.85), 0.1
HORIZON, BETA, NOVELTY = 3, 0.1, 0.1
TABLE = (cache_folder() or Path(gettempdir())) / f"pushing-{TOOL}-{HORIZON}.npz"
HAND = (
    [-0.46, -0.4, -0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3, 0.4, 0.46],
    [-0.12, -0.1, 0.0, 0.1, 0.2, 0.24],
)
PUCK = np.linspace(-0.46, 0.46, 21), np.linspace(0.04, 0.96, 21)


def simulator() -> PushingSimulator:
    """The hand with its tool."""
    return PushingSimulator("reach.xml", TOOL, threads=1)


def starts() -> np.ndarray:
    """Where the puck begins: in front of the hand, on the open side, before the wall."""
    x, y = (where := puck_placements([simulator()], 12).positions).T
    return where[(x > -0.16) & (y > 0.25) & (y < 0.56)]


class Seen(gymnasium.ObservationWrapper):
    """Hand, puck, and the way from one to the other, about -2 to 2."""

    def __init__(self, env: gymnasium.Env):
        super().__init__(env)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (6,), np.float32)

    def observation(self, observation: np.ndarray) -> np.ndarray:
        hand, puck = observation[:2], observation[2:4]
        return 4 * np.concatenate(
            [hand, puck - [0.0, 0.5], puck - hand - [0.0, 0.16]], dtype=np.float32
        )


class Kept:
    """The count of the puck's cells on a grid of positions, computed once for all runs."""

    def fit(self, simulator: Any, horizon: int, sensor: Any, *, seed: int) -> Gridded:
        axes = *HAND, *PUCK, *([0.0],) * 4
        if not TABLE.exists():
            TABLE.parent.mkdir(parents=True, exist_ok=True)
            made = OnGrid(Counting(0.05, 200), axes).fit(simulator, horizon, sensor, seed=seed)
            np.savez(TABLE, values=made.values)
        values = np.load(TABLE)["values"]
        return Gridded(tuple(np.asarray(axis, np.float64) for axis in axes), values, (0.0,) * 8)


def environment(condition: str) -> gymnasium.Env:
    """What the agent learns in."""
    made: gymnasium.Env = PushingEnv(simulator(), GOAL, starts(), radius=RADIUS)
    if condition == "empowerment":
        inside: Any = made.unwrapped
        bonus = {"beta": BETA, "simulator": inside.simulator, "state": lambda env: env.state}
        made = hb.EmpowermentReward(made, HORIZON, "puck", method=Kept(), **bonus)
    return Seen(made)


def distilled(environments: Any, seed: int) -> Any:
    """Adds the error of a network that learns another's output (Burda et al. 2019).

    The error is divided by a running standard deviation, and observations are in a small range.
    """
    torch = import_module("torch")
    VecEnvWrapper: Any = import_module("stable_baselines3.common.vec_env").VecEnvWrapper

    def network(outputs: int = 32) -> Any:
        layers = torch.nn.Linear(6, 64), torch.nn.ReLU(), torch.nn.Linear(64, outputs)
        return torch.nn.Sequential(*layers)

    class Distilled(VecEnvWrapper):
        def __init__(self) -> None:
            super().__init__(environments)
            torch.manual_seed(seed)
            self.target, self.learner = network(), network()
            self.optimiser = torch.optim.Adam(self.learner.parameters(), 1e-3)
            self.mean = self.square = 0.0
            self.count = 0

        def reset(self) -> Any:
            return self.venv.reset()

        def step_wait(self) -> Any:
            seen, rewards, ends, infos = self.venv.step_wait()
            reached = seen.copy()
            for row in np.flatnonzero(ends):  # what the episode ended with
                reached[row] = infos[row]["terminal_observation"]
            given = torch.as_tensor(reached)
            with torch.no_grad():
                wanted = self.target(given)
            errors = ((self.learner(given) - wanted) ** 2).mean(dim=1)
            self.optimiser.zero_grad()
            errors.mean().backward()
            self.optimiser.step()
            found = errors.detach().numpy()
            self.count += 1
            self.mean += (found.mean() - self.mean) / self.count
            self.square += ((found**2).mean() - self.square) / self.count
            scale = max(self.square - self.mean**2, 1e-12) ** 0.5
            return seen, rewards + NOVELTY * np.minimum(found / scale, 5.0), ends, infos

    return Distilled()


def run(condition: str, seed: int, steps: int = STEPS) -> pl.DataFrame:
    """One run: how many of the episodes that ended in each stretch of steps were successes."""
    agents, torch = import_module("stable_baselines3"), import_module("torch")
    BaseCallback: Any = import_module("stable_baselines3.common.callbacks").BaseCallback
    torch.set_num_threads(1)
    ended: list[tuple[int, bool]] = []

    class Episodes(BaseCallback):
        def _on_step(self) -> bool:
            for end, info in zip(self.locals["dones"], self.locals["infos"], strict=True):
                if end:
                    ended.append((self.num_timesteps, bool(info["is_success"])))
            return True

    makers: list[Callable[[], gymnasium.Env]] = [lambda: environment(condition)] * COPIES
    vectors = import_module("stable_baselines3.common.vec_env")
    environments: Any = vectors.DummyVecEnv(makers)
    environments.seed(1000 * seed)
    if condition == "distillation":
        environments = distilled(environments, seed)
    settings = {
        "n_steps": 256,
        "batch_size": 256,
        "n_epochs": 10,
        "ent_coef": 0.01,
        "learning_rate": 1e-3,
    }
    agent = agents.PPO("MlpPolicy", environments, seed=seed, device="cpu", **settings)
    start = process_time()
    agent.learn(steps, callback=Episodes())
    seconds = process_time() - start
    rows = []
    for first in range(0, steps, STRETCH):
        some = [success for step, success in ended if first < step <= first + STRETCH]
        row = {"condition": condition, "seed": seed, "steps": first + STRETCH}
        rows.append(row | {"episodes": len(some), "successes": sum(some), "seconds": seconds})
    return pl.DataFrame(rows)


def runs(seeds: int) -> None:
    """All runs that are not there yet, one seed of each condition after the other."""
    for seed in range(seeds):
        for condition in CONDITIONS:
            known = pl.read_csv(RESULTS) if RESULTS.exists() else None
            if known is not None and len(known.filter(condition=condition, seed=seed)):
                continue
            made = run(condition, seed)
            table = made if known is None else pl.concat([known, made])
            write_whole(RESULTS, table.write_csv)
            last = made.tail(4)
            share = float(last["successes"].sum()) / max(1.0, float(last["episodes"].sum()))
            print(
                f"{condition}, seed {seed}: {share:.2f} at the end, {made['seconds'][0]:.0f} s",
                flush=True,
            )


def curves(table: pl.DataFrame) -> dict[str, np.ndarray]:
    """For each condition the share of successes, float64[seeds, stretches]."""
    shares: dict[str, np.ndarray] = {}
    for condition in CONDITIONS:
        some = table.filter(condition=condition).sort("seed", "steps")
        share = some["successes"].to_numpy() / some["episodes"].to_numpy()
        shares[condition] = share.reshape(-1, STEPS // STRETCH)
    return shares


def as_table(table: pl.DataFrame) -> str:
    """The rows of the page's table."""
    lines = []
    for condition, shares in curves(table).items():
        cells = [condition, f"{len(shares)}"]
        for some in (shares.mean(axis=1), shares[:, -LAST:].mean(axis=1)):
            low, high = bootstrap_interval(some)
            cells.append(f"{some.mean():.0%} ({low:.0%} to {high:.0%})")
        seconds = table.filter(condition=condition)["seconds"].to_numpy().mean()
        lines.append(f"| {' | '.join([*cells, f'{seconds:.0f} s'])} |")
    return "\n".join(lines)


def draw(table: pl.DataFrame) -> Figure:
    """The share of successes over the steps, each run thin and their mean thick."""
    figure = new_figure(640, 360)
    ax = figure.subplots()
    steps = np.arange(STRETCH, STEPS + 1, STRETCH) / 1000
    for (condition, shares), colour in zip(curves(table).items(), COLOURS, strict=False):
        ax.plot(steps, 100 * shares.T, color=colour, linewidth=0.7, alpha=0.5)
        label = f"{condition}, {len(shares)} runs"
        ax.plot(steps, 100 * shares.mean(axis=0), color=colour, linewidth=2.2, label=label)
    ax.set(xlabel="thousand steps", ylabel="episodes that reach the goal, in %")
    ax.set(xlim=(0, STEPS / 1000), ylim=(0, 100))
    ax.grid(alpha=0.3)
    ax.legend(frameon=False, loc="upper left")
    figure.tight_layout()
    return figure


def main() -> None:
    parser = argparse.ArgumentParser(prog="research.pushing")
    parser.add_argument("part", nargs="?", choices=["runs", "figures"], default="runs")
    parser.add_argument("--seeds", type=int, default=SEEDS)
    args = parser.parse_args()
    if args.part == "runs":
        runs(args.seeds)
        return
    table = pl.read_csv(RESULTS)
    save_figure(draw(table), PICTURE)
    print(as_table(table))


if __name__ == "__main__":
    main()
