import numpy as np
import polars as pl
import pytest

from habilis.learning.config import Config
from habilis.learning.runs import Run
from habilis.studies.comparison import Outcome
from habilis.studies.paper.agent_statements import agent_statements
from habilis.studies.paper.curves import attached_share, equipped_share, mean_curve, returns
from habilis.studies.paper.published import EXPERIMENTS
from habilis.studies.paper.tables import Result
from habilis.worlds.world import load_world


def run(equipped, attached, counts=(100, 110, 120, 130, 140), noise=0.1):
    """Runs whose every episode of 10 steps has about so many equipped and attached steps."""
    total = sum(counts)
    of_run = np.repeat(np.arange(len(counts)), counts)
    episodes = pl.DataFrame(
        {
            "run": of_run,
            "episode": np.concatenate([np.arange(n) for n in counts]),
            "steps": np.full(total, 10),
            "return": np.full(total, -9.0),
            "equipped": equipped + noise * of_run,
            "attached": attached + noise * of_run,
        }
    )
    world = load_world("corridor")
    return Run(Config(runs=len(counts)), world, -14.0, episodes, tuple(counts), None)  # pyright: ignore[reportArgumentType]


def test_shares_are_of_steps_and_of_steps_with_the_tool():
    assert np.allclose(equipped_share(run(4, 1, noise=0)), 0.4)
    assert np.allclose(attached_share(run(4, 1, noise=0)), 0.25)
    assert np.isnan(attached_share(run(0, 0, noise=0))).all()


def test_curves_go_as_far_as_the_shortest_run():
    curves = equipped_share(run(4, 1, noise=1))
    np.testing.assert_allclose(curves, [[share] * 100 for share in (0.4, 0.5, 0.6, 0.7, 0.8)])
    assert returns(run(4, 1)).shape == (5, 100)


def test_a_mean_curve_is_over_runs_and_100_episodes_and_leaves_out_what_is_missing():
    assert len(mean_curve(np.zeros((2, 250)))) == 151
    ramp = np.stack([np.arange(250.0), np.arange(250.0) + 2])
    assert mean_curve(ramp)[0] == pytest.approx(50.5)
    ramp[0] = np.nan
    assert mean_curve(ramp)[0] == pytest.approx(51.5)
    assert np.isnan(mean_curve(np.full((1, 100), np.nan))).all()


def relations(vanilla, foe, toe):
    runs = {"table1": (vanilla, foe, toe), "table2": [run(10, 1)] * 4}
    results = {
        e.name: [Result.of(row, r) for row, r in zip(e.rows, runs[e.name], strict=True)]
        for e in EXPERIMENTS
    }
    return {relation.text: relation for relation in agent_statements(results)}


def test_the_stated_orders_and_all_of_figure_2_are_looked_at():
    found = relations(run(1, 0), run(5, 2), run(3, 1))
    assert len(found) == 7 + 6


def test_figure_2_holds_in_the_papers_order_and_not_in_another():
    """Equipped in the paper's order, attached in the reverse order, and the other way round."""
    low_high = relations(run(2, 1.8), run(8, 1), run(4, 1.5))
    high_low = relations(run(8, 0.5), run(2, 1.9), run(4, 1.5))
    for text in low_high:
        if text.startswith("Figure 2"):
            about_attached = "attached" in text
            assert (low_high[text].outcome is Outcome.HOLDS) != about_attached, text
            if "vanilla" in text:
                assert (high_low[text].outcome is Outcome.HOLDS) == about_attached, text


def test_the_opposite_of_figure_2_is_called_so():
    reverse = relations(run(8, 7), run(2, 0.1), run(5, 2))
    assert {c.outcome for text, c in reverse.items() if text.startswith("Figure 2")} == {
        Outcome.OPPOSITE
    }


def test_equal_shares_are_no_order():
    same = relations(run(3, 1), run(3, 1), run(3, 1))
    assert {c.outcome for text, c in same.items() if text.startswith("Figure 2")} == {
        Outcome.UNDECIDED
    }


def test_an_order_holds_only_if_it_is_separated():
    slow, fast = run(1, 0, (900, 902, 905, 910, 920)), run(1, 0, (100, 102, 105, 110, 120))
    order = "Table I: “A2C with 6-step TOE” converges before “A2C”"
    assert relations(slow, slow, fast)[order].outcome is Outcome.HOLDS
    assert relations(fast, slow, slow)[order].outcome is Outcome.OPPOSITE
    wide = run(1, 0, (100, 905, 911, 1400, 1500))
    assert relations(slow, slow, wide)[order].outcome is Outcome.UNDECIDED
    assert relations(slow, slow, slow)[order].outcome is Outcome.UNDECIDED
