"""Enumerated tables, cached on disk: stepping through every state takes seconds."""

import inspect
import sys
from dataclasses import replace
from typing import Any

import numpy as np

from habilis.bridges.gymnasium.access import access
from habilis.bridges.gymnasium.enumeration import Enumerated, action_count, enumerate_states
from habilis.bridges.gymnasium.identity import view
from habilis.bridges.gymnasium.replays import LEAST_SECONDS
from habilis.bridges.gymnasium.snapshots import Access, Identity, layers
from habilis.bridges.gymnasium.verification import follows, verified
from habilis.cache import Arrays, fingerprint, kept
from habilis.mdp import TabularMDP

_EDITION = 3  # of the cached arrays: raise it when they change
_COMPILED = ("builtins", "numpy", "pygame", "collections")  # known by their versions
_FACTOR = "factor "


def kept_states(env: Any, max_states: int, seed: int | None, identity: Identity) -> Enumerated:
    """The table of an environment by enumeration; the second time from the disk.

    The cache's key is made of the first state, the wrappers, and the source of the modules of all
    their classes. Since a table from the disk could still be that of other code (of a function that
    these call, say), it is verified by as many replays as a new one.

    Args:
        env, max_states, seed: as in `TabularMDP.from_gymnasium`.
        identity: what makes two states the same; with functions of the user's, nothing is cached.

    Returns:
        The table, without snapshots of its states.

    Raises:
        ValueError: as in `TabularMDP.from_gymnasium`.
    """
    with access(env, seed, identity) as states:

        def compute() -> Arrays:
            found = enumerate_states(states, action_count(env), max_states, None, False)
            verified(states, found, env, identity)
            return _arrays(found)

        code = _code(env)
        if code is None or identity.key is not None or identity.state is not None:
            return _enumerated(compute())
        begin = view(states.begin(), strict=False).digest
        name = fingerprint(
            *("states", _EDITION, begin, states.first.seen.digest, code, max_states),
            *(action_count(env), tuple(identity.ignore)),
        )
        return _enumerated(kept(name, compute, accept=lambda arrays: _agrees(states, env, arrays)))


def _agrees(states: Access, env: Any, arrays: Arrays) -> bool:
    """Whether an environment follows a table from the disk."""
    seconds = max(float(arrays["seconds"]), LEAST_SECONDS)
    return follows(states, _enumerated(arrays), env, seconds)


def _code(env: Any) -> str | None:
    """The source of the modules of all classes in an environment and its wrappers.

    Returns:
        A fingerprint; `None` where a source cannot be read.
    """
    classes = {cls for layer in layers(env) for cls in view(layer, strict=False).classes}
    modules = {base.__module__ for cls in classes for base in cls.__mro__[:-1]}
    parts = []
    try:
        for layer in layers(env):
            inspect.getsource(type(layer))
    except (OSError, TypeError):
        return None
    for name in sorted(modules):
        package = sys.modules.get(name.partition(".")[0])
        try:
            source = inspect.getsource(sys.modules[name])
        except (KeyError, OSError, TypeError):
            if name.partition(".")[0] not in _COMPILED:
                return None
            source = ""
        parts.append((name, getattr(package, "__version__", ""), source))
    return fingerprint(parts)


def _arrays(found: Enumerated) -> Arrays:
    mdp = found.mdp
    digests = b"".join(digest for digest, _ in found.marks)
    return {
        "next_state": mdp.next_state,
        "reward": mdp.reward,
        "terminal": mdp.terminal,
        "digests": np.frombuffer(digests, np.uint8).reshape(mdp.states, -1),
        "observed": found.observed,
        "parent": found.parent,
        "action": found.action,
        "seconds": np.array(found.seconds),
        "actions": np.array(mdp.actions, np.str_),
        **{_FACTOR + name: labels for name, labels in mdp.factors.items()},
    }


def _enumerated(arrays: Arrays) -> Enumerated:
    mdp = TabularMDP.deterministic(arrays["next_state"], arrays["reward"], arrays["terminal"])
    factors = {
        name.removeprefix(_FACTOR): labels
        for name, labels in arrays.items()
        if name.startswith(_FACTOR)
    }
    mdp = replace(mdp, factors=factors, actions=tuple(arrays["actions"].tolist()))
    marks = [
        (row.tobytes(), bool(ended))
        for row, ended in zip(arrays["digests"], mdp.terminal, strict=True)
    ]
    paths = (arrays["observed"], arrays["parent"], arrays["action"])
    return Enumerated(mdp, marks, [], *paths, seconds=0.0)
