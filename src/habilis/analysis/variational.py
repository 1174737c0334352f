"""The variational bound on empowerment, whose value is known exactly, and with it what it misses.

For a source w of action sequences and a decoder q, which guesses the sequence from the outcome,

    B = H(w) + E[log2 q(A^h | s, O)] = I(A^h; O | s) - E[D(p(A^h | s, O) || q(A^h | s, O))]

with p(a^h | s, o) the posterior of w: the best decoder. Sequences are listed as
`itertools.product(actions, repeat=h)` does: the last action varies fastest.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from jaxtyping import Bool, Float64, Int64
from numpy.typing import ArrayLike

from habilis.empowerment.api import empowerment
from habilis.empowerment.arguments import at_least_one, chosen_actions, chosen_states
from habilis.empowerment.combined import check_single
from habilis.empowerment.methods import Exact, checked_method
from habilis.empowerment.one_step import last_observations, moves_of
from habilis.empowerment.sensors import Sensor
from habilis.mdp import TabularMDP
from habilis.probabilities import as_array, row_stochastic, shape_of
from habilis.reprs import counted, short, unfailing

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Bits = Float64[np.ndarray, "n"]

_EXACT = Exact()
_MOST = 4_000_000  # sequences of all states asked about
_ENTRIES = 100_000_000  # of their channels that are not 0
_CERTAIN = 1e-12  # by how much the sum of a row may miss 1
_LN2 = float(np.log(2))


@dataclass(frozen=True)
class VariationalBound:
    """A variational bound on the empowerment of n states, in bits, and what it bounds.

    Attributes:
        bits: float64[n], B, the bound; it may be below 0, and is minus infinity where the decoder
            excludes a sequence that has led to what it sees.
        information: float64[n], I(A^h; O | s) of the source, which the best decoder attains.
        empowerment: float64[n], the maximum of the information over sources.
        empowerment_gap: float64[n], how much larger that can be (0 where nothing is noisy).
    """

    bits: Bits
    information: Bits
    empowerment: Bits
    empowerment_gap: Bits

    @property
    def decoder_gap(self) -> Bits:
        """What a better decoder would add: the mean divergence of the posterior from it."""
        return self.information - self.bits

    @property
    def source_gap(self) -> Bits:
        """What a better source would add, with the best decoder of each; to within its gap."""
        return self.empowerment - self.information

    @unfailing
    def __repr__(self) -> str:
        bound, most = float(self.bits.mean()), float(self.empowerment.mean())
        return short(
            "VariationalBound",
            f"{bound:.4f} of {most:.4f} bits",
            f"mean of {counted(len(self.bits), 'state')}",
        )


def variational_bound(
    mdp: TabularMDP,
    horizon: int,
    source: ArrayLike | Literal["uniform"] = "uniform",
    decoder: ArrayLike | None = None,
    sensor: Sensor = "state",
    states: Any = None,
    *,
    actions: ArrayLike | None = None,
    method: Exact = _EXACT,
) -> VariationalBound:
    """The variational lower bound on empowerment, and its gaps.

        B(s) = E[log2 q(A^h | s, O) - log2 w(A^h | s)] <= I(A^h; O | s) <= E_h(s)

    with A^h drawn from the source w and O what it leads to (the bound of Barber and Agakov 2003,
    which Mohamed and Rezende 2015 maximise over w and q, both networks). The first gap is the mean
    divergence of the true posterior from the decoder, the second is the source's.

    Args:
        mdp: the table, of few actions: each of its sequences is listed.
        horizon: h, how many actions, 1 or more.
        source: w, float[n, A^h], or float[A^h] for all states; or "uniform", over the sequences
            that can surely be carried out. Sequences are in the order of
            `itertools.product(actions, repeat=h)`: the last action varies fastest.
        decoder: q, float[n, O, A^h], or float[O, A^h] for all states, a distribution over sequences
            for each observation: a state, the rank of a factor's label among those that it has, or
            a column of a noisy sensor. A row of zeros stands for what never happens. By default
            the best, the posterior of the source: the bound is the information.
        sensor: as in `empowerment`, one alone.
        states: the n states asked about, as indices or as bool[S]; by default all.
        actions: the A action indices that sequences are made of; by default all.
        method: `Exact`, with its settings, for the empowerment.

    Returns:
        The bound, the information of the source, and the empowerment with its certificate.

    Raises:
        ValueError: as in `empowerment`; more than 4,000,000 sequences of all states together; or a
            source or a decoder that is no such distribution, or a source that draws sequences that
            cannot surely be carried out.

    Example:
        >>> ring = TabularMDP.deterministic([[(s - 1) % 9, (s + 1) % 9] for s in range(9)])
        >>> found = variational_bound(ring, 2, states=[0])
        >>> found.bits, found.source_gap.round(3)
        (array([1.5]), array([0.085]))
        >>> blind = np.full((9, 4), 1 / 4)
        >>> variational_bound(ring, 2, decoder=blind, states=[0]).bits
        array([0.])
    """
    horizon, used, starts = (
        at_least_one("horizon", horizon),
        chosen_actions(mdp, actions),
        chosen_states(mdp, states),
    )
    check_single(mdp, sensor)
    method = checked_method(method, [Exact])
    sequences = len(used) ** horizon
    if sequences * len(starts) > _MOST:
        raise ValueError(
            f"{len(used)}^{horizon} sequences of {counted(len(starts), 'state')} are "
            f"{sequences * len(starts):,}, above {_MOST:,}; give a shorter horizon, fewer actions "
            "or fewer states"
        )
    channel = _channel(mdp, horizon, sensor, used, starts)
    sure = abs(np.asarray(channel.sum(axis=1)) - 1) < _CERTAIN
    weights = _source(source, sure.reshape(len(starts), -1))
    joint, decoded = _joint(channel, weights), None
    if decoder is not None:
        decoded = _decoder(decoder, len(starts), shape_of(channel)[1], sequences)
    information, bits = _values(joint, weights, decoded, shape_of(channel)[1])
    most, gap = empowerment(mdp, horizon, sensor, used, starts, method=method, return_gap=True)
    return VariationalBound(bits, information, most, gap)


def _channel(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor,
    actions: Int64[np.ndarray, "A"],
    starts: Int64[np.ndarray, "n"],
) -> "csr_array":
    """The probabilities of observations, float64[n * A^h, O]; less than 1 where one is lacking."""
    from scipy.sparse import csr_array, vstack

    moves, seen = moves_of(mdp.transitions), last_observations(mdp, sensor)
    count = len(starts)
    rows = csr_array((np.ones(count), starts, np.arange(count + 1)), (count, mdp.states))
    for step in range(horizon):
        last = moves if step < horizon - 1 else seen
        each = [rows @ last[a :: mdp.action_count] for a in actions.tolist()]
        many = shape_of(rows)[0]
        order = np.arange(len(actions) * many).reshape(len(actions), many).T.ravel()
        rows = csr_array(vstack(each, format="csr"))[order]
        if rows.nnz > _ENTRIES:
            raise ValueError(
                f"the channel of all sequences has {rows.nnz:,} probabilities after {step + 1} of "
                f"{horizon} actions, above {_ENTRIES:,}; give a shorter horizon or fewer states"
            )
    return rows


def _source(
    source: ArrayLike | Literal["uniform"], sure: Bool[np.ndarray, "n K"]
) -> Float64[np.ndarray, "n K"]:
    """The source's probabilities; none where no sequence can surely be carried out."""
    if isinstance(source, str):
        if source != "uniform":
            raise ValueError(f"source is {source!r}; give 'uniform' or float[n, A^h]")
        return sure / np.maximum(sure.sum(axis=1, keepdims=True), 1)
    given = as_array("source", source)
    given = given[None].repeat(len(sure), axis=0) if given.ndim == 1 else given
    if given.shape != sure.shape:
        raise ValueError(
            f"source has shape {given.shape}; give float[states, sequences], here {sure.shape}"
        )
    weights = row_stochastic("source", given, "row {}", "states").toarray()
    outside = np.argwhere((weights > 0) & ~sure)
    if len(outside):
        row, sequence = outside[0]
        raise ValueError(
            f"source, row {row} has {weights[row, sequence]:g} for sequence {sequence}, which "
            "cannot surely be carried out there; give 0"
        )
    return weights


