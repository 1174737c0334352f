"""Research on maps: random play, and a map of another reading."""

from pathlib import Path

import numpy as np
import polars as pl
import pytest

from habilis.mdp import TabularMDP
from habilis.studies.paper.numbers import measure
from habilis.studies.paper.targets import load_targets
from habilis.studies.paper.worlds import CachedWorld
from habilis.worlds.table import tabulate
from habilis.worlds.world import World, load_world
from research import random_play

RESEARCH = Path(__file__).parents[2] / "research"


def test_random_play_is_a_walk_of_the_table():
    """From 0 to the goal 2 by way of 1, or to 3, from which nothing leads on."""
    mdp = TabularMDP.deterministic([[1, 3], [0, 2], [2, 2], [3, 3]], terminal=[0, 0, 1, 0])
    assert random_play.random_play(mdp, 1) == (0.0, 0.5)
    assert random_play.random_play(mdp, 2) == (0.25, 0.5)
    assert random_play.random_play(mdp, 4) == (pytest.approx(0.3125), pytest.approx(0.625))


@pytest.mark.parametrize("tool", ["picker", "broom"])
def test_the_results_are_those_of_the_maps(tool):
    results = pl.read_csv(random_play.RESULTS).filter(world="yard-b")
    found = random_play.random_play(tabulate(load_world("yard-b", tool)))
    wanted = results.select(f"{tool}_reached", f"{tool}_lost").row(0)
    np.testing.assert_allclose(found, wanted, atol=1e-5)


def test_a_yard_in_which_a_picker_pushes_and_sweeps_meets_all_numbers():
    path = RESEARCH / "results" / "yard-pushes-sweeps.txt"
    scene = CachedWorld(World.parse(path.read_text(), "yard"))
    numbers = load_targets("yard-all").numbers
    assert len(numbers) == 11
    assert [n.text for n in numbers if n.miss(measure(scene, n))] == []
