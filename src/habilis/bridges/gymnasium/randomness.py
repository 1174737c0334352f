"""The random generators that a step may draw from: Python's, NumPy's, an environment's own."""

import random
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np


def states_of(generators: Iterable[Any]) -> list[Any]:
    """The states of generators: equal while none has drawn."""
    return [_comparable(_state(generator)) for generator in generators]


def global_states() -> list[Any]:
    """The states of Python's and NumPy's own generators."""
    return [random.getstate(), *states_of([np.random.mtrand._rand])]  # type: ignore[attr-defined]


def reseed(generators: Sequence[Any], seed: int) -> None:
    """Seeds Python's, NumPy's and the given generators, each differently."""
    words = np.random.SeedSequence(seed).generate_state(len(generators) + 2).tolist()
    random.seed(words.pop())
    np.random.seed(words.pop())
    for generator, word in zip(generators, words, strict=True):
        if isinstance(generator, np.random.RandomState | random.Random):
            generator.seed(word)
        else:
            bits = getattr(generator, "bit_generator", generator)
            bits.state = type(bits)(word).state


@contextmanager
def left_alone(generators: Sequence[Any] = ()) -> Iterator[None]:
    """Puts Python's, NumPy's and the given generators back as they were, in the end."""
    every = [np.random.mtrand._rand, *generators]  # type: ignore[attr-defined]
    python, others = random.getstate(), [_state(one) for one in every]
    try:
        yield
    finally:
        random.setstate(python)
        for generator, state in zip(every, others, strict=True):
            _set(generator, state)


def _state(generator: Any) -> Any:
    if isinstance(generator, random.SystemRandom):
        return None  # it has no state: replays find out what depends on it
    if isinstance(generator, random.Random):
        return generator.getstate()
    if isinstance(generator, np.random.RandomState):
        return generator.get_state(legacy=False)
    return getattr(generator, "bit_generator", generator).state


def _set(generator: Any, state: Any) -> None:
    if isinstance(generator, random.Random):
        if state is not None:
            generator.setstate(state)
    elif isinstance(generator, np.random.RandomState):
        generator.set_state(state)
    else:
        getattr(generator, "bit_generator", generator).state = state


def _comparable(state: Any) -> Any:
    if isinstance(state, dict):
        return {name: _comparable(part) for name, part in state.items()}
    return state.tobytes() if isinstance(state, np.ndarray) else state
