"""Learners that others have published, by name.

Those of Graesser and Keng, *Foundations of Deep Reinforcement Learning* (2019), which the paper
cites for A2C, have the values of the specifications in its library, SLM-Lab 4.1.1
(`slm_lab/spec`), and its semantics: separate networks, each with an optimiser and a clip of its
own; PyTorch's RMSprop; advantages standardised with the unbiased deviation over the whole batch;
the time limit treated as terminal. What they say of their environments is left out: the lander's
four frames in one observation, and budgets.
"""

from typing import Any

from habilis.learning.config import Config

_BOOK: dict[str, Any] = {
    "algorithm": "a2c",
    "networks": "separate",
    "entropy_steps": 0,
    "entropy_hold": 0,
    "entropy_end": 0.0,
    "discount": 0.99,
    "gae_lambda": 0.95,
    "normalise": True,
    "unbiased": True,
    "reward_scale": 1.0,
    "limit_is_terminal": True,
}
_LANDER: dict[str, Any] = _BOOK | {
    "envs": 8,
    "rollout": 128,
    "hidden": (64, 64, 32),
    "activation": "relu",
    "initialisation": "orthogonal",
    "optimizer": "adam",
    "learning_rate": 2e-3,
    "entropy": 0.01,
    "value": 1.0,
    "clip": 0.5,
}

PRESETS: dict[str, dict[str, Any]] = {
    # benchmark/a2c/a2c_gae_cartpole.json
    "book-cartpole": _BOOK
    | {
        "envs": 4,
        "rollout": 32,
        "hidden": (64,),
        "activation": "selu",
        "initialisation": "pytorch",
        "optimizer": "rmsprop-torch",
        "learning_rate": 5e-3,
        "entropy": 0.001,
        "value": 0.5,
        "clip": 0.5,
    },
    # benchmark/a2c/a2c_gae_lunar.json
    "book-lander-gae": _LANDER,
    # benchmark/a2c/a2c_nstep_lunar.json, in which n = 5 takes the place of its rollout of 64
    "book-lander-nstep": _LANDER
    | {"rollout": 5, "gae_lambda": 1.0, "normalise": False, "unbiased": False},
    # experimental/misc/gridworld.json; its 1,000 frames are a budget, not an episode's limit
    "book-gridworld": _BOOK
    | {
        "envs": 1,
        "rollout": 0,
        "hidden": (200,),
        "activation": "sigmoid",
        "initialisation": "pytorch",
        "optimizer": "adam",
        "learning_rate": 0.01,
        "learning_rate_decay": 0.9,
        "learning_rate_every": 500,
        "entropy": 0.0,
        "value": 1.0,
        "clip": 0.0,
        "discount": 0.999,
        "gae_lambda": 0.97,
    },
}
"""Fields of `Config`, those of the algorithm among them, by the preset's name."""


def preset(name: str, **changes: Any) -> Config:
    """A configuration with a published learner.

    Those of Graesser and Keng (2019): "book-cartpole" and "book-lander-gae" learn from generalised
    advantages, "book-lander-nstep" from 5-step returns, "book-gridworld" once an episode.

    Args:
        name: of `PRESETS`.
        **changes: other fields of `Config` or of A2C; they take precedence.

    Returns:
        The configuration.

    Raises:
        ValueError: no such preset, or a field does not exist or is out of its range.

    Example:
        >>> preset("book-cartpole", world="yard").algorithm.activation
        'selu'
    """
    return Config.from_dict(with_preset(name, changes))


def with_preset(name: Any, given: dict[str, Any]) -> dict[str, Any]:
    """The fields that a preset sets, and those given, which take precedence.

    Raises:
        ValueError: no such preset, or it is one of another algorithm.
    """
    if not isinstance(name, str) or name not in PRESETS:
        raise ValueError(f"preset {name!r} is unknown; use one of {', '.join(PRESETS)}")
    of, wanted = PRESETS[name]["algorithm"], given.get("algorithm")
    if wanted not in (None, of):
        raise ValueError(
            f"preset {name!r} is for algorithm {of!r}, not {wanted!r}; leave out one of the two"
        )
    return PRESETS[name] | given
