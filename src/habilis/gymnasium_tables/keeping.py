"""Enumerated tables, kept on disk: looking into every state of an environment takes seconds."""

import inspect
import sys
from dataclasses import replace
from typing import Any

import numpy as np

from habilis.cache import Arrays, fingerprint, kept
from habilis.gymnasium_tables.access import access
from habilis.gymnasium_tables.enumeration import Enumerated, action_count, enumerate_states
from habilis.gymnasium_tables.identity import view
from habilis.gymnasium_tables.snapshots import Access, Identity, layers
from habilis.gymnasium_tables.verification import follows, verified
from habilis.mdp import TabularMDP

_EDITION = 2  # of what is kept: to be raised when it becomes another
_SECONDS = 0.5  # of replays with which a table from the disk is tried
_FACTOR = "factor "


def kept_states(env: Any, max_states: int, seed: int | None, identity: Identity) -> Enumerated:
    """The table of an environment by enumeration; the second time from the disk.

    What is kept goes by the first state, the wrappers, and the source of their classes. Since a
    table from the disk could be that of other code still, it is tried by replays first.

    Args:
        env, max_states, seed: as in `TabularMDP.from_gymnasium`.
        identity: what makes two states the same; with functions of the user's, nothing is kept.

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
    """Whether an environment does what a table from the disk says."""
    return follows(states, _enumerated(arrays), env, _SECONDS)


def _code(env: Any) -> str | None:
    """What the classes of an environment and its wrappers are made of; `None` if not readable."""
    parts = []
    for cls in (cls for layer in layers(env) for cls in type(layer).__mro__[:-1]):
        package = sys.modules.get(cls.__module__.partition(".")[0])
        try:
            source = inspect.getsource(cls)
        except (OSError, TypeError):
            return None
        parts.append((cls.__qualname__, getattr(package, "__version__", ""), source))
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
