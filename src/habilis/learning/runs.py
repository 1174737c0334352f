"""Runs: what training gives, and how far it has come."""

import time
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import polars as pl
from jaxtyping import Bool, Float32, Float64, Int

from habilis.learning.config import Config
from habilis.learning.convergence import MARGIN, Averages
from habilis.learning.episodes import Ledger
from habilis.learning.sources import Source, map_of
from habilis.mdp import TabularMDP
from habilis.reprs import counted, number, quietly, short, unfailing
from habilis.worlds.world import World


@dataclass(frozen=True, eq=False)
class Run:
    """The results of training one configuration.

    Attributes:
        config: the configuration.
        world: its world, with the tool that was used; or its table.
        best_return: extrinsic return of a shortest plan; in a stochastic world, or of a table, what
            the best policy expects of an episode.
        episodes: one row an episode of each run: "run", "episode" (both from 0), "steps",
            "return" (extrinsic, undiscounted), and for each flag of the table the number of
            its steps that led to a state with that flag ("equipped", "attached").
        converged_at: for each run the episodes to convergence, `None` if it did not.
        parameters: what the runs learned, stacked along the first axis (a `Network`, or Q[S, A]),
            each as it was after the stretch of training in which its run ended.
    """

    config: Config
    world: Source
    best_return: float
    episodes: pl.DataFrame
    converged_at: tuple[int | None, ...]
    parameters: Any

    @unfailing
    def __repr__(self) -> str:
        return short("Run", *self._described())

    @quietly
    def _repr_svg_(self) -> str:
        """The learning curve, for notebooks."""
        from habilis.learning.curves import learning_curve
        from habilis.learning.curves_picture import curves_figure
        from habilis.worlds.pictures.figures import figure_svg

        curves = {self.world.name: learning_curve(self)}
        return figure_svg(curves_figure(curves, [self.best_return]))

    def _described(self) -> list[str]:
        config, ends = self.config, [at for at in self.converged_at if at is not None]
        count, values = len(self.converged_at), config.as_dict()
        bonus = f"{config.intrinsic}, weight {config.beta:g}" if config.beta else "no bonus"
        after = f", after {np.mean(ends):,.0f} episodes on average" if ends else ""
        return [
            self.world.name,
            f"{values['algorithm']}, {bonus}",
            f"{counted(count, 'run')}, {counted(len(self.episodes), 'episode')}",
            f"{len(ends)} of {count} converged{after}",
            f"best return {number(self.best_return)}",
        ]

    @property
    def mdp(self) -> TabularMDP:
        """The table that it was trained on, whose states `policy` is of."""
        from habilis.learning.replay import table_of

        return table_of(self)

    def policy(self, index: int = 0) -> Float64[np.ndarray, "S A"]:
        """The policy that one of its runs learned, as `effective_empowerment` takes it.

        Args:
            index: which run, from 0.

        Returns:
            float64[S, A], the probability of each action in every state of `mdp`. Q-learning's is
            the greedy policy.

        Raises:
            ValueError: there is no such run.

        Example:
            >>> import habilis as hb
            >>> run = hb.train(hb.Config(world="yard", runs=1, episodes=20))
            >>> policy = run.policy()
            >>> bits = hb.effective_empowerment(run.mdp, policy, 0.9, "object", [run.mdp.start])
        """
        from habilis.learning.replay import check_index, learned

        check_index(self, index)
        policy = learned(self, self.mdp, index)[0].astype(np.float64)
        return policy / policy.sum(axis=1, keepdims=True)

    @property
    def map(self) -> World:
        """Its world.

        Raises:
            ValueError: it was trained on a table that no map was made of.
        """
        return map_of(self.world)


