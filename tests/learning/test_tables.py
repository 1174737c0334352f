"""Tables that no map was made of are trained on as worlds are: arrays, files, environments."""

import json
from dataclasses import replace

import numpy as np
import pytest

import habilis as hb
from habilis.cli import main
from habilis.learning.folder import load_latest, load_run
from habilis.learning.replay import best_return_from, expected_return, play
from habilis.learning.sources import NamedTable, source_of
from habilis.learning.training_problem import DEFAULT_CONDITIONS, best_return, margin, prepared
from habilis.sweeps import results, sweep
from habilis.worlds.plans import best_returns, policy_returns

PRIZES = hb.TabularMDP.deterministic(
    [[0, 1], [0, 2], [1, 3], [3, 3]],
    reward=[[0, 0], [0.5, 0], [0, 1], [0, 0]],
    terminal=[False, False, False, True],
)
"""To go right three times earns 1. To go back and forth on the left earns more: 0.5 each time."""
QUICK = {"algorithm": "q-learning", "runs": 2, "episodes": 300, "episode_limit": 20, "seed": 1}


def table_of(run):
    assert isinstance(run.world, NamedTable)
    return run.world


def same(one, other):
    return one.episodes.equals(other.episodes) and one.converged_at == other.converged_at


def test_an_array_and_its_file_train_the_same(tmp_path):
    PRIZES.save(tmp_path / "prizes.npz")
    run = hb.train(hb.Config(world=PRIZES).changed(**QUICK))
    read = hb.train(hb.Config(world=str(tmp_path / "prizes.npz")).changed(**QUICK))
    assert same(run, read)
    assert (run.world.name, read.world.name) == ("table", "prizes")
    assert run.world == replace(table_of(read), name="table")


def test_the_best_return_is_that_of_value_iteration_under_the_limit():
    table = NamedTable.of("prizes", PRIZES)
    for limit, best in ((1, 0.0), (2, 0.5), (3, 1.0), (5, 1.5), (6, 1.5), (7, 2.0)):
        assert best_return(table, DEFAULT_CONDITIONS, limit) == best


def test_a_policys_return_is_the_mean_over_all_its_episodes():
    random = np.random.default_rng(0)
    P = random.dirichlet(np.ones(3), size=(3, 2))
    reward = random.normal(size=(3, 2))
    mdp = hb.TabularMDP.stochastic(P, reward, terminal=[False, False, True])
    policy = random.dirichlet(np.ones(2), size=3)

    def value(state, steps):
        if not steps:
            return 0.0
        return sum(
            policy[state, a]
            * (
                mdp.reward[state, a]
                + sum(P[state, a, to] * value(to, steps - 1) for to in range(2))
            )
            for a in range(2)
        )

    returns = policy_returns(mdp, policy, 4)
    assert returns == pytest.approx([value(state, 4) for state in range(3)], abs=1e-6)
    assert (best_returns(mdp, 4) >= returns - 1e-9).all()


def test_close_is_a_share_of_what_there_is_to_gain():
    table = NamedTable.of("prizes", PRIZES)
    uniform = policy_returns(PRIZES, np.full((4, 2), 0.5), 3)[0]
    assert margin(table, DEFAULT_CONDITIONS, 3) == pytest.approx(0.05 * (1 - uniform))
    assert margin(hb.load_world("yard"), DEFAULT_CONDITIONS, 500) == 0.9


def test_small_rewards_are_scaled_up_and_others_are_left():
    a2c = hb.Config(world=PRIZES)
    config, table = prepared(a2c)
    gain = margin(table, DEFAULT_CONDITIONS, a2c.episode_limit) / 0.05
    assert gain > 20
    assert config == a2c
    few = hb.Config(world=PRIZES, episode_limit=5)
    scaled, _ = prepared(few)
    gain = margin(table, DEFAULT_CONDITIONS, 5) / 0.05
    assert scaled.algorithm.reward_scale == pytest.approx(2 / gain)
    chosen = few.changed(reward_scale=0.3)
    assert prepared(chosen)[0] == chosen


