"""Agents in a world of one tool and one object learn what they learned, step by step.

What is expected comes from the edition that knew nothing of several tools and objects: the
episodes byte for byte. What is learned has other last bits on other processors, so of it the
numbers are compared.
"""

import numpy as np
import pytest
from digests import digest, run_digest

import habilis as hb
from habilis.learning.replay import play, success

BONUS = {"intrinsic": "object", "horizon": 3, "beta": 0.08}
BEFORE = [
    (
        {},
        "607885e44a10f5b0",
        [
            [-0.009896801, 52.99525],
            [-0.04460272, 2.767068],
            [0.003122821, 2.187038],
            [-0.04034847, 0.5379146],
        ],
    ),
    (
        BONUS,
        "e4233fe1bb98f804",
        [
            [-0.006228319, 52.92165],
            [-0.01662595, 2.136849],
            [0.0009350542, 1.759501],
            [-0.03026465, 0.4286545],
        ],
    ),
]


@pytest.mark.parametrize(("settings", "episodes", "learned"), BEFORE, ids=["vanilla", "object"])
def test_a_run_is_what_it_was(settings, episodes, learned):
    found, numbers = run_digest(episodes=200, **settings)
    assert found == episodes
    np.testing.assert_allclose(numbers, learned, rtol=1e-4)


FAILS = "P = picker slip 0.3\nA....\n.P...\n..C..\n.....\n....G\n"
STOCHASTIC = [
    (
        {"algorithm": "a2c", "hidden": (16,), "slip": 0.1},
        "b77b6023fbc32076",
        "f1f5616190790a7a",
        0.026108597166566404,
        -8.073525026006608,
    ),
    (
        {"algorithm": "q-learning", "learning_rate": 0.1, "starts": 3},
        "e6f8d82148f17fea",
        "8e723e885f2b71c4",
        0.0,
        -8.29123811221907,
    ),
    (
        {"algorithm": "soft-value-iteration", "slip": 0.1, **BONUS},
        "45dcb4f3ec1daff8",
        "0eb0f2ab36accadd",
        0.999999999574694,
        -8.073525026006608,
    ),
]


@pytest.mark.parametrize(
    ("settings", "episodes", "played", "succeeds", "best"),
    STOCHASTIC,
    ids=lambda value: value.get("algorithm") if isinstance(value, dict) else None,
)
def test_random_outcomes_are_what_they_were(
    settings, episodes, played, succeeds, best, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "fails.txt").write_text(FAILS)
    short = {"world": "fails.txt", "runs": 2, "steps": 8_000, "episode_limit": 60}
    run = hb.train(hb.Config.from_dict(short | settings))
    columns = [run.episodes[name].to_numpy() for name in run.episodes.columns]
    plays = [play(run, seed=seed) for seed in range(20)]
    acted = [(one.states, one.actions, one.episode_return) for one in plays]
    assert digest(*run.episodes.columns, *columns) == episodes
    assert digest(*acted) == played
    assert success(run).seen == pytest.approx(succeeds, rel=1e-9)
    assert run.best_return == pytest.approx(best, rel=1e-9)