@dataclass(frozen=True)
class Progress:
    """How far the runs of one configuration have come.

    Attributes:
        config: its index in the call to `train`.
        episodes: mean over the runs.
        share: of all the episodes the runs may take, or less where runs have converged.
        episode_return: mean over the runs of their last 100 episodes.
        steps_per_second: environment steps of all runs, learning included, since they began.
        seconds_left: at most, if the rest takes its whole budget of episodes.
        converged, ended, runs: how many runs have converged, have ended, and there are.
    """

    config: int
    episodes: float
    share: float
    episode_return: float
    steps_per_second: float
    seconds_left: float
    converged: int
    ended: int
    runs: int


RECENT = 1_000
"""How many of a stretch's last transitions are remembered."""


class Metrics(NamedTuple):
    """Metrics of a run after some stretch of training; NaN where there are none.

    Step and episode count from the run's beginning, the time is in seconds since 1970. Return and
    length are means over the last 100 episodes; the loss is the mean over the stretch; entropy of
    the policy (in nats) and bonus (the intrinsic value of the state entered, before its weight
    beta) are means over the stretch's last `RECENT` transitions. The speed counts the steps of this
    run since it began or was taken up again, learning and waiting included.
    """

    step: float
    time: float
    episode: float
    episode_return: float
    episode_length: float
    loss: float
    entropy: float
    bonus: float
    beta: float
    steps_per_second: float


class Stretch(NamedTuple):
    """The record of a chunk of training besides its episodes."""

    loss: float
    transitions: Int[np.ndarray, "n"]


class Gain(NamedTuple):
    """The additions of a chunk of training to a record, and its unfinished sums."""

    last: Stretch
    steps: int
    episodes: Float32[np.ndarray, "n columns"]
    running: Float64[np.ndarray, "E columns"]
    averages: Averages
    converged_at: int | None


class Rows:
    """Rows that become more; adding some costs as much as they are, however many there are."""

    def __init__(self, rows: np.ndarray):
        self._rows, self._count = rows, len(rows)

    def __len__(self) -> int:
        return self._count

    def add(self, rows: np.ndarray) -> None:
        count = self._count + len(rows)
        if count > len(self._rows):
            wider = np.empty((max(count, 2 * self._count), self._rows.shape[1]), self._rows.dtype)
            wider[: self._count] = self.all()
            self._rows = wider
        self._rows[self._count : count] = rows
        self._count = count

    def all(self) -> np.ndarray:
        return self._rows[: self._count]

    def keep(self, count: int) -> None:
        """Drops what comes after the first rows, and the room for more."""
        self._rows = self._rows[: min(count, self._count)].copy()
        self._count = len(self._rows)