def test_a_run_is_kept_read_back_resumed_and_played(tmp_path):
    config = hb.Config(world=PRIZES).changed(**QUICK)
    run = hb.train(config, out=tmp_path / "run")
    read = load_run(tmp_path / "run")
    assert same(run, read)
    assert read.world == run.world
    assert same(hb.train(config, out=tmp_path / "run", resume=True), run)
    assert (
        table_of(load_latest(tmp_path / "run")).mdp.next_state.tolist()
        == PRIZES.next_state.tolist()
    )
    episode = play(read)
    assert episode.episode_return == pytest.approx(expected_return(read))
    assert best_return_from(read, 0) == read.best_return == 5.0
    other = hb.Config(world=PRIZES.slippery(0.1)).changed(**QUICK)
    with pytest.raises(ValueError, match="was started with world 'table:"):
        hb.train(other, out=tmp_path / "run", resume=True)


def test_a_run_on_a_table_has_no_map(tmp_path):
    run = hb.train(hb.Config(world=PRIZES).changed(**QUICK))
    with pytest.raises(ValueError, match="the run was trained on a table, which has no map"):
        _ = run.map


def test_tables_are_swept_over_and_read_back(tmp_path):
    configs = [hb.Config(world=PRIZES).changed(**QUICK, discount=gamma) for gamma in (0.5, 0.9)]
    made = sweep(configs, tmp_path / "sweep")
    assert made["best_return"].unique().to_list() == [5.0]
    assert results(tmp_path / "sweep")["final_return"].to_list() == made["final_return"].to_list()
    assert len([*(tmp_path / "sweep" / "tables").iterdir()]) == 1
    again = sweep(configs, tmp_path / "sweep", resume=True)
    assert again["final_return"].to_list() == made["final_return"].to_list()


@pytest.mark.parametrize("algorithm", ["a2c", "q-learning"])
def test_a_frozen_lake_is_crossed_almost_as_often_as_can_be(algorithm):
    pytest.importorskip("gymnasium")
    config = hb.Config(
        world="gym:FrozenLake-v1", intrinsic="agent", horizon=3, beta=0.05, earned="difference"
    ).changed(algorithm=algorithm, runs=2)
    run = hb.train(config)
    assert run.config.episode_limit == 100
    assert run.best_return == pytest.approx(0.7442, abs=1e-4)
    assert max(expected_return(run, index) for index in range(2)) > 0.7442 - 0.03


