from dataclasses import replace

import numpy as np
import polars as pl
import pytest

from habilis.learning.config import Config
from habilis.learning.runs import Run
from habilis.studies.curves import attached_share, equipped_share, mean_return, smooth
from habilis.studies.learned import learned_relations
from habilis.studies.published import EXPERIMENTS
from habilis.studies.tables import Result
from habilis.worlds.world import load_world


def run(equipped, attached, counts=(100, 110)):
    """Runs whose every episode of 10 steps has so many equipped and attached steps."""
    total = sum(counts)
    episodes = pl.DataFrame(
        {
            "run": np.repeat(np.arange(len(counts)), counts),
            "episode": np.concatenate([np.arange(n) for n in counts]),
            "steps": np.full(total, 10),
            "return": np.full(total, -9.0),
            "equipped": np.full(total, equipped),
            "attached": np.full(total, attached),
        }
    )
    world = load_world("corridor")
    return Run(Config(runs=len(counts)), world, -14.0, episodes, tuple(counts), None)  # pyright: ignore[reportArgumentType]


def test_shares_are_of_steps_and_of_steps_with_the_tool():
    assert np.allclose(equipped_share(run(4, 1)), 0.4)
    assert np.allclose(attached_share(run(4, 1)), 0.25)
    assert np.allclose(attached_share(run(0, 0)), 0)


def test_means_over_runs_go_as_far_as_the_shortest():
    mixed = run(4, 1)
    episodes = mixed.episodes.with_columns(pl.col("run").alias("return").cast(float))
    mixed = replace(mixed, episodes=episodes)
    np.testing.assert_allclose(mean_return(mixed), np.full(100, 0.5))


def test_smoothing_is_over_100_episodes():
    assert len(smooth(np.arange(250.0))) == 151
    assert smooth(np.arange(250.0))[0] == pytest.approx(49.5)


def relations(vanilla, foe, toe):
    runs = {"table1": (vanilla, foe, toe), "table2": [run(10, 1)] * 4}
    results = {
        e.name: [Result.of(row, r) for row, r in zip(e.rows, runs[e.name], strict=True)]
        for e in EXPERIMENTS
    }
    return {relation.text: relation for relation in learned_relations(results)}


def test_every_pair_of_rows_and_all_of_figure_2_are_looked_at():
    found = relations(run(1, 0), run(5, 2), run(3, 1))
    assert len(found) == 3 + 6 + 6


def test_figure_2_holds_in_the_papers_order_and_not_in_another():
    as_published = relations(run(1, 0), run(5, 4), run(3, 1))
    reversed_ = relations(run(5, 4), run(1, 0), run(3, 1))
    for text, relation in as_published.items():
        if text.startswith("Figure 2"):
            assert relation.holds, text
            assert not (reversed_[text].holds and "vanilla" in text), text


def test_an_order_holds_only_if_it_is_separated_and_all_runs_converged():
    slow, fast = run(1, 0, (900, 905, 910)), run(1, 0, (100, 105, 110))
    order = "Table I: “A2C with 6-step TOE” converges before “A2C”"
    assert relations(slow, slow, fast)[order].holds
    assert not relations(fast, slow, slow)[order].holds
    assert not relations(slow, slow, run(1, 0, (100, 905, 1400)))[order].holds
    assert not relations(slow, slow, replace(fast, converged_at=(100, None, 110)))[order].holds
