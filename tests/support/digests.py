"""Tables and runs as short digests, by which they are compared with those of an earlier edition."""

import hashlib

import numpy as np

import habilis as hb
from habilis.mdp import TabularMDP


def digest(*arrays: object) -> str:
    """Of the content, shapes and types of arrays and plain values."""
    reported = hashlib.sha256()
    for one in arrays:
        if isinstance(one, np.ndarray):
            reported.update(f"{one.dtype.str} {one.shape}".encode())
            reported.update(np.ascontiguousarray(one).tobytes())
        else:
            reported.update(repr(one).encode())
    return reported.hexdigest()[:16]


def table_digest(mdp: TabularMDP) -> str:
    """Of all that a table says, factors and flags in their order."""
    where = mdp.transitions
    leads = [where] if isinstance(where, np.ndarray) else [where.data, where.indices, where.indptr]
    named = [*mdp.factors.items(), *mdp.flags.items()]
    labels = [part for name, label in named for part in (name, label)]
    rest = (mdp.start, mdp.shape, mdp.actions)
    return digest(*leads, mdp.reward, mdp.terminal, *labels, *rest)


def bits_digest(mdp: TabularMDP) -> str:
    """Of the bits of all states over the object and over everything, to nine decimals."""
    bits = [hb.empowerment(mdp, horizon, name) for horizon, name in ((3, "object"), (2, "state"))]
    return digest(*(np.round(one, 9) + 0.0 for one in bits))


def run_digest(**settings: object) -> tuple[str, list[list[float]]]:
    """Of the episodes of a short training, and of each learned array its mean and its length.

    The episodes are whole numbers. What is learned is not the same to the last bit on every
    processor, so of it there are numbers to compare.
    """
    import jax

    short = {"episode_limit": 100, "runs": 2, "hidden": (16,)}
    config = hb.Config.from_dict({"world": "yard"} | short | settings)
    run = hb.train(config)
    columns = [run.episodes[name].to_numpy() for name in run.episodes.columns]
    learned = [np.asarray(leaf, np.float64) for leaf in jax.tree.leaves(run.parameters)]
    reported = [[float(leaf.mean()), float(np.linalg.norm(leaf))] for leaf in learned]
    return digest(*run.episodes.columns, *columns), reported