def test_the_command_line_trains_and_watches_tables(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    PRIZES.save("prizes.npz")
    quick = ["--algorithm", "q-learning", "--episodes", "300", "--runs", "1"]
    quick += ["--episode-limit", "20"]
    assert main(["train", "prizes.npz", *quick, "--out", "run", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["best_return"] == 5.0
    main(["watch", "run", "--json"])
    shown = json.loads(capsys.readouterr().out)
    assert shown["best"] == 5.0
    assert shown["expected"] == pytest.approx(shown["return"])
    main(["watch", "run"])
    assert "the policy expects a return of" in capsys.readouterr().out
    monkeypatch.setattr("habilis.cli.watch.LISTED", 2)
    main(["watch", "run"])
    states, actions, *_ = capsys.readouterr().out.splitlines()
    assert states.startswith("states 0, ")
    assert states.endswith(f", and {shown['steps'] - 1} more")
    assert actions == f"{shown['actions'][0]}, {shown['actions'][1]}, and {shown['steps'] - 2} more"
    assert main(["watch", "run", "--gif", "x.gif"]) == 2
    assert "trained on a table, which has no pictures; leave out --gif" in capsys.readouterr().err


REFUSED = [
    (
        {"world": PRIZES, "starts": 3},
        "table is not a map, on which things could be elsewhere; leave out",
    ),
    (
        {"world": PRIZES, "tool": "broom"},
        "table is not a map, and has no tool to replace",
    ),
    (
        {"world": hb.TabularMDP.deterministic([[0, 0]])},
        "table has no rewards, so there is nothing to learn",
    ),
    ({"world": "missing.npz"}, r"missing\.npz: cannot be read"),
    ({"world": "gym:Nothing-v0"}, "gym:Nothing-v0 cannot be made"),
    (
        {"world": "table:12345"},
        "world is 'table:12345', which only the folder of its run has; give",
    ),
]


@pytest.mark.parametrize(("settings", "message"), REFUSED)
def test_what_cannot_be_trained_on_is_refused_in_one_line(settings, message):
    with pytest.raises(ValueError, match=message) as refusal:
        hb.train(hb.Config(**settings))
    assert "\n" not in str(refusal.value)


def test_a_table_that_no_configuration_changes_is_one_source():
    first, second = (source_of(hb.Config(world=PRIZES)) for _ in range(2))
    assert first == second
    assert hash(first) == hash(second)
    assert first != source_of(hb.Config(world=PRIZES.slippery(0.1)))


def test_a_puzzle_is_trained_on_and_watched_as_it_is_drawn(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rod.pwp").write_text("A M1 M1 AW M0 G0 .\n. . . W . . .\n")
    quick = ["--algorithm", "q-learning", "--episodes", "400", "--runs", "1"]
    assert main(["train", "rod.pwp", *quick, "--episode-limit", "50", "--out", "run"]) == 0
    capsys.readouterr()
    assert main(["watch", "run", "--gif", "rod.gif"]) == 0
    shown = capsys.readouterr().out
    assert ". . A 1 1 0G. " in shown
    assert "right, right" in shown
    assert (tmp_path / "rod.gif").read_bytes().startswith(b"GIF")
    (tmp_path / "rod.pwp").unlink()
    assert main(["watch", "run"]) == 0
    assert "states 0, " in capsys.readouterr().out
    assert main(["watch", "run", "--gif", "again.gif"]) == 2
    assert "rod.pwp" in capsys.readouterr().err


def test_tables_that_differ_in_what_observations_show_are_different_problems():
    chain = hb.TabularMDP.deterministic(
        [[max(s - 1, 0), min(s + 1, 5)] for s in range(6)],
        reward=[[-1, 10 if s == 4 else -1] for s in range(6)],
        terminal=[s == 5 for s in range(6)],
    )
    labelled = replace(chain, factors={"x": np.arange(6, dtype=np.int32)})
    others = [
        replace(labelled, shape=(2, 3), cells=frozenset({"x"})),
        replace(chain, factors={"x": np.arange(6, dtype=np.int32)[::-1].copy()}),
        replace(labelled, actions=("left", "right")),
        replace(labelled, start=1),
        chain,
    ]
    digests = [NamedTable.of("chain", mdp).digest for mdp in (labelled, *others)]
    assert len({*digests}) == len(digests)
    settings = {"observation": "coordinates", "episodes": 100, "runs": 1, "episode_limit": 30}
    config = hb.Config(world=others[0]).changed(**settings)
    alone = hb.train(config)
    hb.train(hb.Config(world=labelled).changed(**settings))
    assert same(hb.train(config), alone)
    assert table_of(alone).mdp.shape == (2, 3)


def test_the_best_return_of_a_stochastic_table_is_that_of_a_search_of_all_decisions():
    random = np.random.default_rng(3)
    P = random.dirichlet(np.ones(3), size=(3, 2))
    mdp = hb.TabularMDP.stochastic(P, random.normal(size=(3, 2)), terminal=[False, False, True])

    def best(state, steps):
        if not steps:
            return 0.0
        later = [best(to, steps - 1) for to in range(2)] + [0.0]
        return max(mdp.reward[state, a] + P[state, a] @ later for a in range(2))

    for limit in range(5):
        expected = [best(state, limit) for state in range(3)]
        assert best_returns(mdp, limit) == pytest.approx(expected, abs=1e-6)


@pytest.mark.ill_typed
def test_a_model_in_the_place_of_its_table_is_refused():
    with pytest.raises(ValueError, match=r"world is \{\}; give a name, a path or a table"):
        hb.Config(world={})  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize("limit", [1, 50])
def test_where_nothing_can_be_gained_there_is_nothing_to_learn(tmp_path, limit):
    text = "A . . . G0 M0\n" if limit == 1 else "A . . M0 W G0\n"
    (tmp_path / "far.pwp").write_text(text)
    config = hb.Config(world=str(tmp_path / "far.pwp")).changed(rollout=1, episode_limit=limit)
    with pytest.raises(ValueError, match=f"every policy earns -{limit} within {limit} steps, so"):
        hb.train(config)
