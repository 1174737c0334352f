"""The settings that the calibration tries: a seeded design over what a learner is made of.

A *structure* is what the compiled program depends on: how many environments, how long a rollout,
optimiser, networks, what they are shown. Two structures, of which earlier prototypes said most,
have thirty settings each; fourteen more are drawn, with six settings each; and there are the
presets of `habilis.learning.presets`. Everything is drawn from one seed, so that the list is the
same everywhere.

    python -m research.pace.design      # prints it
"""

from typing import Any

import numpy as np

from habilis.learning.config import Config
from habilis.learning.presets import PRESETS

SEED = 20_261_127
COMMON, DRAWN = 30, 6
_STRUCTURES = 14

Setting = dict[str, Any]
"""Fields of `Config`, those of the algorithm among them."""

_COMMON: Setting = {
    "envs": 8,
    "rollout": 20,
    "hidden": (64, 64),
    "networks": "shared",
    "activation": "tanh",
    "initialisation": "lecun",
    "observation": "one-hot",
    "normalise": False,
    "unbiased": False,
    "schedule": "steps",
}


def structures() -> list[Setting]:
    """Those with many settings first."""
    random = np.random.default_rng([SEED, 0])
    found = [_COMMON | {"optimizer": name} for name in ("adam", "rmsprop")]
    while len(found) < 2 + _STRUCTURES:
        drawn = _structure(random)
        if drawn not in found:
            found.append(drawn)
    return found


def settings() -> list[Setting]:
    """All of them; a setting is known by its place in this list."""
    found = []
    for number, structure in enumerate(structures()):
        random = np.random.default_rng([SEED, 1, number])
        found += [
            structure | _numbers(structure, random) for _ in range(DRAWN if number > 1 else COMMON)
        ]
    found += [dict(fields) for fields in PRESETS.values()]
    for setting in found:
        Config.from_dict(setting)  # which refuses what is none
    return found


def parts() -> list[list[int]]:
    """The settings by their structures, and the presets: what one process trains."""
    sizes = [COMMON] * 2 + [DRAWN] * _STRUCTURES + [len(PRESETS)]
    ends = np.cumsum(sizes)
    return [list(range(end - size, end)) for size, end in zip(sizes, ends, strict=True)]


def _structure(random: np.random.Generator) -> Setting:
    batches = ((8, 20), (16, 5), (4, 32), (1, 64), (1, 0))
    envs, rollout = _one(random, batches, (0.3, 0.2, 0.3, 0.1, 0.1))
    forms = (("tanh", "lecun"), ("tanh", "orthogonal"), ("relu", "orthogonal"), ("selu", "pytorch"))
    activation, initialisation = _one(random, forms, (0.4, 0.2, 0.2, 0.2))
    normalise = _one(random, (False, True), (0.75, 0.25))
    return {
        "envs": envs,
        "rollout": rollout,
        "hidden": _one(random, ((64, 64), (128,))),
        "networks": _one(random, ("shared", "separate")),
        "activation": activation,
        "initialisation": initialisation,
        "observation": _one(random, ("one-hot", "coordinates"), (0.75, 0.25)),
        "normalise": normalise,
        "unbiased": normalise,
        "schedule": _one(random, ("steps", "episodes"), (0.75, 0.25)),
        "optimizer": _one(random, ("adam", "rmsprop", "rmsprop-torch"), (0.5, 0.25, 0.25)),
    }


def _numbers(structure: Setting, random: np.random.Generator) -> Setting:
    """Hyperparameters that may differ within a structure."""
    falls = random.random() < 0.75
    entropy = _between(random, *((0.05, 0.5) if falls else (0.005, 0.06)))
    span = (1e6, 6e6) if structure["schedule"] == "steps" else (1e4, 6e4)
    limits = (50, 100, 150, 200, 300, 500)
    limit = _one(random, limits, (0.1, 0.18, 0.18, 0.18, 0.18, 0.18))
    return {
        "algorithm": "a2c",
        "learning_rate": _between(random, 3e-4, 2e-3),
        "entropy": entropy,
        "entropy_end": 0.0 if falls else entropy,
        "entropy_steps": int(_between(random, *span)) if falls else 0,
        "entropy_hold": 0,
        "discount": _one(random, (0.99, 0.97), (0.75, 0.25)),
        "gae_lambda": _one(random, (1.0, 0.95)),
        "reward_scale": _one(random, (1.0, 0.3, 0.1), (0.6, 0.2, 0.2)),
        "clip": _one(random, (0.5, 5.0, 40.0)),
        "value": _one(random, (0.5, 1.0)),
        "episode_limit": max(limit, structure["rollout"]),
        "limit_is_terminal": _one(random, (False, True), (0.75, 0.25)),
    }


def _one(random: np.random.Generator, values: tuple, shares: tuple | None = None) -> Any:
    return values[random.choice(len(values), p=shares)]


def _between(random: np.random.Generator, least: float, most: float) -> float:
    """Uniform in the logarithm, to three digits."""
    return float(f"{np.exp(random.uniform(np.log(least), np.log(most))):.3g}")


if __name__ == "__main__":
    for number, setting in enumerate(settings()):
        print(number, setting)