def _decoder(
    decoder: ArrayLike, count: int, outputs: int, sequences: int
) -> Float64[np.ndarray, "m O K"]:
    """The decoder's probabilities, of each state or of one for all."""
    given = as_array("decoder", decoder)
    given = given[None] if given.ndim == 2 else given
    wanted = count, outputs, sequences
    if given.ndim != 3 or given.shape[1:] != wanted[1:] or len(given) not in (1, count):
        raise ValueError(
            f"decoder has shape {given.shape}; give float[states, observations, sequences], here "
            f"{wanted}"
        )
    flat = row_stochastic(
        "decoder", given.reshape(-1, sequences), "row {}", "observations", empty=True
    )
    return flat.toarray().reshape(given.shape)


def _joint(channel: "csr_array", weights: Float64[np.ndarray, "n K"]) -> "csr_array":
    """The probabilities of sequence and observation together, float64[n * K, O]."""
    joint = channel.copy()
    joint.data *= np.repeat(weights.ravel(), np.diff(joint.indptr))
    joint.eliminate_zeros()
    return joint


def _values(
    joint: "csr_array",
    weights: Float64[np.ndarray, "n K"],
    decoded: Float64[np.ndarray, "m O K"] | None,
    outputs: int,
) -> tuple[Bits, Bits]:
    """The information, and the bound."""
    count, sequences = weights.shape
    row = np.repeat(np.arange(count * sequences), np.diff(joint.indptr))
    state, sequence = np.divmod(row, sequences)
    seen = np.bincount(state * outputs + joint.indices, joint.data, count * outputs)
    given = weights[state, sequence]

    def mean(guess: Float64[np.ndarray, "k"]) -> Bits:
        with np.errstate(divide="ignore"):
            terms = joint.data * (np.log(guess) - np.log(given))
        return np.bincount(state, terms, count) / _LN2

    posterior = joint.data / seen[state * outputs + joint.indices]
    information = np.maximum(mean(posterior), 0)
    if decoded is None:
        return information, information
    which = state if len(decoded) > 1 else np.zeros_like(state)
    return information, mean(decoded[which, joint.indices, sequence])