class Record:
    """One run so far: its episodes, and whether it is over.

    Attributes:
        began: when its first stretch of training in this process did.
        steps: environment steps taken.
        before: steps and episodes that an earlier process had come to.
        last: of its stretches in this process.
        running: float64[E, 2 + flags], sums over the episodes that have not ended.
        ended: whether it is over.
        converged_at: episodes to convergence, `None` if it has not converged.
    """

    def __init__(self, config: Config, best_return: float, ledger: Ledger, margin: float = MARGIN):
        self.config = config
        self.best_return = best_return
        self.margin = margin
        self.ledger = ledger
        self.began: float | None = None
        self.steps = 0
        self.before = (0, 0)
        self.last: Stretch | None = None
        self.running = ledger.nothing(config.algorithm.envs)
        self.ended = False
        self.converged_at: int | None = None
        self._averages = Averages.of()
        self._episodes = Rows(np.empty((0, self.running.shape[1]), np.float32))
        self._metrics = Rows(np.empty((0, len(Metrics._fields))))

    @property
    def count(self) -> int:
        return len(self._episodes)

    def episodes(self) -> np.ndarray:
        """float32[n, 2 + flags]: steps, return, and counts of the flags, an episode a row."""
        return self._episodes.all()

    def metrics(self) -> np.ndarray:
        """float64[n, fields]: `Metrics` for each stretch for which they were noted."""
        return self._metrics.all()

    def note(self, metrics: Metrics) -> None:
        self._metrics.add(np.array([metrics], np.float64))

    def restore(
        self, steps: int, running: np.ndarray, episodes: np.ndarray, metrics: np.ndarray
    ) -> None:
        """Goes back to what an earlier process had come to."""
        self.steps, self.running = steps, running
        self._episodes, self._metrics = Rows(episodes), Rows(metrics)
        self.before = steps, len(episodes)
        self._averages, at = self._looked_at(Averages.of(), episodes)
        self._end_if_over(at)

    def gain(
        self,
        transition: Int[np.ndarray, "T E"],
        truncated: Bool[np.ndarray, "T E"],
        loss: float,
    ) -> Gain:
        """The additions of a chunk of training; free of side effects, so any thread may compute it.

        Args:
            transition, truncated: what the environments did.
            loss: its mean.
        """
        ended, running = self.ledger.entries(self.running, transition, truncated)
        episodes = ended.astype(np.float32)
        averages, at = self._looked_at(self._averages, episodes)
        made = transition[transition >= 0]
        last = Stretch(loss, made[-RECENT:].copy())
        return Gain(last, made.size, episodes, running, averages, at)

    def add(self, gain: Gain) -> None:
        """Takes in what a stretch of training gave, and ends the run if that was its last."""
        self.last, self.running, self._averages = gain.last, gain.running, gain.averages
        self.steps += gain.steps
        self._episodes.add(gain.episodes)
        self._end_if_over(gain.converged_at)

    def stop(self) -> None:
        """Ends the run as one that has not converged, if it has not ended."""
        if not self.ended:
            self.ended = True
            self._episodes.keep(self.count)

    def _looked_at(self, before: Averages, more: np.ndarray) -> tuple[Averages, int | None]:
        """Goes on with the averages; episodes beyond the budget do not count."""
        within = more[: max(0, self.config.episodes - before.episodes), 1]
        return before.after(within, self.best_return, self.margin)

    def _end_if_over(self, at: int | None) -> None:
        budget = self.config.episodes
        if at is not None or self.count >= budget or self.steps >= self.config.steps:
            self.ended, self.converged_at = True, at
            self._episodes.keep(budget if at is None else at)


def progress(config: int, records: list[Record]) -> Progress:
    """How far the records of one configuration have come."""
    budget = records[0].config.episodes
    counts = np.array([record.count for record in records])
    ended = np.array([record.ended for record in records])
    done, total = counts.sum(), np.where(ended, counts, budget).sum()
    steps_before, done_before = np.sum([record.before for record in records], axis=0)
    began = [record.began for record in records if record.began is not None]
    seconds = time.perf_counter() - min(began)
    recent = [record.episodes()[-100:, 1] for record in records if record.count]
    return Progress(
        config=config,
        episodes=float(counts.mean()),
        share=float(done / total),
        episode_return=float(np.mean([r.mean() for r in recent])) if recent else float("nan"),
        steps_per_second=float(sum(record.steps for record in records) - steps_before) / seconds,
        seconds_left=float(seconds * (total - done) / (done - done_before))
        if done > done_before
        else float("inf"),
        converged=sum(record.converged_at is not None for record in records),
        ended=int(ended.sum()),
        runs=len(records),
    )


def episode_table(records: list[Record], flags: list[str]) -> pl.DataFrame:
    """`Run.episodes` of the records of one configuration."""
    parts = []
    for run, record in enumerate(records):
        episodes = record.episodes()
        columns = {
            "run": np.full(len(episodes), run, np.int32),
            "episode": np.arange(len(episodes), dtype=np.int32),
            "steps": episodes[:, 0].astype(np.int32),
            "return": episodes[:, 1],
        }
        columns |= {name: episodes[:, 2 + k].astype(np.int32) for k, name in enumerate(flags)}
        parts.append(pl.DataFrame(columns))
    return pl.concat(parts)
