"""Agents in a world of one tool and one object learn what they learned, step by step.

What is expected comes from the edition that knew nothing of several tools and objects: the
episodes byte for byte. What is learned has other last bits on other processors, so of it the
numbers are compared.
"""

import numpy as np
import pytest
from digests import run_digest

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
