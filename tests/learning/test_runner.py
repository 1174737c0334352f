import jax
import numpy as np
import polars as pl
import pytest

from habilis.empowerment import empowerment
from habilis.learning.algorithms.a2c import A2C
from habilis.learning.config import Config
from habilis.learning.intrinsic import value_table
from habilis.learning.runner import train
from habilis.learning.runs import Progress
from habilis.worlds.table import tabulate
from habilis.worlds.world import load_world

# A corner to push a can into: learned within seconds.
ROOM = "A.\nC.\n..\nG.\n"


@pytest.fixture
def room(tmp_path):
    path = tmp_path / "room.txt"
    path.write_text(ROOM)
    return Config(
        algorithm=A2C(learning_rate=2e-3, optimizer="rmsprop", reward_scale=1.0, hidden=(16,)),
        world=str(path),
        runs=1,
        episodes=2_500,
        episode_limit=50,
    )


def same(run, other, index, other_index):
    """Whether a run of one configuration is, bit for bit, a run of another."""
    a, b = (r.episodes.filter(run=i).drop("run") for r, i in ((run, index), (other, other_index)))
    leaves = zip(jax.tree.leaves(run.parameters), jax.tree.leaves(other.parameters), strict=True)
    return a.equals(b) and all(np.array_equal(x[index], y[other_index]) for x, y in leaves)


def test_a_run_is_the_same_whatever_trains_beside_it(room):
    short = room.changed(episodes=300)
    alone = train(short)
    many = train(short.changed(runs=7))
    other = short.changed(intrinsic="object", horizon=2, beta=0.1, learning_rate=1e-3, runs=2)
    beside, first = train([other, short])
    assert same(alone, many, 0, 0)
    assert same(alone, first, 0, 0)
    assert not same(alone, beside, 0, 0)
    assert not same(many, many, 0, 5)


def test_a_run_that_ends_early_does_not_change_those_beside_it(room):
    brief, long = room.changed(episodes=50), room.changed(episodes=400)
    _, beside = train([brief, long])
    assert same(beside, train(long), 0, 0)


def test_another_seed_is_another_run(room):
    short = room.changed(episodes=100)
    assert not same(train(short), train(short.changed(seed=1)), 0, 0)


def test_it_learns_to_push_the_can_into_the_bin(room):
    run = train(room.changed(runs=2, episodes=20_000))
    assert run.best_return == -1
    assert all(at is not None for at in run.converged_at)
    last = run.episodes.group_by("run").agg(pl.col("return").tail(100).mean())
    assert (last["return"] > -1.9).all()


def test_a_run_ends_with_the_episode_in_which_it_converged(room):
    run = train(room.changed(episodes=20_000))
    assert run.converged_at[0] == run.episodes.height


def test_a_run_that_does_not_converge_uses_its_budget_and_is_kept(room):
    by_episodes = train(room.changed(episodes=321))
    assert by_episodes.converged_at == (None,)
    assert by_episodes.episodes.height == 321
    by_steps = train(room.changed(episodes=10**9, steps=1))
    assert by_steps.converged_at == (None,)
    assert by_steps.episodes.height > 0


def test_episodes_say_what_happened(room):
    episodes = train(room.changed(episodes=300)).episodes
    assert episodes.columns == ["run", "episode", "steps", "return", "equipped", "attached"]
    assert (episodes["episode"].to_numpy() == np.arange(300)).all()
    assert episodes["steps"].is_between(2, 50).all()
    finished = episodes.filter(pl.col("steps") < 50)
    assert finished.height > 0
    assert (finished["return"] == -(finished["steps"] - 1)).all()
    assert (episodes["equipped"] == 0).all()


def test_the_intrinsic_value_is_the_empowerment():
    mdp = tabulate(load_world("corridor"))
    config = Config(intrinsic="object", horizon=3, beta=0.07)
    np.testing.assert_array_equal(value_table(mdp, config), empowerment(mdp, 3, "object"))
    for other in ("none", "count", "rnd"):
        horizon, beta = (0, 0.0) if other == "none" else (3, 0.1)
        changed = config.changed(intrinsic=other, horizon=horizon, beta=beta)
        assert not value_table(mdp, changed).any()


def test_progress_is_reported_until_the_end(room):
    reported: list[Progress] = []
    train(room.changed(episodes=200, runs=6), reported.append)
    assert reported[-1].ended == reported[-1].runs == 6
    assert reported[-1].share == 1
    assert reported[-1].steps_per_second > 0


def test_a_goal_out_of_reach_is_refused(tmp_path):
    (tmp_path / "walled.txt").write_text("AC#G\n")
    with pytest.raises(ValueError, match=r"walled.txt: the goal cannot be reached"):
        train(Config(world=str(tmp_path / "walled.txt")))


def test_a_loss_that_is_not_finite_stops_the_run(room):
    with pytest.raises(FloatingPointError, match="lower learning_rate"):
        train(room.changed(learning_rate=1e30, clip=1e30))


@pytest.mark.ill_typed
@pytest.mark.parametrize(
    ("field", "value", "fix"),
    [
        ("runs", 0, "runs is 0; give at least 1"),
        ("horizon", -1, "horizon is -1; give at least 0"),
        ("horizon", 3, "horizon is 3 and intrinsic 'none', which has none"),
        ("learning_rate", 0.0, "give a number above 0"),
        ("learning_rate", float("nan"), "give a finite number"),
        ("discount", 1.5, "from 0 to 1"),
        ("beta", float("inf"), "finite"),
        ("optimizer", "sgd", "use one of rmsprop, rmsprop-torch, adam"),
        ("runs", 1.5, "give a whole number"),
        ("runs", "3", "give a whole number"),
        ("entropy", float("inf"), "give a finite number"),
        ("seed", 2**32, "give one below 4294967296"),
        ("world", 3, "world is 3; give a name, a path or a table"),
        ("beta", 0.1, "give both the reward and its weight"),
        ("intrinsic", "object", "give both the reward and its weight"),
        ("hidden", (), "at least one width"),
        ("rollout", 1000, "no longer than an episode"),
        ("envs", 10**20, "give at most 2,000,000,000"),
        ("runs", 10**12, "give at most 2,000,000,000"),
        ("hidden", (True,), "width from 1 to 65,536"),
        ("tool", 5, "give its name"),
    ],
)
def test_a_setting_out_of_range_is_refused(field, value, fix):
    with pytest.raises(ValueError, match=fix):
        Config().changed(**{field: value})


def test_an_empowerment_that_is_nothing_is_no_reward():
    with pytest.raises(ValueError, match="give a horizon of at least 1"):
        Config(intrinsic="object", beta=0.1)


def test_an_unknown_setting_is_refused_with_those_there_are():
    with pytest.raises(ValueError, match=r"'learningrate' is unknown; use some of .*learning_rate"):
        Config.from_dict({"learningrate": 1})
